#pragma once
/// The similarity that aligns one set of points with another: it removes the gauge from an estimate.

#include <optional>
#include <vector>

#include "ch5_backend/math/so3.h"

namespace ch5 {

/// x ↦ s R x + p: the seven unobservable directions of a monocular reconstruction.
struct Similarity {
  double scale = 1.0;
  Qd q = Qd::Identity();
  Vec3 p = Vec3::Zero();

  Vec3 operator*(const Vec3& x) const { return scale * (q * x) + p; }
  /// A pose moves with its position; its rotation is turned, never scaled.
  Transform operator*(const Transform& T) const { return {q * T.q, *this * T.p}; }
};

/// @param points  at least one
Vec3 Mean(const std::vector<Vec3>& points);

/// argmin Σ ‖to_i − (s R from_i + p)‖², in closed form.
/// @param from, to  as many points each [m]
/// @return nullopt with fewer than three points, a number that is not finite, or points on one line: the rotation is
///         then not determined
/// Source: Umeyama, "Least-squares estimation of transformation parameters between two point patterns", PAMI 1991.
std::optional<Similarity> AlignUmeyama(const std::vector<Vec3>& from, const std::vector<Vec3>& to);

}  // namespace ch5
