#include <set>
#include <string>
#include <typeindex>

#include "ch5_backend/solve/block_solver.h"

namespace ch5 {
namespace {

constexpr int kChunk = 256;  // edges or vertices a task

}  // namespace

BlockSolverBase::BlockSolverBase(Graph* graph, int threads)
    : graph_(graph), pool_(threads), reduced_solver_(MakeCholesky(threads)) {}

void BlockSolverBase::SetOrdering() {
  structure_ = BuildBlockStructure(*graph_);
  CheckDimensions();
  FindNumericJacobians();
  const BlockStructure& s = structure_;
  const auto zeros = [](int n, std::vector<double>* values) { values->assign(static_cast<size_t>(n), 0.0); };
  zeros(s.num_linear_values, &linear_);
  zeros(s.num_H_pm_values, &H_pm_);
  zeros(s.num_H_mm_values, &H_mm_);
  zeros(s.num_H_mm_values, &H_mm_inverse_);
  zeros(s.num_H_mm_values, &H_mm_factor_);
  H_pp_.SetPattern(s.pose_dim, s.H_pp_pattern);
  S_.SetPattern(s.pose_dim, s.schur_pattern);
  reduced_solver_->Prepare(S_);
  b_.setZero(s.Size());
  for (VecX* v : {&b_schur_, &pose_scale_, &delta_poses_}) v->setZero(s.ordering.dim_poses);
  H_mm_inverse_b_.setZero(s.ordering.dim_landmarks);
}

void BlockSolverBase::CheckDimensions() const {
  const auto check = [](const std::vector<Vertex*>& vertices, int dimension, const char* role) {
    for (const Vertex* vertex : vertices) {
      if (dimension == Eigen::Dynamic || vertex->LocalDimension() == dimension) continue;
      throw GraphError("BlockSolver: " + vertex->TypeInfo() + " " + std::to_string(vertex->Id()) + " has " +
                       std::to_string(vertex->LocalDimension()) + " degrees of freedom, but this solver is made for " +
                       role + " with " + std::to_string(dimension));
    }
  };
  check(structure_.poses, PoseDimension(), "poses");
  check(structure_.landmarks, LandmarkDimension(), "landmarks");
}

// One edge of each type tells whether the type brings its own Jacobians.
void BlockSolverBase::FindNumericJacobians() {
  linearize_in_parallel_ = true;
  if (pool_.Threads() == 1) return;
  std::set<std::type_index> seen;
  for (int e = 0; e < structure_.num_active_edges; ++e) {
    Edge& edge = *structure_.edges[e].edge;
    if (!seen.insert(typeid(edge)).second) continue;
    edge.ComputeResidual();
    edge.ComputeJacobians();
    if (edge.HasNumericJacobians()) linearize_in_parallel_ = false;
  }
}

double BlockSolverBase::ComputeChi() {
  const auto cost = [this](int begin, int end) {
    double sum = 0.0;
    for (int e = begin; e < end; ++e) {
      Edge& edge = *structure_.edges[e].edge;
      edge.ComputeResidual();
      sum += edge.RobustChi2();
    }
    return sum;
  };
  return 0.5 * ParallelSum(&pool_, static_cast<int>(structure_.edges.size()), kChunk, &parts_, cost);
}

void BlockSolverBase::UpdateStates(const VecX& delta_x) {
  for (const auto* vertices : {&structure_.poses, &structure_.landmarks}) {
    ParallelFor(&pool_, static_cast<int>(vertices->size()), kChunk, [&](int begin, int end) {
      for (int i = begin; i < end; ++i) {
        Vertex& vertex = *(*vertices)[i];
        vertex.BackUpParameters();
        vertex.Plus(delta_x.data() + vertex.OrderingId());
      }
    });
  }
}

void BlockSolverBase::RollbackStates() {
  for (Vertex* vertex : structure_.poses) vertex->RollBackParameters();
  for (Vertex* vertex : structure_.landmarks) vertex->RollBackParameters();
}

double BlockSolverBase::StateNorm() const {
  double sum = 0.0;
  for (const Vertex* vertex : structure_.poses) sum += vertex->Parameters().squaredNorm();
  for (const Vertex* vertex : structure_.landmarks) sum += vertex->Parameters().squaredNorm();
  return std::sqrt(sum);
}

VecX BlockSolverBase::HessianDiagonal() const {
  const BlockStructure& s = structure_;
  VecX diagonal(s.Size());
  if (!s.poses.empty()) diagonal.head(s.ordering.dim_poses) = H_pp_.Diagonal();
  for (size_t l = 0; l < s.landmarks.size(); ++l) {
    const int dim = s.landmark_dim[l];
    for (int i = 0; i < dim; ++i) diagonal[s.landmark_offset[l] + i] = H_mm_[s.landmark_block[l] + i * dim + i];
  }
  return diagonal;
}

MatXX BlockSolverBase::DenseHessian() const {
  const BlockStructure& s = structure_;
  MatXX H = MatXX::Zero(s.Size(), s.Size());
  if (!s.poses.empty()) H.topLeftCorner(s.ordering.dim_poses, s.ordering.dim_poses) = H_pp_.Dense();
  for (size_t l = 0; l < s.landmarks.size(); ++l) {
    const int dim = s.landmark_dim[l], row = s.landmark_offset[l];
    H.block(row, row, dim, dim) = Eigen::Map<const MatXX>(H_mm_.data() + s.landmark_block[l], dim, dim);
    for (int slot = s.landmark_slots[l]; slot < s.landmark_slots[l + 1]; ++slot) {
      const int pose = s.slot_pose[slot], pose_dim = s.pose_dim[pose];
      using Block = Eigen::Map<const MatXX, 0, Eigen::OuterStride<>>;
      const Block W(H_pm_.data() + s.slot_block[slot], pose_dim, dim, Eigen::OuterStride<>(Stride(pose_dim)));
      H.block(s.pose_offset[pose], row, pose_dim, dim) = W;
      H.block(row, s.pose_offset[pose], dim, pose_dim) = W.transpose();
    }
  }
  return H;
}

}  // namespace ch5
