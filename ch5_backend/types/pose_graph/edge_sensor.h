#pragma once
/// What a sensor on a pose measures, in space and in the plane alike. It sits at an offset T_i_s from its pose; a formula is
/// written once, for poses [x, y, θ] and points [x, y], and for poses [p, q] and points [x, y, z].
///
///   point      r = T_s⁻¹ l − z                          T_s = T_i T_i_s
///   bearing    r = wrap(atan2(y, x) − z)                of [x, y] = T_i⁻¹ l
///   transform  r = that of edge_between.h with          T_d = T_z⁻¹ T_s_i⁻¹ T_s_j
///   positions  r = p_j − p_i − z                        of points or poses, along W's axes
///
/// (Source: the public g2o types slam2d and slam3d; the sign of the bearing's r is theirs reversed.)

#include "ch5_backend/graph/auto_diff_edge.h"
#include "ch5_backend/math/transform.h"
#include "ch5_backend/types/plus_jacobian.h"
#include "ch5_backend/types/pose_graph/vertex_se2.h"

namespace ch5 {

/// The numbers of a VertexSE2 or VertexPose as a vertex stores them; the identity.
inline Vec3 NoOffset(const VertexSE2* /*kind*/) { return Vec3::Zero(); }
inline Vec7 NoOffset(const VertexPose* /*kind*/) { return (Vec7() << 0, 0, 0, 0, 0, 0, 1).finished(); }

template <typename T, int N>
using VectorOf = Eigen::Matrix<T, N, 1>;

/// T⁻¹ p in the plane.
template <typename T>
VectorOf<T, 2> SeenFrom(const VectorOf<T, 3>& pose, const VectorOf<T, 2>& point) {
  using std::cos, std::sin;
  const T c = cos(pose[2]), s = sin(pose[2]), x = point[0] - pose[0], y = point[1] - pose[1];
  return {c * x + s * y, c * y - s * x};
}
/// T_a⁻¹ T_b in the plane.
template <typename T>
VectorOf<T, 3> SeenFrom(const VectorOf<T, 3>& a, const VectorOf<T, 3>& b) {
  const VectorOf<T, 2> p = SeenFrom(a, VectorOf<T, 2>(b[0], b[1]));
  return {p[0], p[1], b[2] - a[2]};
}
/// T_a T_b in the plane.
template <typename T>
VectorOf<T, 3> Compose(const VectorOf<T, 3>& a, const VectorOf<T, 3>& b) {
  using std::cos, std::sin;
  const T c = cos(a[2]), s = sin(a[2]);
  return {a[0] + c * b[0] - s * b[1], a[1] + s * b[0] + c * b[1], a[2] + b[2]};
}

/// q of [p, q].
template <typename T>
Eigen::Quaternion<T> RotationIn(const VectorOf<T, 7>& pose) {
  return {pose[6], pose[3], pose[4], pose[5]};
}
/// T⁻¹ p in space.
template <typename T>
VectorOf<T, 3> SeenFrom(const VectorOf<T, 7>& pose, const VectorOf<T, 3>& point) {
  const VectorOf<T, 3> d = point - pose.template head<3>();
  return RotationIn(pose).conjugate() * d;
}
/// T_a⁻¹ T_b in space.
template <typename T>
VectorOf<T, 7> SeenFrom(const VectorOf<T, 7>& a, const VectorOf<T, 7>& b) {
  const VectorOf<T, 3> p_b = b.template head<3>();
  VectorOf<T, 7> ab;
  ab << SeenFrom(a, p_b), (RotationIn(a).conjugate() * RotationIn(b)).coeffs();
  return ab;
}
/// T_a T_b in space.
template <typename T>
VectorOf<T, 7> Compose(const VectorOf<T, 7>& a, const VectorOf<T, 7>& b) {
  const VectorOf<T, 3> p_b = b.template head<3>(), p = RotationIn(a) * p_b;
  VectorOf<T, 7> ab;
  ab << a.template head<3>() + p, (RotationIn(a) * RotationIn(b)).coeffs();
  return ab;
}

/// The number without its derivative.
inline double ValueOf(double x) { return x; }
template <int N>
double ValueOf(const Dual<N>& x) {
  return x.value;
}
/// The angle less whole turns, in [−π, π]; they leave the derivative alone.
template <typename T>
T WithoutTurns(const T& angle) {
  return angle + T(WrapAngle(ValueOf(angle)) - ValueOf(angle));
}
/// T_d as a residual: [p_d; θ_d], or [p_d; vec(q_d)] of the sign with w ≥ 0.
template <typename T>
VectorOf<T, 3> ResidualOf(const VectorOf<T, 3>& T_d) {
  return {T_d[0], T_d[1], WithoutTurns(T_d[2])};
}
template <typename T>
VectorOf<T, 6> ResidualOf(const VectorOf<T, 7>& T_d) {
  VectorOf<T, 6> r = T_d.template head<6>();
  if (T_d[6] < T(0.0)) r.template tail<3>() *= T(-1.0);
  return r;
}

/// A landmark at z [m] as the sensor sees it.
template <typename Pose, typename Point>
class EdgePoint : public AutoDiffEdge<EdgePoint<Pose, Point>, Point::kDimension, Pose, Point> {
  using Base = AutoDiffEdge<EdgePoint, Point::kDimension, Pose, Point>;

