#include "ch5_backend/solve/minimizer.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <sstream>

#include "ch5_backend/math/option_checks.h"
#include "ch5_backend/solve/step_strategy.h"

namespace ch5 {
namespace {

// A smaller change of the cost, relative to it, is lost in its last digit: any smaller one is rounding noise.
constexpr double kRounding = std::numeric_limits<double>::epsilon();
constexpr double kVisible = 1e-10;  // of the cost: what a change of it must exceed to be more than rounding
constexpr double kOfCost = 1e-6;    // a coordinate that promises less is low

// Line 0 of the trace, the start, knows no damping, gain or step.
constexpr double kNoStep = std::numeric_limits<double>::quiet_NaN();

std::unique_ptr<StepStrategy> MakeStrategy(const NormalEquations& system, const SolveOptions& options) {
  switch (options.algorithm) {
    case Algorithm::kGaussNewton: return MakeGaussNewton();
    case Algorithm::kDogleg: return MakeDogleg(options.initial_radius);
    case Algorithm::kLevenbergMarquardt: return MakeLevenbergMarquardt(options.tau);
    case Algorithm::kAutomatic: break;
  }
  return system.SuitsDogleg() ? MakeDogleg(options.initial_radius) : MakeLevenbergMarquardt(options.tau);
}

// One run of Minimize: the loop's state, and the rules that end it.
class Run {
 public:
  Run(NormalEquations* system, const SolveOptions& options)
      : system_(system), options_(options), refines_(options.landmark_steps > 0) {}

  Summary Solve() {
    system_->SetOrdering();
    strategy_ = MakeStrategy(*system_, options_);
    may_become_damped_ = options_.algorithm == Algorithm::kAutomatic && system_->SuitsDogleg();
    summary_.trace.reserve(static_cast<size_t>(std::clamp(options_.max_iterations, 0, 31)) + 1);
    cost_ = Evaluate(system_->Size() > 0);
    summary_.initial_cost = cost_;
    if (system_->Size() == 0) {
      Stop(Termination::kNothingToOptimize, "no free vertex has an edge");
      Report(0);  // the start is all there is to tell
    } else if (!std::isfinite(cost_)) {
      StopNotFinite("the cost of the initial states is not finite");
    } else if (cost_ < 0.0) {
      Stop(Termination::kNotFinite, "the cost is negative, ", cost_, "; a loss function must not be");
    } else {
      Iterate();
    }
    summary_.final_cost = cost_;
    summary_.seconds = Seconds();
    return std::move(summary_);
  }

 private:
  void Iterate() {
    for (int iteration = 0; !stopped_; ++iteration) {
      if (iteration > 0 && iteration >= options_.max_iterations) {  // before computing a Hessian that would not be used
        return Stop(Termination::kMaxIterations, "after ", iteration, " iterations");
      }
      if (!has_hessian_) system_->MakeHessian();
      const VecX& b = system_->RightHandSide();
      info_.gradient_max = b.allFinite() ? b.cwiseAbs().maxCoeff() : NAN;  // maxCoeff may pass over a NaN
      if (iteration == 0) {
        first_gradient_max_ = info_.gradient_max;
        Report(0);
        if (stopped_) return;
      }
      if (!std::isfinite(info_.gradient_max)) {
        return StopNotFinite("the gradient is not finite: a Jacobian holds NaN or infinity");
      }
      if (info_.gradient_max == 0.0 && system_->HessianDiagonal().isZero(0.0)) {
        return Stop(
            Termination::kNothingToOptimize,
            "H is zero; is all information zero, every edge an outlier, or no residual changed by its vertices?");
      }
      if (info_.gradient_max <= options_.gradient_tolerance * first_gradient_max_ && IsLowInEachDirection()) {
        return Stop(Termination::kGradientConverged, "max|b| = ", info_.gradient_max, " from ", first_gradient_max_);
      }
      if (iteration > 0 && info_.step_norm <= yardstick_ && GreatestPromise() <= kOfCost * cost_) {
        return Stop(Termination::kStepConverged, "|dx| = ", info_.step_norm);
      }
      if (options_.max_iterations <= 0) return Stop(Termination::kMaxIterations, "none was allowed");
      strategy_->Begin(system_);
      ++summary_.iterations;
      TrySteps();
      if (!stopped_ || IsConverged(summary_.termination)) Report(iteration + 1);
    }
  }

