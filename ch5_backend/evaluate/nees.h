#pragma once
/// NEES, the normalized estimation error squared: does an estimator's covariance match its true errors?
///
///   NEES = eᵀ P⁻¹ e,   e = [p − p*; Log(R*ᵀR)]  of a pose against the truth *,   P = the covariance the estimator claims
///
/// For a consistent estimator with Gaussian errors it is distributed as χ² with 6 degrees of freedom, and its mean over
/// N independent runs as χ²_6N/N. A mean above the band means overconfidence, below it an estimator that is too modest.
/// Source: Bar-Shalom, Li, Kirubarajan, "Estimation with Applications to Tracking and Navigation", 2001, §5.4.

#include "ch5_backend/math/so3.h"

namespace ch5 {

/// The error of one pose and what was claimed of it.
struct PoseConsistency {
  Vec6 error;                 ///< e = [δp, δθ] [m, rad], right perturbation as the covariance's
  double nees = 0.0;          ///< eᵀ P⁻¹ e, 6 degrees of freedom; NaN unless P is positive definite
  double yaw_error = 0.0;     ///< δθ about W's z axis [rad]
  double yaw_variance = 0.0;  ///< claimed [rad²]

  double YawNees() const { return yaw_error * yaw_error / yaw_variance; }  ///< 1 degree of freedom
};

/// @param T_W_B       the estimate;  @param covariance  6×6 of its [δp, δθ]
/// @param T_W_B_true  the truth, in the same W
PoseConsistency ComparePose(const Transform& T_W_B, const Mat66& covariance, const Transform& T_W_B_true);

/// An interval that a statistic falls into with a given probability.
struct ConfidenceBand {
  double low = 0.0, high = 0.0;
  bool Contains(double value) const { return value >= low && value <= high; }
};

/// Where the mean of `runs` independent χ² variables of `dof` degrees of freedom lies: χ²_(dof·runs)/runs, by Wilson and
/// Hilferty's approximation (PNAS 1931), which is good to 1 % from dof·runs = 10 on.
/// @param normal_quantile  z of the normal distribution with P(|x| < z) = the probability; the default gives 95 %
ConfidenceBand ChiSquaredBand(int dof, int runs, double normal_quantile = 1.959964);

}  // namespace ch5