 public:
  EdgePoint(std::shared_ptr<Pose> i, std::shared_ptr<Point> l, const typename Point::Estimate& z,
            const typename Pose::Estimate& offset = NoOffset(static_cast<Pose*>(nullptr)))
      : Base(std::move(i), std::move(l)), z_(z), offset_(offset) {}
  template <typename T>
  VectorOf<T, Point::kDimension> Evaluate(const VectorOf<T, Pose::kDimension>& pose,
                                          const VectorOf<T, Point::kDimension>& point) const {
    const VectorOf<T, Pose::kDimension> offset = offset_.template cast<T>();
    return SeenFrom(offset, SeenFrom(pose, point)) - z_.template cast<T>();
  }
  std::string TypeInfo() const override { return "EdgePoint"; }

 private:
  typename Point::Estimate z_;
  typename Pose::Estimate offset_;
};
using EdgePointXY = EdgePoint<VertexSE2, VertexPointXY>;
using EdgePointXYZ = EdgePoint<VertexPose, VertexPointXYZ>;

/// A landmark in the plane whose sensor's pose on the robot is unknown too.
class EdgePointCalibration : public AutoDiffEdge<EdgePointCalibration, 2, VertexSE2, VertexPointXY, VertexSE2> {
 public:
  EdgePointCalibration(std::shared_ptr<VertexSE2> i, std::shared_ptr<VertexPointXY> l,
                       std::shared_ptr<VertexSE2> offset, const Vec2& z)
      : AutoDiffEdge(std::move(i), std::move(l), std::move(offset)), z_(z) {}
  template <typename T>
  VectorOf<T, 2> Evaluate(const VectorOf<T, 3>& pose, const VectorOf<T, 2>& point, const VectorOf<T, 3>& offset) const {
    return SeenFrom(offset, SeenFrom(pose, point)) - z_.cast<T>();
  }
  std::string TypeInfo() const override { return "EdgePointCalibration"; }

 private:
  Vec2 z_;
};

/// The direction z [rad] of a landmark in the plane, from the pose's x-axis counter-clockwise.
class EdgeBearing : public AutoDiffEdge<EdgeBearing, 1, VertexSE2, VertexPointXY> {
 public:
  EdgeBearing(std::shared_ptr<VertexSE2> i, std::shared_ptr<VertexPointXY> l, double z)
      : AutoDiffEdge(std::move(i), std::move(l)), z_(WrapAngle(z)) {}
  template <typename T>
  VectorOf<T, 1> Evaluate(const VectorOf<T, 3>& pose, const VectorOf<T, 2>& point) const {
    using std::atan2;
    const VectorOf<T, 2> seen = SeenFrom(pose, point);
    return VectorOf<T, 1>(WithoutTurns<T>(atan2(seen[1], seen[0]) - z_));
  }
  double z() const { return z_; }
  std::string TypeInfo() const override { return "EdgeBearing"; }

 private:
  double z_;
};

/// The transform between sensors on two poses.
template <typename Pose>
class EdgeOffset : public AutoDiffEdge<EdgeOffset<Pose>, Pose::kLocalDimension, Pose, Pose> {
  using Base = AutoDiffEdge<EdgeOffset, Pose::kLocalDimension, Pose, Pose>;

 public:
  using Estimate = typename Pose::Estimate;
  EdgeOffset(std::shared_ptr<Pose> i, std::shared_ptr<Pose> j, const Estimate& T_z, const Estimate& T_i_s,
             const Estimate& T_j_s)
      : Base(std::move(i), std::move(j)), T_i_sj_(Compose(T_i_s, T_z)), T_j_s_(T_j_s) {}
  template <typename T>
  VectorOf<T, Pose::kLocalDimension> Evaluate(const VectorOf<T, Pose::kDimension>& i,
                                              const VectorOf<T, Pose::kDimension>& j) const {
    const VectorOf<T, Pose::kDimension> measured = T_i_sj_.template cast<T>(), T_j_s = T_j_s_.template cast<T>();
    return ResidualOf(SeenFrom(measured, Compose(SeenFrom(i, j), T_j_s)));
  }
  std::string TypeInfo() const override { return "EdgeOffset"; }

  /// The transform T_i_j that it measures.
  Estimate Measurement() const { return Compose(T_i_sj_, SeenFrom(T_j_s_, NoOffset(static_cast<Pose*>(nullptr)))); }

 private:
  Estimate T_i_sj_, T_j_s_;  // that of j's sensor as measured from i, and where it sits
};

/// The difference z [m] of two positions along the world's axes.
template <int N, typename A, typename B>
class EdgePositions : public SizedEdge<N, A, B> {
  using Base = SizedEdge<N, A, B>;

 public:
  EdgePositions(std::shared_ptr<A> i, std::shared_ptr<B> j, const VectorOf<double, N>& z)
      : Base(std::move(i), std::move(j)), z_(z) {}
  void ComputeResidual() override {
    this->r_ = this->template GetVertex<1>().GetEstimate().template head<N>() -
               this->template GetVertex<0>().GetEstimate().template head<N>() - z_;
  }
  void ComputeJacobians() override {
    this->template J<0>().setIdentity();
    this->template J<0>() *= -1.0;
    this->template J<1>().setIdentity();
  }
  std::string TypeInfo() const override { return "EdgePositions"; }

 private:
  VectorOf<double, N> z_;
};

}  // namespace ch5