  // One heavy edge, or a start far away, may make the first gradient so large that beside it all the others count as zero: a
  // minimum is told by what is left alone. A step of x_i alone, b_i/H_ii, promises ½ b_i²/H_ii; a valley, which such steps
  // cross, by what the last step has gained along it.
  bool IsLowInEachDirection() {
    constexpr double kGained = 1e-4;
    const Eigen::ArrayXd b = system_->RightHandSide().array().abs(), H_ii = system_->HessianDiagonal().array();
    const Eigen::Array<bool, Eigen::Dynamic, 1> is_near = b <= SmallStep(system_->StateNorm()) * H_ii;
    if (last_decrease_ > kGained * cost_) return is_near.all() && IsLowAlongTheValley();
    return (is_near || Promises().array() <= kOfCost * cost_).all();
  }

  // Edges of very unlike weights at the same vertices make one so stiff that a step of any coordinate alone promises nothing:
  // there the undamped step tells. A cost that is the rounding of the first one is none.
  bool IsLowAlongTheValley() {
    constexpr double kNoCost = 100.0 * kRounding * kRounding;
    if (!may_become_damped_ || cost_ <= kNoCost * summary_.initial_cost) return true;
    return !system_->SolveLinearSystem(0.0, &delta_x_) || system_->ModelCostChange(delta_x_) <= kOfCost * cost_;
  }

  // The least step that counts where ‖x‖ is this.
  double SmallStep(double size) const {
    const double tolerance = options_.step_tolerance;
    return std::max(tolerance * (size + tolerance), kRounding * size);
  }

  // ½ b_i²/H_ii: what the model promises for a step of x_i alone, whatever the damping.
  VecX Promises() const {
    VecX promises = system_->HessianDiagonal();
    const auto b = system_->RightHandSide().array();
    promises = (b == 0.0).select(0.0, 0.5 * b.square() / promises.array());
    return promises;
  }

  double GreatestPromise() const { return Promises().maxCoeff(); }

  // Tries steps until one lowers the cost, or a rule ends the run. Textbook Gauss-Newton accepts every step.
  void TrySteps() {
    const bool takes_all = options_.algorithm == Algorithm::kGaussNewton;
    const double size = system_->StateNorm();
    yardstick_ = SmallStep(size);
    bool solved = false;
    for (info_.trials = 1; info_.trials <= options_.max_trials; ++info_.trials) {
      info_.lambda = strategy_->Parameter();
      if (strategy_->Propose(system_, &delta_x_) && delta_x_.allFinite()) {
        solved = true;
        info_.step_type = strategy_->Type();
        info_.step_norm = delta_x_.norm();
        const double predicted = system_->ModelCostChange(delta_x_);
        system_->UpdateStates(delta_x_);
        const double refined = RefineLandmarks();
        double new_cost = Evaluate(ExpectsNextIteration(predicted));
        ++summary_.cost_evaluations;
        info_.gain_ratio = (cost_ - new_cost - refined) / predicted;
        if (!(new_cost < cost_)) new_cost = RescueStep(new_cost, predicted);
        if (std::isfinite(new_cost) && (takes_all || (predicted > 0.0 && new_cost < cost_))) {
          return Accept(new_cost, predicted);
        }
        system_->RollbackStates();
        if (has_hessian_) system_->MakeHessian();  // as it was before the trial
        // No step large enough to change x helps, or the predicted decrease is below the rounding of the cost.
        if (info_.step_norm <= yardstick_) return StopAtASmallStep(new_cost, predicted, size);
        if (new_cost == cost_) return StopAtTheSameCost(predicted);  // ρ = 0, where g2o ends too
        if (std::abs(predicted) <= 1e-13 * cost_ && !IsHeldBack(predicted)) return StopBelowRounding(predicted);
      }
      if (!strategy_->Rejected()) break;
    }
    if (BecomesExact() || BecomesDamped()) return;
    if (solved) return Stop(Termination::kNoDecrease, "no step lowered the cost below ", cost_);
    StopWithoutStep();
  }

