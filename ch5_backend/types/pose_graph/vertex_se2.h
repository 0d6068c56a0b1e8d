#pragma once
/// Poses and points in the plane.

#include <cmath>

#include "ch5_backend/graph/vertex.h"

namespace ch5 {

/// The same angle in [−π, π].
inline double WrapAngle(double angle) { return std::remainder(angle, 2.0 * M_PI); }

/// R(θ): rotates a vector of the plane by θ [rad], counter-clockwise.
inline Mat22 Rotation2(double theta) { return Eigen::Rotation2Dd(theta).toRotationMatrix(); }

/// Position p [m] and heading θ [rad, kept in [−π, π]], stored [x, y, θ].  Increment [δp, δθ]:  p + δp,  θ + δθ.
class VertexSE2 : public SizedVertex<3, 3> {
 public:
  explicit VertexSE2(const Vec2& p = Vec2::Zero(), double theta = 0.0)
      : SizedVertex(Vec3(p.x(), p.y(), WrapAngle(theta)), Role::kPose) {}

  Vec2 p() const { return x_.head<2>(); }
  double Theta() const { return x_[2]; }

  void Plus(const double* delta) override {
    x_ += Eigen::Map<const Vec3>(delta);
    x_[2] = WrapAngle(x_[2]);
  }
  VecX Minus(const VecX& x0) const override { return Vec3(x_[0] - x0[0], x_[1] - x0[1], WrapAngle(x_[2] - x0[2])); }
  std::string TypeInfo() const override { return "VertexSE2"; }
};

/// A landmark's coordinates [m] in the plane.
class VertexPointXY : public SizedVertex<2, 2> {
 public:
  explicit VertexPointXY(const Vec2& p_W = Vec2::Zero()) : SizedVertex(p_W, Role::kLandmark) {}
  std::string TypeInfo() const override { return "VertexPointXY"; }
};

}  // namespace ch5
