#include "ch5_backend/types/vertices.h"

#include <cmath>
#include <stdexcept>

namespace ch5 {
namespace {

Vec7 Pack(const Qd& q, const Vec3& p) {
  if (q.squaredNorm() == 0.0) throw std::invalid_argument("VertexPose: the quaternion is zero");
  Vec7 x;
  x << p, q.normalized().coeffs();
  return x;
}

VertexCameraBAL::Rotation Rotate(const Vec3& omega) {
  return {omega, ExpSO3(omega).toRotationMatrix(), LeftJacobianSO3(omega)};
}

}  // namespace

Qd RotationOf(const Qd& q, const char* of) {
  if (q.squaredNorm() == 0.0) throw std::invalid_argument(std::string(of) + ": the quaternion is zero");
  if (!q.coeffs().allFinite()) throw std::invalid_argument(std::string(of) + ": the quaternion is not finite");
  return q.normalized();
}

VertexPose::VertexPose() : VertexPose(Qd::Identity(), Vec3::Zero()) {}

VertexPose::VertexPose(const Qd& q, const Vec3& p) : SizedVertex(Pack(q, p), Role::kPose) {}

void VertexPose::SetPose(const Qd& q, const Vec3& p) { x_ = Pack(q, p); }

void VertexPose::SetEstimate(const Estimate& x) {
  const bool is_unit = std::abs(x.tail<4>().squaredNorm() - 1.0) < 1e-15;
  x_ = is_unit ? x : Pack(Qd(x[6], x[3], x[4], x[5]), x.head<3>());
}

void VertexPose::Plus(const double* delta) {
  const Qd rotated = q() * ExpSO3(Eigen::Map<const Vec3>(delta + 3));
  x_ = Pack(rotated, p() + Eigen::Map<const Vec3>(delta));
}

VecX VertexPose::Minus(const VecX& x0) const {
  Vec6 delta;
  MinusInto(x0, delta.data(), nullptr);
  return delta;
}

MatXX VertexPose::MinusJacobian(const VecX& x0) const {
  Mat66 J;
  MinusInto(x0, nullptr, J.data());
  return J;
}

void VertexPose::MinusInto(const VecX& x0, double* delta, double* derivative) const {
  const Qd dq = Difference(x0);
  if (delta) Vec6::Map(delta) << p() - x0.head<3>(), 2.0 * dq.vec();
  if (!derivative) return;
  Eigen::Map<Mat66> J(derivative);
  J.setIdentity();
  J.bottomRightCorner<3, 3>() = dq.w() * Mat33::Identity() + Hat(dq.vec());
}

Qd VertexPose::Difference(const VecX& x0) const {
  Qd dq = Qd(x0[6], x0[3], x0[4], x0[5]).conjugate() * q();
  if (dq.w() < 0.0) dq.coeffs() = -dq.coeffs();
  return dq;
}

VertexReferencePose::VertexReferencePose(const Qd& q, const Vec3& p) : VertexPose(q, p), q0_(q.normalized()), p0_(p) {}

Vec3 VertexReferencePose::DeltaPhi() const { return LogSO3(q() * q0_.conjugate()); }

Mat33 VertexReferencePose::DeltaPhiJacobian() const { return RightJacobianInverseSO3(-DeltaPhi()) * R(); }

void VertexReferencePose::Plus(const double* delta) {
  const Vec3 phi = DeltaPhi() + DeltaPhiJacobian() * Eigen::Map<const Vec3>(delta + 3);
  x_ = Pack(ExpSO3(phi) * q0_, p() + Eigen::Map<const Vec3>(delta));
}

VertexSpeedBias::VertexSpeedBias() : VertexSpeedBias(Vec9::Zero()) {}

VertexSpeedBias::VertexSpeedBias(const Vec9& v_ba_bg) : SizedVertex(v_ba_bg, Role::kPose) {}

VecX VertexSpeedBias::Minus(const VecX& x0) const { return x_ - x0; }

void VertexSpeedBias::MinusInto(const VecX& x0, double* delta, double* derivative) const {
  if (delta) Vec9::Map(delta) = x_ - x0;
  if (derivative) Eigen::Matrix<double, 9, 9>::Map(derivative).setIdentity();
}

VertexInverseDepth::VertexInverseDepth(double inverse_depth) : SizedVertex(Estimate(inverse_depth), Role::kLandmark) {}

VertexPointXYZ::VertexPointXYZ(const Vec3& p_W) : SizedVertex(p_W, Role::kLandmark) {}

VertexPointOnRay::VertexPointOnRay(const Vec3& p_W, const Vec3& anchor) : VertexPointXYZ(p_W), anchor_(anchor) {}

void VertexPointOnRay::Plus(const double* delta) {
  constexpr double kFarthest = 20.0;  // times as far
  const Vec3 v = x_ - anchor_, d = Eigen::Map<const Vec3>(delta);
  const double v2 = v.squaredNorm(), q = v2 > 0.0 ? v.dot(d) / v2 : 0.0;
  x_ = anchor_ + (v + d - q * v) / std::max(1.0 - q, 1.0 / kFarthest);
}

VertexCameraBAL::VertexCameraBAL(const Vec9& camera)
    : SizedVertex(camera, Role::kPose), rotation_(Rotate(camera.head<3>())), before_(rotation_) {}

void VertexCameraBAL::Plus(const double* delta) {
  if (rotation_.omega == x_.head<3>()) before_ = rotation_;
  x_ += Eigen::Map<const Vec9>(delta);
  rotation_ = Rotate(x_.head<3>());
}

const VertexCameraBAL::Rotation& VertexCameraBAL::GetRotation(Rotation* other) const {
  if (rotation_.omega == x_.head<3>()) return rotation_;
  if (before_.omega == x_.head<3>()) return before_;
  *other = Rotate(x_.head<3>());
  return *other;
}

}  // namespace ch5
