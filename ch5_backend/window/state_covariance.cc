#include "ch5_backend/window/state_covariance.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "ch5_backend/consistency/position_yaw_prior.h"
#include "ch5_backend/marginalize/marginalize.h"
#include "ch5_backend/sparse/covariance.h"

namespace ch5 {
namespace {

// Blocks of the inverse of the landmarks' Schur complement, scaled to a unit diagonal.
class InverseBlocks {
 public:
  explicit InverseBlocks(const MarginalSystem& system)
      : kept_(system.kept),
        p_inverse_(ScalingOf(system.H).cwiseInverse()),
        ldlt_(p_inverse_.asDiagonal() * system.H * p_inverse_.asDiagonal()) {}

  // All rows of the columns of a vertex.
  MatXX Columns(const Vertex& vertex) const {
    const Eigen::Index row = RowOf(vertex), size = vertex.LocalDimension();
    MatXX columns = MatXX::Zero(p_inverse_.size(), size);
    columns.middleRows(row, size).diagonal() = p_inverse_.segment(row, size);
    return p_inverse_.asDiagonal() * ldlt_.solve(columns);
  }
  MatXX Rows(const MatXX& columns, const Vertex& vertex) const {
    return columns.middleRows(RowOf(vertex), vertex.LocalDimension());
  }
  MatXX Block(const Vertex& vertex) const { return Rows(Columns(vertex), vertex); }

 private:
  Eigen::Index RowOf(const Vertex& wanted) const {
    Eigen::Index row = 0;
    for (const auto& vertex : kept_) {
      if (vertex.get() == &wanted) break;
      row += vertex->LocalDimension();
    }
    return row;
  }

  const std::vector<std::shared_ptr<Vertex>>& kept_;
  VecX p_inverse_;
  Eigen::LDLT<MatXX> ldlt_;
};

bool IsFree(const Window& window) { return !window.prior_fixes_gauge && !window.gauge_prior; }

/// @param hold_oldest  whether position and yaw of the oldest frame are held
MarginalSystem WithoutLandmarks(const Window& window, bool hold_oldest) {
  std::vector<std::shared_ptr<Edge>> edges = window.graph.Edges();
  if (hold_oldest) {
    edges.push_back(MakePositionYawPrior(window.frames.front().pose, 1e8));
  }
  std::vector<std::shared_ptr<Vertex>> landmarks;
  for (const auto& vertex : window.graph.Vertices()) {
    if (vertex->GetRole() == Role::kLandmark) landmarks.push_back(vertex);
  }
  return EliminateVertices(edges, landmarks);
}

}  // namespace

StateCovariance CovarianceOf(const Window& window, const Frame& frame) {
  const MarginalSystem system = WithoutLandmarks(window, IsFree(window));
  const InverseBlocks inverse(system);
  StateCovariance covariance;
  if (window.prior_fixes_gauge) covariance.reference = StateCovariance::Reference::kWorld;
  const MatXX of_pose = inverse.Columns(*frame.pose), of_speed_bias = inverse.Columns(*frame.speed_bias);
  covariance.state.topLeftCorner<6, 6>() = inverse.Rows(of_pose, *frame.pose);
  covariance.state.bottomLeftCorner<9, 6>() = inverse.Rows(of_pose, *frame.speed_bias);
  covariance.state.topRightCorner<6, 9>() = covariance.state.bottomLeftCorner<9, 6>().transpose();
  covariance.state.bottomRightCorner<9, 9>() = inverse.Rows(of_speed_bias, *frame.speed_bias);
  if (!window.extrinsic->IsFixed()) covariance.extrinsic = inverse.Block(*window.extrinsic);
  if (window.extrinsic1 && !window.extrinsic1->IsFixed()) covariance.extrinsic1 = inverse.Block(*window.extrinsic1);
  if (!window.time_offset->IsFixed()) covariance.time_offset_variance = inverse.Block(*window.time_offset)(0, 0);
  return covariance;
}

MatXX CovarianceOf(const Window& window, const Vertex& vertex) {
  const MarginalSystem system = WithoutLandmarks(window, IsFree(window));
  const auto is_it = [&](const auto& kept) { return kept.get() == &vertex; };
  if (std::none_of(system.kept.begin(), system.kept.end(), is_it)) {
    throw CovarianceError("CovarianceOf: " + vertex.Name() +
                          (vertex.IsFixed()                      ? " is fixed"
                           : vertex.GetRole() == Role::kLandmark ? " is a landmark"
                                                                 : " takes no part in the window's graph"));
  }
  return InverseBlocks(system).Block(vertex);
}

std::vector<Mat66> PoseCovariances(const Window& window) {
  const MarginalSystem system = WithoutLandmarks(window, true);
  const InverseBlocks inverse(system);
  std::vector<Mat66> covariances;
  for (const Frame& frame : window.frames) covariances.emplace_back(inverse.Block(*frame.pose));
  return covariances;
}

std::optional<double> ScaleSigma(const Window& window) {
  constexpr double kLeast = 1e-3;  // [m]
  const auto way_to = [&](const Frame& frame) -> Vec3 { return frame.pose->p() - window.frames.front().pose->p(); };
  const Frame& farthest =
      *std::max_element(window.frames.begin(), window.frames.end(),
                        [&](const Frame& a, const Frame& b) { return way_to(a).norm() < way_to(b).norm(); });
  const Vec3 way = way_to(farthest);
  if (way.norm() < kLeast) return std::nullopt;
  const MarginalSystem system = WithoutLandmarks(window, IsFree(window));
  const MatXX covariance = InverseBlocks(system).Block(*farthest.pose);
  return std::sqrt(std::max(0.0, way.dot(covariance.topLeftCorner<3, 3>() * way))) / way.squaredNorm();
}

}  // namespace ch5
