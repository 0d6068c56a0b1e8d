#include "ch5_backend/solve/sparse_optimizer.h"

namespace ch5 {
namespace {

// The dimension that all free vertices of a role have, `otherwise` if there are none, or Dynamic.
int CommonDimension(const Graph& graph, Role role, int otherwise) {
  int dim = 0;
  for (const auto& vertex : graph.Vertices()) {
    if (vertex->IsFixed() || vertex->GetRole() != role) continue;
    if (dim != 0 && dim != vertex->LocalDimension()) return Eigen::Dynamic;
    dim = vertex->LocalDimension();
  }
  return dim == 0 ? otherwise : dim;
}

}  // namespace

void SparseOptimizer::ChooseSolver() {
  const int landmark_dim = CommonDimension(*graph_, Role::kLandmark, 3);
  const int pose_dim = CommonDimension(*graph_, Role::kPose, landmark_dim == 1 ? 6 : 9);
  if (!solver_ || pose_dim != pose_dim_ || landmark_dim != landmark_dim_) {
    solver_ = std::make_unique<BlockSolverBase>(graph_, pose_dim, landmark_dim, threads_);
    pose_dim_ = pose_dim;
    landmark_dim_ = landmark_dim;
    prepared_ = ReducedSolverType::kAutomatic;  // what a BlockSolver begins with
  }
  // One that is kept knows its last pattern, and need not plan anew for the same one.
  if (prepared_ != reduced_solver_ || reduced_solver_ == ReducedSolverType::kPcg) {
    int dim_poses = 0;
    for (const auto& vertex : graph_->Vertices()) {
      if (!vertex->IsFixed() && vertex->GetRole() == Role::kPose) dim_poses += vertex->LocalDimension();
    }
    solver_->SetReducedSolver(MakeReducedSolver(reduced_solver_, dim_poses, threads_));
    prepared_ = reduced_solver_;
  }
  solver_->SetDamping(damping_);
}

Summary SparseOptimizer::Solve(const SolveOptions& options) {
  ChooseSolver();
  return Minimize(solver_.get(), options);
}

BlockSolverBase& SparseOptimizer::GetSolver() {
  ChooseSolver();
  solver_->SetOrdering();
  return *solver_;
}

}  // namespace ch5
