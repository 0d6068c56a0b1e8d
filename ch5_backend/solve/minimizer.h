#pragma once
/// Gauss-Newton, Levenberg-Marquardt (Nielsen) and Dogleg, over the interface NormalEquations.

#include <functional>
#include <string>
#include <vector>

#include "ch5_backend/solve/normal_equations.h"

namespace ch5 {

/// Which steps are tried: solve/step_strategy.h. kAutomatic is Levenberg-Marquardt, or Dogleg where the system suits it
/// better: in the sparse solver, a graph without landmarks.
enum class Algorithm { kGaussNewton, kLevenbergMarquardt, kDogleg, kAutomatic };

/// Why the iteration ended. All rules are relative, so they do not depend on units or weights. Little progress alone is no
/// minimum: the gradient must be low too, that is ½ b_i²/H_ii, what a step of x_i alone promises, a small part of the cost.
enum class Termination {
  kCostConverged,       ///< the cost fell by less than cost_tolerance of itself, though nothing held the step back
  kGradientConverged,   ///< max|b| ≤ gradient_tolerance × its first value, and the gradient is low
  kStepConverged,       ///< ‖Δx‖ ≤ step_tolerance (‖x‖ + step_tolerance), and the gradient is low
  kMaxIterations,       ///< not converged yet
  kNothingToOptimize,   ///< no free vertex has an edge, or all weights are zero
  kNoDecrease,          ///< no damping or trust region gave a lower cost
  kLinearSolverFailed,  ///< H is singular; a gauge is free, or a landmark is not observed enough
  kNotFinite,           ///< the cost at the start is infinite or NaN
  kUserStopped          ///< the callback returned false
};

/// "cost converged", … for tables and JSON.
std::string ToString(Termination termination);
/// True for the three rules that indicate an optimum.
bool IsConverged(Termination termination);

/// What kind of step a trial was; Dogleg's lies between the other two.
enum class StepType { kNone, kGaussNewton, kDamped, kSteepestDescent, kDogleg };

/// One line of the convergence table. Line 0 describes the start.
struct IterationInfo {
  int iteration = 0;
  double cost = 0.0;                     ///< ½ Σ ρ(rᵀWr) after the iteration
  double lambda = 0.0;                   ///< damping, or Dogleg's radius; 0 for Gauss-Newton
  double gain_ratio = 0.0;               ///< actual / predicted decrease of the last trial
  double step_norm = 0.0;                ///< ‖Δx‖ of the last trial
  double gradient_max = 0.0;             ///< max|b| where the iteration was linearized
  int trials = 0;                        ///< steps tried in this iteration, the rejected ones included
  StepType step_type = StepType::kNone;  ///< of the last trial
  double seconds = 0.0;                  ///< since the start
};

struct SolveOptions {
  Algorithm algorithm = Algorithm::kAutomatic;
  int max_iterations = 20;
  double cost_tolerance = 1e-6;
  double gradient_tolerance = 1e-10;
  double step_tolerance = 1e-8;
  double tau = 1e-5;            ///< λ₀ = τ max diag(H) with identity damping, λ₀ = τ with diagonal damping
  double initial_radius = 1e4;  ///< Dogleg
  int max_trials = 10;          ///< per iteration
  /// Steps of each landmark alone after each step of all (sparse/steps/refine_landmarks.h), as long as they lower the cost by
  /// 0.1 %. For landmarks that are far from linear.
  int landmark_steps = 0;
  /// Without these: so many where a damped step has raised the cost instead of lowering it by 0.01 %, before it is taken back.
  int rescue_steps = 0;
  /// Called after each iteration; false stops. It must not solve with the same optimizer. Vertices and edges that it adds count
  /// from the next solve on; to remove one is an error unless it stops.
  std::function<bool(const IterationInfo&)> callback;

  /// @throws OptionError
  void Validate() const;
};

/// How an optimization went.
struct Summary {
  Termination termination = Termination::kNothingToOptimize;
  std::string message;  ///< one sentence: which rule fired, with its numbers
  double initial_cost = 0.0;
  double final_cost = 0.0;
  int iterations = 0;        ///< linearizations that led to a trial
  int cost_evaluations = 0;  ///< trials, the rejected ones included
  double seconds = 0.0;
  std::vector<IterationInfo> trace;
};

/// g2o's terminate action, as a callback: stops once 0 ≤ (χ²_last − χ²)/χ² < `gain_threshold`.
class TerminateAction {
 public:
  explicit TerminateAction(double gain_threshold = 1e-6) : gain_threshold_(gain_threshold) {}
  bool operator()(const IterationInfo& info) {
    const double gain = (last_cost_ - info.cost) / info.cost;
    last_cost_ = info.cost;
    return info.iteration == 0 || !(gain >= 0.0 && gain < gain_threshold_);
  }

 private:
  double gain_threshold_, last_cost_ = 0.0;
};

/// Minimizes the cost of a system. Levenberg-Marquardt and Dogleg go downhill only, so that the states on return
/// are the best ones found; Gauss-Newton accepts every finite step and returns the last states.
/// @throws OptionError
Summary Minimize(NormalEquations* system, const SolveOptions& options = {});

}  // namespace ch5
