#pragma once
/// What an algorithm does between two linearizations: it proposes steps and learns how they went.

#include <memory>

#include "ch5_backend/solve/minimizer.h"

namespace ch5 {

class StepStrategy {
 public:
  virtual ~StepStrategy() = default;
  /// The system has a new Hessian.
  virtual void Begin(NormalEquations* system) = 0;
  /// The step to try; false if the linear solver failed at this damping.
  virtual bool Propose(NormalEquations* system, VecX* delta_x) = 0;
  /// @param gain_ratio  actual / predicted decrease of an accepted (> 0) step
  virtual void Accepted(double gain_ratio) = 0;
  /// The cost rose, was not finite, or there was no step. @return false if another trial cannot help
  virtual bool Rejected() = 0;
  /// What kind of step the last proposal was.
  virtual StepType Type() const = 0;
  /// λ, or the radius.
  virtual double Parameter() const = 0;
};

/// λ = 0, and every finite step is accepted whether or not it lowers the cost: textbook Gauss-Newton.
std::unique_ptr<StepStrategy> MakeGaussNewton();

/// Nielsen 1999, with g2o's limit ⅔:
/// λ₀ = τ max diag(H);  success: λ ×= max(1/3, min(2/3, 1 − (2ρ−1)³)), ν = 2;  failure: λ ×= ν, ν ×= 2.
std::unique_ptr<StepStrategy> MakeLevenbergMarquardt(double tau);

/// Powell's dogleg with g2o's constants:  ρ > ¾: Δ = max(Δ, 3‖h‖);  ρ < ¼: Δ /= 2;  but rejected: Δ = ½ min(Δ, ‖h‖).
std::unique_ptr<StepStrategy> MakeDogleg(double initial_radius);

}  // namespace ch5
