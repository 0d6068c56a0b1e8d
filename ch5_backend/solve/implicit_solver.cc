#include "ch5_backend/solve/implicit_solver.h"

#include <cmath>

#include "ch5_backend/solve/implicit_schur.h"

namespace ch5 {
namespace {

// Says when an iterate x is accurate enough. The model's decrease by x is Q = bᵀx − ½xᵀSx.
class StopRule {
 public:
  StopRule(const IterativeOptions& options, double bMb)
      : options_(options), goal_(options.tolerance * options.tolerance * bMb) {}

  /// @param error  rᵀM⁻¹r for the residual r = b − Sx, or more if the solver knows that x is further off
  /// @param Q, Q_before  the decrease by x and by the iterate before;  @param i  counts the iterates from 1
  bool IsEnough(double error, double Q, double Q_before, int i) const {
    return error <= goal_ || (options_.model_tolerance > 0.0 && i * (Q - Q_before) < options_.model_tolerance * Q);
  }
  /// How many more terms bring the error down to the tolerance, if each is `ratio` times the one before.
  double TermsToGo(double error, double ratio) const {
    return goal_ > 0.0 ? 0.5 * std::log(goal_ / error) / std::log(ratio) : 0.0;
  }

 private:
  const IterativeOptions& options_;
  double goal_;
};

class IterativeSolver : public ImplicitSolver {
 public:
  IterativeSolver(ReducedSolverType type, const IterativeOptions& options, int pose_dim, int landmark_dim)
      : is_series_(type == ReducedSolverType::kPowerSeries),
        options_(options),
        S_(pose_dim, landmark_dim, options.single_precision) {}

  void Prepare(BlockSystem* system, ThreadPool* pool) override {
    S_.Prepare(system, pool);
    for (VecX* v : {&r_, &z_, &p_, &Sp_}) v->setZero(system->structure.ordering.dim_poses);
  }
  void Load() override { S_.Load(); }

  bool Solve(BlockSystem* system, const DampingRule& rule, VecX* x) override {
    products_ = 0;
    x->setZero(system->structure.ordering.dim_poses);
    if (!S_.Damp(rule, is_series_ ? Preconditioner::kBlockJacobi : options_.preconditioner)) return false;
    r_ = system->b_schur;
    S_.Precondition(r_, &z_);
    const StopRule stop(options_, r_.dot(z_));
    if (is_series_) {
      if (SumSeries(system->b_schur, stop, x)) return x->allFinite();
      x->setZero();
      r_ = system->b_schur;
      S_.Precondition(r_, &z_);
    }
    return ConjugateGradients(stop, x) && x->allFinite();
  }

  int Products() const override { return products_; }

 private:
  // x += t,  r −= S t,  t = M⁻¹r: the sum of the power series. @return false if it will not come near enough
  bool SumSeries(const VecX& b, const StopRule& stop, VecX* x) {
    double Q = 0.0, rMr = r_.dot(z_);
    for (int i = 1; i <= options_.max_iterations; ++i) {
      S_.Multiply(z_, &Sp_);
      ++products_;
      *x += z_;
      r_ -= Sp_;
      S_.Precondition(r_, &z_);
      const double rMr_before = rMr, Q_before = Q;
      rMr = r_.dot(z_);
      Q = 0.5 * x->dot(b + r_);
      // What is missing is a geometric series with the slowest term's ratio, which the terms' sizes approach from below.
      const double ratio = std::sqrt(rMr / rMr_before);
      if (!(ratio < 1.0)) return false;  // it would be, had B⁻¹W no eigenvalue beyond 1
      const double error = rMr / ((1.0 - ratio) * (1.0 - ratio));
      if (stop.IsEnough(error, Q, Q_before, i)) return true;
      if (stop.TermsToGo(error, ratio) > options_.max_iterations - i) return false;
    }
    return false;
  }

  // Golub & Van Loan, "Matrix Computations", alg. 11.5.1, from x with r = b − Sx and z = M⁻¹r.
  bool ConjugateGradients(const StopRule& stop, VecX* x) {
    double Q = 0.0, rMr = r_.dot(z_);
    p_ = z_;
    if (rMr == 0.0) return true;
    for (int i = 1; i <= options_.max_iterations; ++i) {
      S_.Multiply(p_, &Sp_);
      ++products_;
      const double curvature = p_.dot(Sp_);
      if (!(curvature > 0.0)) return false;
      const double alpha = rMr / curvature;
      *x += alpha * p_;
      r_ -= alpha * Sp_;
      S_.Precondition(r_, &z_);
      const double rMr_before = rMr, Q_before = Q;
      rMr = r_.dot(z_);
      Q += 0.5 * alpha * rMr_before;
      if (stop.IsEnough(rMr, Q, Q_before, i)) return true;
      p_ = z_ + (rMr / rMr_before) * p_;
    }
    return true;
  }

  bool is_series_;
  IterativeOptions options_;
  ImplicitSchur S_;
  VecX r_, z_, p_, Sp_;
  int products_ = 0;
};

}  // namespace

std::unique_ptr<ImplicitSolver> MakeImplicitSolver(ReducedSolverType type, const IterativeOptions& options,
                                                   int pose_dim, int landmark_dim) {
  return std::make_unique<IterativeSolver>(type, options, pose_dim, landmark_dim);
}

}  // namespace ch5
