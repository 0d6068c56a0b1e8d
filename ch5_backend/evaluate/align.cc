#include "ch5_backend/evaluate/align.h"

#include <Eigen/SVD>

namespace ch5 {

Vec3 Mean(const std::vector<Vec3>& points) {
  Vec3 sum = Vec3::Zero();
  for (const Vec3& x : points) sum += x;
  return sum / static_cast<double>(points.size());
}

std::optional<Similarity> AlignUmeyama(const std::vector<Vec3>& from, const std::vector<Vec3>& to) {
  if (from.size() != to.size() || from.size() < 3) return std::nullopt;
  const Vec3 from_mean = Mean(from), to_mean = Mean(to);
  Mat33 covariance = Mat33::Zero();  // Σ (to − mean)(from − mean)ᵀ
  double from_variance = 0.0;
  for (size_t i = 0; i < from.size(); ++i) {
    covariance += (to[i] - to_mean) * (from[i] - from_mean).transpose();
    from_variance += (from[i] - from_mean).squaredNorm();
  }
  if (!covariance.allFinite()) return std::nullopt;

  // covariance = U D Vᵀ  ⇒  R = U S Vᵀ,  s = tr(D S) / variance;  S = diag(1, 1, ±1) keeps R from being a mirror.
  const Eigen::JacobiSVD<Mat33> svd(covariance, Eigen::ComputeFullU | Eigen::ComputeFullV);
  const Vec3 D = svd.singularValues();
  if (!(D[1] > 1e-12 * D[0])) return std::nullopt;  // on one line
  Vec3 S = Vec3::Ones();
  if (svd.matrixU().determinant() * svd.matrixV().determinant() < 0.0) S[2] = -1.0;

  Similarity best;
  best.q = Qd(Mat33(svd.matrixU() * S.asDiagonal() * svd.matrixV().transpose())).normalized();
  best.scale = D.dot(S) / from_variance;
  best.p = to_mean - best.scale * (best.q * from_mean);
  return best;
}

}  // namespace ch5
