#include "ch5_backend/evaluate/nees.h"

#include <Eigen/Cholesky>
#include <cmath>
#include <limits>

namespace ch5 {

PoseConsistency ComparePose(const Transform& T_W_B, const Mat66& covariance, const Transform& T_W_B_true) {
  PoseConsistency result;
  Vec6& e = result.error;
  e << T_W_B.p - T_W_B_true.p, LogSO3(T_W_B_true.q.conjugate() * T_W_B.q);
  const Eigen::LDLT<Mat66> factors(covariance);
  const bool is_definite = (factors.vectorD().array() > 0.0).all();
  result.nees = is_definite ? e.dot(factors.solve(e)) : std::numeric_limits<double>::quiet_NaN();
  const Vec3 up = T_W_B.q.conjugate() * Vec3::UnitZ();  // W's z axis, seen from the body
  result.yaw_error = up.dot(e.tail<3>());
  result.yaw_variance = up.dot(covariance.bottomRightCorner<3, 3>() * up);
  return result;
}

// χ²_k ≈ k (1 − s + z√s)³,  s = 2/(9k)
ConfidenceBand ChiSquaredBand(int dof, int runs, double normal_quantile) {
  const double k = static_cast<double>(dof) * runs, s = 2.0 / (9.0 * k);
  const auto quantile = [&](double z) { return k * std::pow(1.0 - s + z * std::sqrt(s), 3) / runs; };
  return {quantile(-normal_quantile), quantile(normal_quantile)};
}

}  // namespace ch5
