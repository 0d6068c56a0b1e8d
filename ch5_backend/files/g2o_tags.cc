#include "ch5_backend/files/g2o_tags.h"

#include <algorithm>

#include "ch5_backend/types/pose_graph/edge_between.h"
#include "ch5_backend/types/pose_graph/edge_sensor.h"

namespace ch5 {
namespace {

constexpr VertexKind kSE2 = VertexKind::kSE2, kXY = VertexKind::kXY, kSE3 = VertexKind::kSE3, kXYZ = VertexKind::kXYZ;
using Ends = std::vector<std::shared_ptr<Vertex>>;
using Offsets = std::vector<VecX>;
using MadeEdge = std::shared_ptr<Edge>;

template <typename T>
std::shared_ptr<T> As(const std::shared_ptr<Vertex>& vertex) {
  return std::static_pointer_cast<T>(vertex);
}

template <typename V>
std::shared_ptr<Vertex> MakeVertex(const double* x) {
  auto vertex = std::make_shared<V>(V::Estimate::Zero().eval());
  if (x) vertex->SetEstimate(Eigen::Map<const typename V::Estimate>(x));
  return vertex;
}
template <>
std::shared_ptr<Vertex> MakeVertex<VertexSE2>(const double* x) {
  return x ? std::make_shared<VertexSE2>(Vec2(x[0], x[1]), x[2]) : std::make_shared<VertexSE2>();
}
template <>
std::shared_ptr<Vertex> MakeVertex<VertexPose>(const double* x) {
  return x ? std::make_shared<VertexPose>(Qd(x[6], x[3], x[4], x[5]), Vec3(x[0], x[1], x[2]))
           : std::make_shared<VertexPose>();
}

MadeEdge BetweenInPlane(const Ends& v, const Offsets&, const double* z) {
  return std::make_shared<EdgeSE2Between>(As<VertexSE2>(v[0]), As<VertexSE2>(v[1]), Vec2(z[0], z[1]), z[2]);
}
MadeEdge BetweenInSpace(const Ends& v, const Offsets&, const double* z) {
  return std::make_shared<EdgeSE3Between>(As<VertexPose>(v[0]), As<VertexPose>(v[1]), Qd(z[6], z[3], z[4], z[5]),
                                          Vec3(z[0], z[1], z[2]));
}
// The estimates are those of the vertices, in which quaternions have length 1 and angles no turns.
template <typename Pose>
typename Pose::Estimate EstimateOf(const double* x) {
  return As<Pose>(MakeVertex<Pose>(x))->GetEstimate();
}
template <typename Pose>
MadeEdge BetweenSensors(const Ends& v, const Offsets& offsets, const double* z) {
  return std::make_shared<EdgeOffset<Pose>>(As<Pose>(v[0]), As<Pose>(v[1]), EstimateOf<Pose>(z), offsets[0],
                                            offsets[1]);
}
MadeEdge PriorOfSensor(const Ends& v, const Offsets& offsets, const double* z) {
  const Vec7 at_origin = NoOffset(static_cast<VertexPose*>(nullptr));
  if (offsets[0] == at_origin) return BetweenInSpace(v, offsets, z);
  return BetweenSensors<VertexPose>(v, {at_origin, offsets[0]}, z);
}
template <typename Pose, typename Point>
MadeEdge SeenPoint(const Ends& v, const Offsets& offsets, const double* z) {
  return std::make_shared<EdgePoint<Pose, Point>>(
      As<Pose>(v[0]), As<Point>(v[1]), Eigen::Map<const typename Point::Estimate>(z),
      offsets.empty() ? NoOffset(static_cast<Pose*>(nullptr)) : typename Pose::Estimate(offsets[0]));
}
MadeEdge SeenByUnknownSensor(const Ends& v, const Offsets&, const double* z) {
  return std::make_shared<EdgePointCalibration>(As<VertexSE2>(v[0]), As<VertexPointXY>(v[1]), As<VertexSE2>(v[2]),
                                                Vec2(z[0], z[1]));
}
MadeEdge Bearing(const Ends& v, const Offsets&, const double* z) {
  return std::make_shared<EdgeBearing>(As<VertexSE2>(v[0]), As<VertexPointXY>(v[1]), z[0]);
}
// Two points that are tied to each other cannot both be eliminated, nor need a world be told from a landmark that is fixed.
template <typename A, typename B>
MadeEdge Positions(const Ends& v, const Offsets&, const double* z) {
  constexpr int kDim = A::kDimension;
  for (const auto& vertex : v) vertex->SetRole(Role::kPose);
  return std::make_shared<EdgePositions<kDim, A, B>>(As<A>(v[0]), As<B>(v[1]),
                                                     Eigen::Map<const VectorOf<double, kDim>>(z));
}

const G2oVertexTag kVertexTags[] = {{"VERTEX_SE2", kSE2, 3, MakeVertex<VertexSE2>},
                                    {"VERTEX_XY", kXY, 2, MakeVertex<VertexPointXY>},
                                    {"VERTEX_SE3:QUAT", kSE3, 7, MakeVertex<VertexPose>},
                                    {"VERTEX_TRACKXYZ", kXYZ, 3, MakeVertex<VertexPointXYZ>}};

const G2oEdgeTag kEdgeTags[] = {
    {kEdgeSE2, {kSE2, kSE2}, 0, 3, 3, {}, BetweenInPlane},
    {"EDGE_SE2_OFFSET", {kSE2, kSE2}, 2, 3, 3, {}, BetweenSensors<VertexSE2>},
    {"EDGE_SE2_XY", {kSE2, kXY}, 0, 2, 2, {}, SeenPoint<VertexSE2, VertexPointXY>},
    {"EDGE_SE2_POINTXY_OFFSET", {kSE2, kXY}, 1, 2, 2, {}, SeenPoint<VertexSE2, VertexPointXY>},
    {"EDGE_SE2_XY_CALIB", {kSE2, kXY, kSE2}, 0, 2, 2, {}, SeenByUnknownSensor},
    {"EDGE_BEARING_SE2_XY", {kSE2, kXY}, 0, 1, 1, {}, Bearing},
    {"EDGE_POINTXY", {kXY, kXY}, 0, 2, 2, {}, Positions<VertexPointXY, VertexPointXY>},
    {"EDGE_PRIOR_SE2", {kSE2}, 0, 3, 3, {kSE2}, BetweenInPlane},
    {"EDGE_PRIOR_SE2_XY", {kSE2}, 0, 2, 2, {kXY}, Positions<VertexPointXY, VertexSE2>},
    {"EDGE_PRIOR_XY", {kXY}, 0, 2, 2, {kXY}, Positions<VertexPointXY, VertexPointXY>},

    {kEdgeSE3, {kSE3, kSE3}, 0, 7, 6, {}, BetweenInSpace},
    {"EDGE_SE3_OFFSET", {kSE3, kSE3}, 2, 7, 6, {}, BetweenSensors<VertexPose>},
    {"EDGE_SE3_TRACKXYZ", {kSE3, kXYZ}, 1, 3, 3, {}, SeenPoint<VertexPose, VertexPointXYZ>},
    {"EDGE_POINTXYZ", {kXYZ, kXYZ}, 0, 3, 3, {}, Positions<VertexPointXYZ, VertexPointXYZ>},
    {"EDGE_SE3_PRIOR", {kSE3}, 1, 7, 6, {kSE3}, PriorOfSensor},
    {"EDGE_SE3_XYZ_PRIOR", {kSE3}, 1, 3, 3, {kXYZ}, Positions<VertexPointXYZ, VertexPose>},
    {"EDGE_POINTXYZ_PRIOR", {kXYZ}, 0, 3, 3, {kXYZ}, Positions<VertexPointXYZ, VertexPointXYZ>},
};

std::vector<double> AsItIs(std::vector<double> x) { return x; }
// Of a transform, or of a pose alone: x y z roll pitch yaw → x y z qx qy qz qw.  R = R_z(yaw) R_y(pitch) R_x(roll)
std::vector<double> FromEulerAngles(std::vector<double> x) {
  for (int k = 3; k < 6; ++k)
    if (std::abs(x[k]) > 2.0 * M_PI)
      throw std::invalid_argument("roll, pitch and yaw must be in radians, got " + std::to_string(x[k]));
  const Qd q = Eigen::AngleAxisd(x[5], Vec3::UnitZ()) * Eigen::AngleAxisd(x[4], Vec3::UnitY()) *
               Eigen::AngleAxisd(x[3], Vec3::UnitX());
  x.erase(x.begin() + 3, x.begin() + 6);
  x.insert(x.begin() + 3, q.coeffs().data(), q.coeffs().data() + 4);
  return x;
}
// W weighs radians, ours half radians: vec(q) ≈ ½θ.
std::vector<double> FromToroInSpace(std::vector<double> numbers) {
  std::vector<double> x = FromEulerAngles(std::move(numbers));
  const Vec6 measure = (Vec6() << 1, 1, 1, 2, 2, 2).finished();
  const std::vector<double> w = UpperHalf(measure.asDiagonal() * FromUpperHalf(&x[7], 6) * measure.asDiagonal());
  std::copy(w.begin(), w.end(), x.begin() + 7);
  return x;
}
// xx xy yy θθ xθ yθ → xx xy xθ yy yθ θθ
std::vector<double> FromToroInPlane(std::vector<double> x) {
  const std::vector<double> toro = x;
  for (const auto& [to, from] : {std::pair(5, 7), {6, 5}, {7, 8}, {8, 6}}) x[to] = toro[from];
  return x;
}

const G2oWord kWords[] = {
    {"VERTEX2", "VERTEX_SE2", 3, false, false, AsItIs},
    {"EDGE2", kEdgeSE2, 9, false, false, FromToroInPlane},
    {"VERTEX3", "VERTEX_SE3:QUAT", 6, false, false, FromEulerAngles},
    {"EDGE3", kEdgeSE3, 27, false, false, FromToroInSpace},
    {"ODOMETRY", kEdgeSE2, 9, false, true, AsItIs},
    {"LANDMARK", "EDGE_SE2_XY", 5, true, true, AsItIs},
    {"EDGE_XY_PRIOR", "EDGE_PRIOR_XY", 5, false, false, AsItIs},
};

template <typename Row, size_t N>
const Row* Find(const Row (&rows)[N], std::string_view name) {
  const auto found = std::find_if(std::begin(rows), std::end(rows), [&](const Row& row) { return row.name == name; });
  return found == std::end(rows) ? nullptr : found;
}

}  // namespace

const G2oVertexTag* FindVertexTag(std::string_view name) { return Find(kVertexTags, name); }
const G2oVertexTag& TagOf(VertexKind kind) { return kVertexTags[static_cast<size_t>(kind)]; }
const G2oEdgeTag* FindEdgeTag(std::string_view name) { return Find(kEdgeTags, name); }
const G2oWord* FindWord(std::string_view name) { return Find(kWords, name); }
const G2oVertexTag* FindOffsetTag(std::string_view name) {
  return name == "PARAMS_SE2OFFSET" ? &TagOf(kSE2) : name == "PARAMS_SE3OFFSET" ? &TagOf(kSE3) : nullptr;
}

MatXX FromUpperHalf(const double* w, int dim) {
  MatXX W(dim, dim);
  for (int i = 0; i < dim; ++i) {
    for (int j = i; j < dim; ++j) W(i, j) = W(j, i) = *w++;
  }
  return W;
}

std::vector<double> UpperHalf(const MatXX& W) {
  std::vector<double> w;
  for (int i = 0; i < W.rows(); ++i) {
    for (int j = i; j < W.cols(); ++j) w.push_back(W(i, j));
  }
  return w;
}

MatXX FromRoot(const MatXX& R, double theta_z) {
  MatXX A = MatXX::Identity(R.rows(), R.cols());
  A.topLeftCorner<2, 2>() = Rotation2(theta_z);
  const MatXX root = MatXX(R.triangularView<Eigen::Upper>()) * A;
  return root.transpose() * root;
}

}  // namespace ch5