  // Where the diagonal's entries are so far apart that the least are lost beside the largest, no damping helps.
  void StopWithoutStep() {
    constexpr double kApart = 1e20;
    const VecX H_ii = system_->HessianDiagonal();
    const double least = H_ii.minCoeff(), most = H_ii.maxCoeff();
    const char* words = "H + lambda D is not positive definite at lambda = ";
    if (least > 0.0 && most > kApart * least) {
      return Stop(Termination::kLinearSolverFailed, words, info_.lambda, "; H's diagonal goes from ", least, " to ",
                  most, ": does a point lie in the plane of its camera, or is a weight far too large?");
    }
    Stop(Termination::kLinearSolverFailed, words, info_.lambda, "; is a gauge free, or a landmark seen too little?");
  }

  // A step too small to change x has not lowered the cost. That alone proves no minimum: the gradient must be low too, or the
  // states exact to their last digits, whose rounding the gradient then is.
  void StopAtASmallStep(double new_cost, double predicted, double size) {
    constexpr double kLastDigits = 16.0 * kRounding, kNoDigit = 1e-6 * kRounding;
    const double step = info_.step_norm;
    if (!std::isfinite(new_cost)) {
      return Stop(Termination::kNoDecrease, "even a step of |dx| = ", step,
                  " makes the cost infinite or NaN: a residual or a Plus has no number nearby");
    }
    if (step < kNoDigit * size && predicted > kVisible * cost_) {
      return Stop(Termination::kNoDecrease, "a step of |dx| = ", step, " is lost in states as large as |x| = ", size);
    }
    // So small a step is a linear one: the cost must follow its gradient, as far as rounding lets it be seen.
    if (step > 1e3 * kRounding * size && predicted > kVisible * cost_ && info_.gain_ratio < -0.5) {
      if (ShorterStepLowersTheCost()) {
        return Stop(Termination::kNoDecrease, "a step of |dx| = ", step,
                    " is short beside states as large as |x| = ", size,
                    " and yet too long: are a few of them far larger than the others?");
      }
      return Stop(Termination::kNoDecrease, "a step of |dx| = ", step,
                  " raises the cost where the Jacobians say that it falls; CheckJacobians tells which are wrong");
    }
    if (IsHeldBack(predicted)) return StopHeldBack();
    if (step > kLastDigits * size && !IsLowInEachDirection()) {
      if (new_cost == cost_) return StopAtTheSameCost(predicted);
      return Stop(Termination::kNoDecrease, "a step of |dx| = ", step, " does not lower the cost, though the gradient ",
                  "promises ", GreatestPromise(), " of ", cost_, "; CheckJacobians tells which Jacobians are wrong");
    }
    Stop(Termination::kStepConverged, "|dx| = ", step, " does not lower the cost any more");
  }

  // A step that is short beside a few huge states may be long for the others: then the Jacobians are right, and a part of it helps.
  bool ShorterStepLowersTheCost() {
    for (double share = 0.1; share > 1e-9; share *= 0.1) {
      system_->UpdateStates(share * delta_x_);
      const double cost = system_->Cost();
      system_->RollbackStates();
      if (cost < cost_) return true;
    }
    return false;
  }

  // How much the cost falls when each landmark is moved alone; 0 once that has become too little to be worth it.
  double RefineLandmarks() {
    constexpr double kLeast = 1e-3;  // of the cost
    if (!refines_) return 0.0;
    const double decrease = system_->RefineLandmarks(options_.landmark_steps);
    refines_ = decrease > kLeast * cost_;
    return std::isfinite(decrease) ? decrease : 0.0;
  }

