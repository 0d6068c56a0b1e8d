// The check of the tracker.

#include <Eigen/Eigenvalues>
#include <Eigen/QR>

#include "ch5_backend/track/tracker.h"

namespace ch5 {
namespace {

constexpr size_t kSample = 8;
constexpr size_t kFewest = 12;
constexpr int kSamples = 100;  // with a fifth of outliers, all but one in 10⁸ runs have a sample without

// vec(E) column by column, so that f1ᵀ E f0 = a(f0, f1)ᵀ vec(E).
Vec9 Row(const Vec3& f0, const Vec3& f1) {
  Vec9 a;
  a << f0.x() * f1, f0.y() * f1, f0.z() * f1;
  return a;
}

std::vector<bool> Inliers(const Vec9& vec_E, const std::vector<Vec3>& f0, const std::vector<Vec3>& f1, double max_angle,
                          size_t* count) {
  const Mat33 E = Eigen::Map<const Mat33>(vec_E.data());
  std::vector<bool> inliers(f0.size());
  *count = 0;
  for (size_t i = 0; i < f0.size(); ++i) {
    const Vec3 n1 = E * f0[i], n0 = E.transpose() * f1[i];  // normals of the epipolar planes
    const double r = std::abs(f1[i].dot(n1));
    inliers[i] = r <= max_angle * n1.norm() && r <= max_angle * n0.norm();
    *count += inliers[i];
  }
  return inliers;
}

}  // namespace

std::vector<bool> EssentialInliers(const std::vector<Vec3>& f0, const std::vector<Vec3>& f1, double max_angle,
                                   std::mt19937* random) {
  std::vector<bool> best(f0.size(), true);
  if (f0.size() < kFewest) return best;
  size_t most = 0;
  for (int sample = 0; sample < kSamples; ++sample) {
    // The vector that is orthogonal to eight rows: the last column of Q in their QR decomposition.
    Eigen::Matrix<double, 9, 8> A;
    for (size_t k = 0; k < kSample; ++k) {
      const size_t i = (*random)() % f0.size();
      A.col(static_cast<int>(k)) = Row(f0[i], f1[i]);
    }
    const Eigen::HouseholderQR<Eigen::Matrix<double, 9, 8>> qr(A);
    size_t count = 0;
    const std::vector<bool> inliers = Inliers(qr.householderQ() * Vec9::Unit(8), f0, f1, max_angle, &count);
    if (count > most) most = count, best = inliers;
  }
  // Once more with all inliers, which a sample's noise no longer sways.
  MatXX AtA = MatXX::Zero(9, 9);
  for (size_t i = 0; i < f0.size(); ++i) {
    if (const Vec9 a = Row(f0[i], f1[i]); best[i]) AtA += a * a.transpose();
  }
  const Eigen::SelfAdjointEigenSolver<MatXX> eigen(AtA);  // compiled once for all files (math/precompiled.h)
  size_t count = 0;
  const std::vector<bool> inliers = Inliers(eigen.eigenvectors().col(0), f0, f1, max_angle, &count);
  return count > most ? inliers : best;
}

}  // namespace ch5
