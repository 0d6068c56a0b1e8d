#include "ch5_backend/sparse/implicit_solver.h"

#include <cmath>

#include "ch5_backend/sparse/implicit_schur.h"

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

 private:
  const IterativeOptions& options_;
  double goal_;
};

class IterativeSolver : public ImplicitSolver {
 public:
  IterativeSolver(ReducedSolverType type, const IterativeOptions& options, int pose_dim, int landmark_dim)
      : is_series_(type == ReducedSolverType::kPowerSeries), options_(options), S_(pose_dim, landmark_dim) {}

  void Prepare(BlockSystem* system, ThreadPool* pool) override {
    S_.Prepare(system, pool);
    for (VecX* v : {&r_, &z_, &p_, &Sp_}) v->setZero(system->structure.ordering.dim_poses);
  }

  bool Solve(BlockSystem* system, const DampingRule& rule, VecX* x) override {
    x->setZero(system->structure.ordering.dim_poses);
    if (!S_.Damp(rule, is_series_ ? Preconditioner::kBlockJacobi : options_.preconditioner)) return false;
    r_ = system->b_schur;
    S_.Precondition(r_, &z_);
    const StopRule stop(options_, r_.dot(z_));
    Q_ = 0.0;
    iterates_ = 0;
    if (is_series_ && SumSeries(system->b_schur, stop, x)) return x->allFinite();
    return ConjugateGradients(stop, x) && x->allFinite();
  }

  int Products() const override { return iterates_; }

 private:
  // x += t,  r −= S t,  t = M⁻¹r: the sum of the power series. @return false if it is not near enough
  bool SumSeries(const VecX& b, const StopRule& stop, VecX* x) {
    double rMr = r_.dot(z_);
    while (iterates_ < options_.max_terms) {
      S_.Multiply(z_, &Sp_);
      *x += z_;
      r_ -= Sp_;
      S_.Precondition(r_, &z_);
      const double rMr_before = rMr, Q_before = Q_;
      rMr = r_.dot(z_);
      Q_ = 0.5 * x->dot(b + r_);
      ++iterates_;
      // What is missing is a geometric series with the slowest term's ratio, which the terms' sizes approach from
      // below.
      const double ratio = std::sqrt(rMr / rMr_before);
      if (!(ratio < 1.0)) return false;  // it would be, had B⁻¹W no eigenvalue beyond 1
      if (stop.IsEnough(rMr / ((1.0 - ratio) * (1.0 - ratio)), Q_, Q_before, iterates_)) return true;
    }
    return false;
  }

  // Golub & Van Loan, "Matrix Computations", alg. 11.5.1, from x with r = b − Sx and z = M⁻¹r.
  bool ConjugateGradients(const StopRule& stop, VecX* x) {
    double rMr = r_.dot(z_);
    p_ = z_;
    while (rMr > 0.0 && iterates_ < options_.max_iterations) {
      S_.Multiply(p_, &Sp_);
      const double curvature = p_.dot(Sp_);
      if (!(curvature > 0.0)) return false;
      const double alpha = rMr / curvature;
      *x += alpha * p_;
      r_ -= alpha * Sp_;
      S_.Precondition(r_, &z_);
      const double rMr_before = rMr, Q_before = Q_;
      rMr = r_.dot(z_);
      Q_ += 0.5 * alpha * rMr_before;
      ++iterates_;
      if (stop.IsEnough(rMr, Q_, Q_before, iterates_)) return true;
      p_ = z_ + (rMr / rMr_before) * p_;
    }
    return true;
  }

  bool is_series_;
  IterativeOptions options_;
  ImplicitSchur S_;
  VecX r_, z_, p_, Sp_;
  int iterates_ = 0;  // of the last Solve; a product each
  double Q_ = 0.0;    // the model's decrease by the present one
};

}  // namespace

std::unique_ptr<ImplicitSolver> MakeImplicitSolver(ReducedSolverType type, const IterativeOptions& options,
                                                   int pose_dim, int landmark_dim) {
  return std::make_unique<IterativeSolver>(type, options, pose_dim, landmark_dim);
}

}  // namespace ch5