  // A step that raises the cost may have moved the poses well, and only landmarks too far: moved alone, these often bring it
  // below what it was, for less than another solution. That speaks neither for the model nor against it: ρ ≤ ½.
  double RescueStep(double new_cost, double predicted) {
    constexpr double kLeast = 1e-4;  // of the cost: what the step has promised
    const bool may_rescue = options_.rescue_steps > 0 && options_.landmark_steps == 0;
    if (!may_rescue || info_.step_type != StepType::kDamped || !(predicted > kLeast * cost_)) return new_cost;
    if (!(new_cost - system_->RefineLandmarks(options_.rescue_steps) < cost_)) return new_cost;
    const double rescued = Evaluate(true);
    info_.gain_ratio = std::min(0.5, (cost_ - rescued) / predicted);
    return rescued;
  }

  // The cost at the present states; with the Hessian there, if it is wanted and comes along.
  double Evaluate(bool with_hessian) {
    double cost = 0.0;
    has_hessian_ = with_hessian && system_->MakeHessianAndCost(&cost);
    return has_hessian_ ? cost : system_->Cost();
  }

  // Whether the step will probably be taken, and not end the run: then the Hessian is needed too.
  bool ExpectsNextIteration(double predicted) const {
    const bool trusts_model = summary_.cost_evaluations == 0 || info_.gain_ratio > 0.5;
    return trusts_model && predicted > std::max(options_.cost_tolerance, kRounding) * cost_ &&
           summary_.iterations < options_.max_iterations;
  }

  // Whether one coordinate alone promises far more than the step brought: then damping or the trust region held the step back,
  // or the model is a poor one, and little progress means nothing. An undamped step predicts at least as much.
  bool IsHeldBack(double gained) const {
    constexpr double kMuch = 1e3;
    return GreatestPromise() > kMuch * std::max(std::abs(gained), std::max(options_.cost_tolerance, kVisible) * cost_);
  }

  void Accept(double new_cost, double predicted) {
    const double decrease = last_decrease_ = cost_ - new_cost;
    strategy_->Accepted(info_.gain_ratio);
    // Cost first: a zero cost cannot fall further.
    const bool is_little = std::abs(decrease) <= options_.cost_tolerance * cost_;
    if (decrease == 0.0 && new_cost != 0.0) {
      StopAtTheSameCost(predicted);
    } else if (new_cost == 0.0 || (is_little && !IsHeldBack(decrease))) {
      Stop(Termination::kCostConverged, "the cost fell by ", decrease, " of ", cost_);
    } else if (predicted <= kRounding * cost_ && !IsHeldBack(predicted)) {
      StopBelowRounding(predicted);
    }
    cost_ = new_cost;
    constexpr double kLittle = 0.02;  // of the cost
    if (!stopped_ && summary_.iterations < options_.max_iterations && decrease < kLittle * cost_) BecomesExact();
  }

  // Far from the minimum inexact steps gain as much as exact ones, and sooner; near it they creep. The damping is reset: how
  // small it may be, inexact steps do not tell, since their directions are short where the scene hardly determines any.
  bool BecomesExact() {
    if (!may_be_inexact_) return false;
    may_be_inexact_ = false;
    if (!system_->SolveExactly()) return false;
    strategy_ = MakeStrategy(*system_, options_);
    return true;
  }

  // Where Dogleg finds no lower cost, though it suits the system, damped steps may: they shorten sooner.
  bool BecomesDamped() {
    if (!may_become_damped_) return false;
    may_become_damped_ = false;
    strategy_ = MakeLevenbergMarquardt(options_.tau);
    return true;
  }

  void StopAtTheSameCost(double predicted) {
    if (predicted > kVisible * cost_) {
      Stop(Termination::kNoDecrease, "a step of |dx| = ", info_.step_norm,
           " leaves the cost as it is where the Jacobians say that it falls; ",
           "does a residual read its vertex, and does its Plus move it?");
    } else if (IsHeldBack(predicted)) {
      StopHeldBack();
    } else {
      Stop(Termination::kCostConverged, "a step of |dx| = ", info_.step_norm, " leaves the cost as it is");
    }
  }

