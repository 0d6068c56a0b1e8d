#include "ch5_backend/sparse/sparse_solver.h"

#include <algorithm>
#include <cmath>

#include "ch5_backend/linear/elimination_plan.h"

namespace ch5 {
namespace {

constexpr int kEdges = 256, kVertices = 512;  // per task
constexpr int kPrefetchDistance = 8;          // edges or vertices that are prefetched ahead

// Then all blocks are where they were: an edge never changes its vertices.
bool IsSame(const Ordering& a, const Ordering& b) {
  return a.poses == b.poses && a.landmarks == b.landmarks && a.edges == b.edges;
}

bool NeverForms(ReducedSolverType type) {
  return type == ReducedSolverType::kImplicitPcg || type == ReducedSolverType::kPowerSeries;
}

// Whether the last digits of H make no difference to the step, so that single precision will do for H_pl.
bool IsInexact(const IterativeOptions& options) { return options.model_tolerance > 0.0 || options.tolerance >= 1e-6; }

}  // namespace

// ---- Structure --------------------------------------------------------------------------------------------------

void SparseSolver::SetOrdering() {
  has_step_ = false;
  for (const HeldDirections& held : held_) {
    if (held.vertex && !graph_->Contains(*held.vertex)) {
      throw GraphError("HeldDirections: " + held.vertex->Name() + " is not in the solver's graph");
    }
  }
  Ordering ordering = MakeOrdering(*graph_, selection_, std::move(used_ordering_));
  if (is_ordered_ && IsSame(ordering, structure_.ordering)) {
    const bool was_active = batches_.Active();
    batches_.Assign(structure_);  // a loss or W may be another one
    if (batches_.Active() == was_active) return;
  }
  is_ordered_ = false;
  Structure structure = BuildStructure(std::move(ordering));
  used_ordering_ = std::move(structure_.ordering);
  used_ordering_.Clear();
  structure_ = std::move(structure);
  const bool tied_by_landmarks_alone = structure_.H_pp_pattern.items.size() == structure_.poses.size();
  const ReducedSolverType type = ChooseReducedSolver(reduced_type_, structure_.NumPoses(), tied_by_landmarks_alone);
  pool_.Run(2, [&](int task) {  // the two know nothing of each other
    if (task == 1)
      return NeverForms(type) ? PrepareImplicitSolver(type) : PrepareReducedSolver(type, SchurPattern(structure_));
    batches_.Assign(structure_);
    const bool factored = NeverForms(type) && IsInexact(iterative_) && structure_.sizes.AreExact() &&
                          batches_.Active() && structure_.OnePoseAnEdge();
    linearized_.Resize(structure_, factored);
  });
  if (pool_.Threads() > 1) numeric_edges_.Find(EdgesInBatch(), &structure_);
  delta_poses_.setZero(structure_.ordering.dim_poses);
  step_.H_pp_delta.setZero(structure_.ordering.dim_poses);
  is_ordered_ = true;
}

void SparseSolver::PrepareImplicitSolver(ReducedSolverType type) {
  eliminated_.Resize(structure_, true);
  eliminated_.S = SymmetricBlockMatrix();
  reduced_solver_.reset();
  if (!implicit_) implicit_.emplace(type, iterative_);
  implicit_->Prepare(structure_, &pool_);
}

// A solver that is kept knows its last pattern, and need not plan again for the same one.
void SparseSolver::PrepareReducedSolver(ReducedSolverType type, const Lists& S_pattern) {
  eliminated_.Resize(structure_, false);
  eliminated_.S.SetPattern(structure_.pose_dim, S_pattern);
  implicit_.reset();
  if (!reduced_solver_) reduced_solver_ = MakeReducedSolver(type);
  reduced_solver_->Prepare(eliminated_.S, &pool_);
  groups_ = PrepareSchurGroups(structure_, eliminated_.S, pool_.Threads());
}

bool SparseSolver::SolveExactly() {
  if (!implicit_ || reduced_type_ != ReducedSolverType::kAutomatic) return false;
  const Lists S_pattern = SchurPattern(structure_);
  if (!CanFactor(S_pattern)) return false;
  PrepareReducedSolver(ReducedSolverType::kAutomatic, S_pattern);
  is_ordered_ = has_step_ = false;  // the next SetOrdering starts from scratch
  return true;
}

// Whether factoring S takes no more multiplications than the longest inexact solution, whose products take two for each number
// of H_pl. Where S itself has s numbers in n columns, any order takes s²/2n at least: a full S is not even stored.
bool SparseSolver::CanFactor(const Lists& S_pattern) const {
  const double products = iterative_.max_terms + iterative_.max_iterations;
  const double most = products * 2.0 * structure_.num_H_pl_values;
  double numbers = 0.0;
  for (int j = 0; j < structure_.NumPoses(); ++j) {
    for (const int i : S_pattern[j]) numbers += structure_.pose_dim[i] * structure_.pose_dim[j];
  }
  if (numbers * numbers / (2.0 * structure_.ordering.dim_poses) > most) return false;
  SymmetricBlockMatrix S;
  S.SetPattern(structure_.pose_dim, S_pattern);
  return PlanElimination(S).multiplications <= most;
}

void SparseSolver::SetReducedSolver(ReducedSolverType type, const IterativeOptions& options) {
  options.Validate();
  reduced_type_ = type;
  iterative_ = options;
  is_ordered_ = false;
  reduced_solver_.reset();
  implicit_.reset();
}

void SparseSolver::SetReducedSolver(std::unique_ptr<ReducedSolver> solver) {
  if (!solver) throw std::invalid_argument("SetReducedSolver: the solver is null");
  SetReducedSolver(ReducedSolverType::kDenseCholesky);  // any type that forms S
  reduced_solver_ = std::move(solver);
}

// ---- Linearized -------------------------------------------------------------------------------------------------

void SparseSolver::MakeHessian() {
  double cost;
  MakeHessianAndCost(&cost);
}

bool SparseSolver::MakeHessianAndCost(double* cost) {
  has_step_ = false;
  batches_.LoadPoses();
  numeric_edges_.Linearize(&pool_);
  *cost = Linearize(structure_, batches_, &pool_, &linearized_);
  held_poses_ = FindHeldPoses(structure_, held_);
  HoldPoses(structure_, held_poses_, &linearized_);
  return true;
}

double SparseSolver::Cost() {
  const Array<EdgeRecord>& edges = structure_.edges;
  const int in_batch = EdgesInBatch();
  batches_.LoadPoses();
  return ParallelSum(&pool_, static_cast<int>(edges.size()), kEdges, &partial_sums_, [&](int begin, int end) {
    double sum = begin < in_batch ? batches_.Cost(begin, std::min(end, in_batch)) : 0.0;
    for (int e = std::max(begin, in_batch); e < end; ++e) {
      PrefetchEdge(edges, e + kPrefetchDistance);
      edges[e].edge->ComputeResidual();
      sum += edges[e].edge->Cost();
    }
    return sum;
  });
}

// ---- Eliminated, Step -------------------------------------------------------------------------------------------

bool SparseSolver::SolveLinearSystem(double lambda, VecX* delta_x) {
  const DampingRule rule{lambda, GetDamping()};
  has_step_ = false;
  if (!InvertLandmarks(structure_, linearized_, rule, &pool_, &eliminated_)) return false;
  if (structure_.NumPoses() > 0 && !SolvePoses(rule, &delta_poses_)) return false;
  for (const auto& [pose, projection] : held_poses_) {  // what rounding has left along the held directions
    auto delta = delta_poses_.segment(structure_.pose_offset[pose], structure_.pose_dim[pose]);
    delta = (projection * delta).eval();
  }

  step_.delta_x.resize(structure_.Size());
  step_.delta_x.head(structure_.ordering.dim_poses) = delta_poses_;
  BackSubstitute(structure_, linearized_, eliminated_, &pool_, &step_);
  *delta_x = step_.delta_x;
  has_step_ = true;
  return std::isfinite(step_.model_cost_change) && delta_x->allFinite();
}

// S Δx_p = b_S
bool SparseSolver::SolvePoses(const DampingRule& rule, VecX* delta_poses) {
  if (implicit_) return implicit_->Solve(linearized_, rule, &eliminated_, delta_poses);
  FormSchurComplement(structure_, linearized_, rule, &groups_, &pool_, &eliminated_);
  return reduced_solver_->Solve(eliminated_.S, eliminated_.b_S, eliminated_.damped_diagonal, delta_poses);
}

double SparseSolver::ModelCostChange(const VecX& delta_x) const {
  const bool is_solution = has_step_ && delta_x.size() == step_.delta_x.size() && delta_x == step_.delta_x;
  return is_solution ? step_.model_cost_change : NormalEquations::ModelCostChange(delta_x);
}

// ---- states -----------------------------------------------------------------------------------------------------

void SparseSolver::UpdateStates(const VecX& delta_x) {
  for (const auto* vertices : {&structure_.poses, &structure_.landmarks}) {
    ParallelFor(&pool_, static_cast<int>(vertices->size()), kVertices, [&](int begin, int end) {
      for (int i = begin; i < end; ++i) {
        if (i + kPrefetchDistance < end) PrefetchObject((*vertices)[i + kPrefetchDistance], 2);
        Vertex& vertex = *(*vertices)[i];
        vertex.BackUpParameters();
        vertex.Plus(delta_x.data() + vertex.OrderingId());
      }
    });
  }
}

double SparseSolver::RefineLandmarks(int steps) {
  if (!batches_.Active()) return 0.0;
  batches_.LoadPoses();
  return ch5::RefineLandmarks(structure_, batches_, steps, &pool_, &refinement_);
}

void SparseSolver::RollbackStates() { RollBack(structure_.ordering); }

double SparseSolver::StateNorm() const { return ch5::StateNorm(structure_.ordering); }

}  // namespace ch5
