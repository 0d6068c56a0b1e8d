#include "ch5_backend/solve/sparse_optimizer.h"

namespace ch5 {
namespace {

// The dimension that all have, `otherwise` if there are none, or Dynamic.
int CommonDimension(const std::vector<std::shared_ptr<Vertex>>& vertices, int otherwise) {
  if (vertices.empty()) return otherwise;
  const int dim = vertices.front()->LocalDimension();
  for (const auto& vertex : vertices) {
    if (vertex->LocalDimension() != dim) return Eigen::Dynamic;
  }
  return dim;
}

std::unique_ptr<BlockSolverBase> MakeSolver(Graph* graph, int pose_dim, int landmark_dim, int threads) {
  if (pose_dim == 6 && landmark_dim == 1) return std::make_unique<BlockSolver<6, 1>>(graph, threads);
  if (pose_dim == 6 && landmark_dim == 3) return std::make_unique<BlockSolver<6, 3>>(graph, threads);
  if (pose_dim == 9 && landmark_dim == 3) return std::make_unique<BlockSolver<9, 3>>(graph, threads);
  return std::make_unique<BlockSolver<Eigen::Dynamic, Eigen::Dynamic>>(graph, threads);
}

}  // namespace

Summary SparseOptimizer::Solve(const SolveOptions& options) { return Minimize(&GetSolver(), options); }

BlockSolverBase& SparseOptimizer::GetSolver() {
  const Ordering ordering = MakeOrdering(*graph_);
  const int landmark_dim = CommonDimension(ordering.landmarks, 3);
  const int pose_dim = CommonDimension(ordering.poses, landmark_dim == 1 ? 6 : 9);
  if (!solver_ || pose_dim != pose_dim_ || landmark_dim != landmark_dim_) {
    solver_ = MakeSolver(graph_, pose_dim, landmark_dim, threads_);
    pose_dim_ = pose_dim;
    landmark_dim_ = landmark_dim;
    prepared_ = ReducedSolverType::kAutomatic;  // what a BlockSolver begins with
  }
  // One that is kept knows its last pattern, and need not plan anew for the same one.
  if (prepared_ != reduced_solver_ || reduced_solver_ == ReducedSolverType::kPcg) {
    solver_->SetReducedSolver(MakeReducedSolver(reduced_solver_, ordering.dim_poses, threads_));
    prepared_ = reduced_solver_;
  }
  solver_->SetDamping(damping_);
  solver_->SetOrdering();
  return *solver_;
}

}  // namespace ch5