  void StopHeldBack() {
    Stop(Termination::kNoDecrease, "a step of |dx| = ", info_.step_norm, " is too short to change the cost; ",
         "is SolveOptions::tau too large, initial_radius too small, or a Jacobian wrong?");
  }

  void StopBelowRounding(double predicted) {
    Stop(Termination::kCostConverged, "the model predicts only ", predicted, " of ", cost_);
  }

  void StopNotFinite(const char* words) {
    const std::string what = system_->WhatIsNotFinite();
    Stop(Termination::kNotFinite, words, what.empty() ? "" : "; ", what);
  }

  void Report(int iteration) {
    info_.iteration = iteration;
    info_.cost = cost_;
    info_.seconds = Seconds();
    summary_.trace.push_back(info_);
    if (!options_.callback) return;
    const double size = system_->StateNorm();
    const bool goes_on = options_.callback(info_);
    if (!stopped_ && goes_on) system_->CheckOrdering();
    if (!(system_->StateNorm() == size)) {  // what is known of cost and gradient is of other states
      cost_ = system_->Cost();
      return Stop(Termination::kUserStopped, "the callback has moved a vertex");
    }
    if (!stopped_ && !goes_on) Stop(Termination::kUserStopped, "the callback asked for it");
  }

  template <typename... Words>
  void Stop(Termination termination, const Words&... words) {
    std::ostringstream message;
    message << ToString(termination) << ": ";
    (message << ... << words);
    summary_.message = message.str();
    summary_.termination = termination;
    stopped_ = true;
  }

  double Seconds() const { return std::chrono::duration<double>(Clock::now() - start_).count(); }

  using Clock = std::chrono::steady_clock;
  NormalEquations* system_;
  const SolveOptions& options_;
  std::unique_ptr<StepStrategy> strategy_;
  Clock::time_point start_ = Clock::now();
  Summary summary_;
  IterationInfo info_{0, 0.0, kNoStep, kNoStep, kNoStep};
  VecX delta_x_;
  double cost_ = 0.0;
  double last_decrease_ = 0.0;  // of the cost, by the last step
  double first_gradient_max_ = 0.0;
  double yardstick_ = 0.0;    // a step of x that counts as small
  bool has_hessian_ = false;  // of the states that were evaluated last
  bool may_be_inexact_ = true;
  bool may_become_damped_ = false;
  bool stopped_ = false;
  bool refines_;
};

}  // namespace

std::string ToString(Termination termination) {
  switch (termination) {
    case Termination::kCostConverged: return "cost converged";
    case Termination::kGradientConverged: return "gradient converged";
    case Termination::kStepConverged: return "step converged";
    case Termination::kMaxIterations: return "maximum of iterations";
    case Termination::kNothingToOptimize: return "nothing to optimize";
    case Termination::kNoDecrease: return "no decrease";
    case Termination::kLinearSolverFailed: return "linear solver failed";
    case Termination::kNotFinite: return "not finite";
    case Termination::kUserStopped: return "stopped by the caller";
  }
  return "unknown";
}

bool IsConverged(Termination termination) {
  return termination == Termination::kCostConverged || termination == Termination::kGradientConverged ||
         termination == Termination::kStepConverged;
}

void SolveOptions::Validate() const {
  CheckOption("SolveOptions::max_iterations", max_iterations, 0);
  CheckOption("SolveOptions::cost_tolerance", cost_tolerance, 0);
  CheckOption("SolveOptions::gradient_tolerance", gradient_tolerance, 0);
  CheckOption("SolveOptions::step_tolerance", step_tolerance, 0);
  CheckNotNegative("SolveOptions::tau", tau);
  CheckPositive("SolveOptions::initial_radius", initial_radius);
  CheckOption("SolveOptions::max_trials", max_trials, 1);
  CheckOption("SolveOptions::landmark_steps", landmark_steps, 0);
  CheckOption("SolveOptions::rescue_steps", rescue_steps, 0);
}

Summary Minimize(NormalEquations* system, const SolveOptions& options) {
  options.Validate();
  return Run(system, options).Solve();
}

}  // namespace ch5
