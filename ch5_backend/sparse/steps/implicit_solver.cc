#include "ch5_backend/sparse/steps/implicit_solver.h"

#include <cmath>

namespace ch5 {

void ImplicitSolver::Prepare(const Structure& structure, ThreadPool* pool) {
  S_.Prepare(structure, pool);
  state_.Resize(structure.ordering.dim_poses);
}

bool ImplicitSolver::Solve(const Linearized& system, const DampingRule& rule, Eliminated* eliminated, VecX* x) {
  x->setZero(state_.r.size());
  const Preconditioner preconditioner = is_series_ ? Preconditioner::kBlockJacobi : options_.preconditioner;
  if (!S_.Damp(system, rule, preconditioner, eliminated)) return false;
  const auto multiply = [this](const VecX& v, VecX* Sv) { S_.Multiply(v, Sv); };
  const auto precondition = [this](const VecX& r, VecX* z) { S_.Precondition(r, z); };
  const auto is_enough = [this](const LinearIterate& iterate) { return IsEnough(iterate.rMr, iterate); };
  state_.StartAtZero(eliminated->b_S, precondition);
  goal_ = options_.tolerance * options_.tolerance * state_.rMr;
  if (is_series_ && SumSeries(eliminated->b_S, x)) return x->allFinite();
  return ConjugateGradients(multiply, precondition, is_enough, options_.max_iterations, &state_, x) && x->allFinite();
}

// @param error  rᵀM⁻¹r, or more if x is known to be further off
bool ImplicitSolver::IsEnough(double error, const LinearIterate& x) const {
  const double gained = x.count * (x.decrease - x.decrease_before);
  return error <= goal_ || (options_.model_tolerance > 0.0 && gained < options_.model_tolerance * x.decrease);
}

// x += t,  r −= S t,  t = M⁻¹r: the sum of the power series. @return false if it is not near enough.  Weber (2023)
bool ImplicitSolver::SumSeries(const VecX& b, VecX* x) {
  LinearIterate& s = state_;
  while (s.count < options_.max_terms) {
    S_.Multiply(s.z, &s.Ap);
    *x += s.z;
    s.r -= s.Ap;
    S_.Precondition(s.r, &s.z);
    const double rMr_before = s.rMr;
    s.rMr = s.r.dot(s.z);
    s.decrease_before = s.decrease;
    s.decrease = 0.5 * x->dot(b + s.r);
    ++s.count;
    // What is missing is a geometric series with the slowest term's ratio, which the terms' sizes approach from below.
    const double ratio = std::sqrt(s.rMr / rMr_before);
    if (!(ratio < 1.0)) return false;  // it would be, had B⁻¹C no eigenvalue beyond 1
    if (IsEnough(s.rMr / ((1.0 - ratio) * (1.0 - ratio)), s)) return true;
  }
  return false;
}

}  // namespace ch5
