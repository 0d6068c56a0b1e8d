#include "ch5_backend/sparse/steps/implicit_solver.h"

#include <cmath>

#include "ch5_backend/linear/conjugate_gradients.h"

namespace ch5 {
namespace {

// Says when an iterate x is accurate enough.
class StopRule {
 public:
  StopRule(const IterativeOptions& options, double bMb)
      : options_(options), goal_(options.tolerance * options.tolerance * bMb) {}

  bool operator()(const LinearIterate& x) const { return IsEnough(x.rMr, x); }
  /// @param error  rᵀM⁻¹r, or more if the solver knows that x is further off
  bool IsEnough(double error, const LinearIterate& x) const {
    const double gained = x.count * (x.decrease - x.decrease_before);
    return error <= goal_ || (options_.model_tolerance > 0.0 && gained < options_.model_tolerance * x.decrease);
  }

 private:
  const IterativeOptions& options_;
  double goal_;
};

class IterativeSolver : public ImplicitSolver {
 public:
  IterativeSolver(ReducedSolverType type, const IterativeOptions& options)
      : is_series_(type == ReducedSolverType::kPowerSeries), options_(options) {}

  void Prepare(const Structure& structure, ThreadPool* pool) override {
    S_.Prepare(structure, pool);
    state_.Resize(structure.ordering.dim_poses);
  }

  bool Solve(const Linearized& system, const DampingRule& rule, Eliminated* eliminated, VecX* x) override {
    x->setZero(state_.r.size());
    const Preconditioner preconditioner = is_series_ ? Preconditioner::kBlockJacobi : options_.preconditioner;
    if (!S_.Damp(system, rule, preconditioner, eliminated)) return false;
    const auto multiply = [this](const VecX& v, VecX* Sv) { S_.Multiply(v, Sv); };
    const auto precondition = [this](const VecX& r, VecX* z) { S_.Precondition(r, z); };
    state_.StartAtZero(eliminated->b_S, precondition);
    const StopRule stop(options_, state_.rMr);
    if (is_series_ && SumSeries(eliminated->b_S, stop, x)) return x->allFinite();
    return ConjugateGradients(multiply, precondition, stop, options_.max_iterations, &state_, x) && x->allFinite();
  }

  int Products() const override { return state_.count; }

 private:
  // x += t,  r −= S t,  t = M⁻¹r: the sum of the power series. @return false if it is not near enough
  bool SumSeries(const VecX& b, const StopRule& stop, VecX* x) {
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
      // What is missing is a geometric series with the slowest term's ratio, which the terms' sizes approach from
      // below.
      const double ratio = std::sqrt(s.rMr / rMr_before);
      if (!(ratio < 1.0)) return false;  // it would be, had B⁻¹C no eigenvalue beyond 1
      if (stop.IsEnough(s.rMr / ((1.0 - ratio) * (1.0 - ratio)), s)) return true;
    }
    return false;
  }

  bool is_series_;
  IterativeOptions options_;
  ImplicitSchur S_;
  LinearIterate state_;  // of the last Solve; count is its products
};

}  // namespace

std::unique_ptr<ImplicitSolver> MakeImplicitSolver(ReducedSolverType type, const IterativeOptions& options) {
  return std::make_unique<IterativeSolver>(type, options);
}

}  // namespace ch5
