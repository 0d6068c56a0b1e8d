#include "ch5_backend/sparse/sparse_optimizer.h"

#include <algorithm>

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

void SparseOptimizer::SetReducedSolver(ReducedSolverType type, const IterativeOptions& options) {
  reduced_solver_ = type;
  iterative_ = options;
  if (solver_) solver_->SetReducedSolver(type, options);
}

void SparseOptimizer::ChooseSolver() {
  const int landmark_dim = CommonDimension(*graph_, Role::kLandmark, 3);
  const int pose_dim = CommonDimension(*graph_, Role::kPose, landmark_dim == 1 ? 6 : 9);
  if (!solver_ || pose_dim != pose_dim_ || landmark_dim != landmark_dim_) {
    solver_ = std::make_unique<BlockSolverBase>(graph_, pose_dim, landmark_dim, threads_);
    pose_dim_ = pose_dim;
    landmark_dim_ = landmark_dim;
    solver_->SetReducedSolver(reduced_solver_, iterative_);
  }
  solver_->SetDamping(damping_);
  solver_->SetSinglePrecision(single_precision_);
  solver_->Select(selection_);
}

Summary SparseOptimizer::Solve(const SolveOptions& options) {
  ChooseSolver();
  return Minimize(solver_.get(), options);
}

bool SparseOptimizer::Initialize(Selection selection) {
  selection_ = std::move(selection);
  const Ordering ordering = MakeOrdering(*graph_, selection_);
  index_mapping_ = ordering.poses;
  index_mapping_.insert(index_mapping_.end(), ordering.landmarks.begin(), ordering.landmarks.end());
  active_edges_.clear();
  const auto is_free = [](const std::shared_ptr<Vertex>& vertex) { return vertex->OrderingId() >= 0; };
  for (const auto& edge : ordering.edges) {
    const auto& vertices = edge->Vertices();
    if (std::any_of(vertices.begin(), vertices.end(), is_free)) active_edges_.push_back(edge);
  }
  return !active_edges_.empty();
}

double SparseOptimizer::ActiveChi2() const {
  double sum = 0.0;
  for (const auto& edge : active_edges_) {
    edge->ComputeResidual();
    sum += edge->Chi2();
  }
  return sum;
}

int SparseOptimizer::Optimize(int iterations) {
  if (active_edges_.empty()) return -1;
  SolveOptions options;
  options.algorithm = algorithm_;
  options.max_iterations = iterations;
  options.cost_tolerance = options.gradient_tolerance = options.step_tolerance = 0.0;
  options.callback = terminate_action_;
  summary_ = Solve(options);
  switch (summary_.termination) {
    case Termination::kNothingToOptimize: return -1;
    case Termination::kLinearSolverFailed:
    case Termination::kNotFinite: return 0;
    default: return std::max(summary_.iterations, IsConverged(summary_.termination) ? 1 : 0);
  }
}

std::shared_ptr<Vertex> SparseOptimizer::FindGauge() const {
  std::shared_ptr<Vertex> gauge;
  for (const auto& vertex : graph_->Vertices()) {
    if (!gauge || vertex->LocalDimension() > gauge->LocalDimension()) gauge = vertex;
  }
  return gauge;
}

bool SparseOptimizer::GaugeFreedom() const {
  const std::shared_ptr<Vertex> gauge = FindGauge();
  if (!gauge) return false;
  const int largest = gauge->LocalDimension();
  const auto holds = [&](const std::shared_ptr<Vertex>& vertex) {
    return vertex->IsFixed() && vertex->LocalDimension() == largest;
  };
  const auto is_prior = [&](const std::shared_ptr<Edge>& edge) {
    return edge->Vertices().size() == 1 && edge->Vertices()[0]->LocalDimension() == largest &&
           edge->ResidualDimension() == largest;
  };
  const auto& vertices = graph_->Vertices();
  const auto& edges = graph_->Edges();
  return std::none_of(vertices.begin(), vertices.end(), holds) && std::none_of(edges.begin(), edges.end(), is_prior);
}

BlockSolverBase& SparseOptimizer::GetSolver() {
  ChooseSolver();
  solver_->SetOrdering();
  return *solver_;
}

}  // namespace ch5
