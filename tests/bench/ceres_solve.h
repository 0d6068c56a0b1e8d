#pragma once
/// What the peers have in common: poses, options in, trace out.

#include <ceres/ceres.h>

#include "ch5_backend/math/so3.h"
#include "tests/bench/ceres_peer.h"

namespace ch5::peer {

/// As Ceres stores its Jacobians.
template <int R, int C>
using RowMajor = Eigen::Matrix<double, R, C, (C == 1 ? Eigen::ColMajor : Eigen::RowMajor)>;

/// [p, q] with the increment [δp, δθ]; the cost functions give derivatives by the increment, in the first six columns.
class PoseManifold : public ceres::Manifold {
 public:
  int AmbientSize() const override { return 7; }
  int TangentSize() const override { return 6; }
  bool Plus(const double* x, const double* delta, double* x_plus_delta) const override {
    const Qd q = Qd(x[6], x[3], x[4], x[5]) * ExpSO3(Eigen::Map<const Vec3>(delta + 3));
    Eigen::Map<Vec3>{x_plus_delta} = Eigen::Map<const Vec3>(x) + Eigen::Map<const Vec3>(delta);
    Eigen::Map<Eigen::Vector4d>(x_plus_delta + 3) = q.normalized().coeffs();
    return true;
  }
  bool PlusJacobian(const double*, double* J) const override {
    Eigen::Map<RowMajor<7, 6>>{J}.setIdentity();
    return true;
  }
  bool Minus(const double*, const double*, double*) const override { return false; }
  bool MinusJacobian(const double*, double*) const override { return false; }
};

/// Runs Ceres with its best settings for `options`.
PeerResult SolveWithCeres(const PeerOptions& options, std::shared_ptr<ceres::ParameterBlockOrdering> ordering,
                          ceres::Problem* problem);

/// Σ of the poses (of seven numbers each), by the faster of its sparse factorizations.
PeerResult CovariancesWithCeres(const PeerOptions& options, const std::vector<const double*>& poses,
                                ceres::Problem* problem);

}  // namespace ch5::peer
