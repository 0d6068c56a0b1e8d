#pragma once
/// Stage 8, as the handout writes it: p' = p + v dt + ½ R a dt², P' = A P Aᵀ + B Q Bᵀ, r = ‖p + R a − beacon‖ − range, …

#include <vector>

#include "ch5_backend/open_tasks/open_tasks.h"
#include "ch5_homework/judge/right/formulas.h"

namespace ch5::homework::right {

struct Trial {
  double cost, trial_cost, predicted, lambda, nu;
};

/// 8a: λ and ν after each trial.
struct NextDamping {
  Formula lambda, nu;
  MatXX between_other_limits;  ///< λ, if the factor keeps between the smallest and the largest of `factors`

  NextDamping(const std::vector<Trial>& trials, bool accepted, const VecX& factors);
};

/// 8b: what [x, y] / z of p_C = R_B_Cᵀ (R_W_Bᵀ (p_W − p) − p_B_C) does.
struct Projection {
  Formula over_point, over_position, over_rotation;

  Projection(const Transform& T_W_B, const Transform& T_B_C, const Vec3& p_W);
};

struct ImuStep {
  ImuIncrement before;
  Vec3 a, w;
  double dt, sigma_a, sigma_g;
};

/// 8c
struct Integrated {
  Formula p, R, v, covariance;
  MatXX A, P, B, Q;

  explicit Integrated(const ImuStep& step);
};

/// 8d
struct Range {
  Formula residual, over_position, over_rotation;

  Range(const Transform& T_W_B, const Vec3& antenna, const Vec3& beacon, double range);
};

}  // namespace ch5::homework::right
