#pragma once
/// How a lens bends rays: between the ideal normalized plane z = 1, which recordings use, and the distorted one, which the
/// intrinsics map to pixels.
///
///   radial-tangential (Brown)  x_d = (1 + k1 n + k2 n² + k3 n³) x + (2 p1 x y + p2 (n + 2x²), p1 (n + 2y²) + 2 p2 x y),
///                              n = ‖x‖²
///   equidistant (Kannala & Brandt 2006, eq. 6)  ‖x_d‖ = θ (1 + k1 θ² + k2 θ⁴ + k3 θ⁶ + k4 θ⁸),  θ = atan ‖x‖
///   double sphere (Usenko et al. 2018, eq. 40)  x_d = (1 + ξ) x / (α d2 + (1 − α)(ξ d1 + 1)),
///                              d1 = √(n + 1),  d2 = √(n + (ξ d1 + 1)²)
///   field of view (Devernay & Faugeras 2001, eq. 13)  ‖x_d‖ = atan(2 ‖x‖ tan(ω/2)) / (2 tan(ω/2))
///
/// The last two are scaled so that, like the others, they leave what is near the axis as it is: the focal length is then the
/// published one divided by 1 + ξ, or times 2 tan(ω/2) / ω.

#include <optional>

#include "ch5_backend/math/eigen_types.h"

namespace ch5 {

struct Lens {
  enum class Model { kRadialTangential, kEquidistant, kDoubleSphere, kFieldOfView };
  Model model = Model::kRadialTangential;
  Eigen::Vector4d k = Eigen::Vector4d::Zero();  ///< k1, k2, p1, p2; k1, k2, k3, k4; ξ, α; or ω [rad]
  double k3 = 0.0;                              ///< of the radial-tangential model, OpenCV's fifth

  /// @param x  on the ideal plane
  Vec2 Distort(const Vec2& x) const;
  /// The x with Distort(x) = `x_d`, by Newton's method to 1e-9 where there is no formula.
  /// @return nullopt where there is none: the image's corner beyond what the model describes, or a ray more than 80° off
  ///         the axis, which the plane z = 1 hardly holds
  std::optional<Vec2> Undistort(const Vec2& x_d) const;
};

}  // namespace ch5
