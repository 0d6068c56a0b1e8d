#include "ch5_backend/sparse/sparse_optimizer.h"

#include <algorithm>

#include "ch5_backend/sparse/sparse_solver.h"

namespace ch5 {

SparseOptimizer::SparseOptimizer(Graph* graph, int threads)
    : graph_(graph), threads_(threads), solver_(std::make_unique<SparseSolver>(graph, threads)) {
  SetDamping(Damping::kDiagonal);
}

SparseOptimizer::~SparseOptimizer() = default;

void SparseOptimizer::SetDamping(Damping damping) { solver_->SetDamping(damping); }

void SparseOptimizer::SetReducedSolver(ReducedSolverType type, const IterativeOptions& options) {
  solver_->SetReducedSolver(type, options);
}

void SparseOptimizer::SetReducedSolver(std::unique_ptr<ReducedSolver> solver) {
  solver_->SetReducedSolver(std::move(solver));
}

void SparseOptimizer::Hold(std::vector<HeldDirections> held) {
  held_ = std::move(held);
  solver_->Hold(held_);
}

Summary SparseOptimizer::Solve(const SolveOptions& options) {
  const Graph::Solving solving(graph_);
  const size_t num_edges = graph_->Edges().size();
  Summary summary = Minimize(solver_.get(), options);
  if (!options.callback && graph_->Edges().size() != num_edges) {
    throw GraphError("an edge has changed the graph's edges while it was evaluated; only a callback may add some");
  }
  return summary;
}

bool SparseOptimizer::Initialize(Selection selection) {
  for (const auto& vertex : selection.vertices) {
    if (!vertex) throw GraphError("InitializeOptimization: a vertex is missing (null)");
    if (!graph_->Contains(*vertex)) {
      throw GraphError("InitializeOptimization: " + vertex->Name() + " is not in the solver's graph");
    }
  }
  selection_ = std::move(selection);
  solver_->Select(selection_);
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

SparseSolver& SparseOptimizer::GetSolver() {
  solver_->SetOrdering();
  return *solver_;
}

}  // namespace ch5
