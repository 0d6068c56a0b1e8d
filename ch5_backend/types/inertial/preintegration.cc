#include "ch5_backend/types/inertial/preintegration.h"

#include <cmath>
#include <stdexcept>
#include <string>

namespace ch5 {
namespace {

void RequireFinite(const ImuSample& sample) {
  if (!sample.acceleration.allFinite() || !sample.gyroscope.allFinite()) {
    throw std::invalid_argument("Preintegration: an IMU sample holds a number that is not finite");
  }
}

}  // namespace

Preintegration::Preintegration(const ImuSample& first, const Vec3& b_a, const Vec3& b_g, const ImuNoise& noise)
    : samples_{first}, b_a_(b_a), b_g_(b_g), noise_(noise) {
  RequireFinite(first);
  samples_.front().dt = 0.0;
  Reset();
}

void Preintegration::Add(const ImuSample& sample) {
  RequireFinite(sample);
  if (!(sample.dt > 0.0) || !std::isfinite(sample.dt)) {
    throw std::invalid_argument("Preintegration: the time step must be positive, got " + std::to_string(sample.dt));
  }
  Step(samples_.back(), sample);
  samples_.push_back(sample);
}

void Preintegration::Reintegrate(const Vec3& b_a, const Vec3& b_g) {
  b_a_ = b_a;
  b_g_ = b_g;
  Reset();
  for (size_t k = 1; k < samples_.size(); ++k) Step(samples_[k - 1], samples_[k]);
}

void Preintegration::Append(const Preintegration& next) {
  for (size_t k = 1; k < next.samples_.size(); ++k) Add(next.samples_[k]);
}

void Preintegration::Reset() {
  sum_dt_ = 0.0;
  alpha_.setZero();
  beta_.setZero();
  gamma_.setIdentity();
  J_.setIdentity();
  P_.setZero();
}

// One midpoint step.  With A₀ = R₀[a₀−b_a], A₁ = R₁[a₁−b_a], E = I − [ω]dt, the error state moves by
//
//        p    θ                         v     b_a               b_g
//   p [  I   −¼A₀dt² − ¼A₁E dt²        I dt  −¼(R₀+R₁)dt²       ¼A₁dt³ ]
//   θ [       E                                                −I dt   ]
//   v [      −½A₀dt  − ½A₁E dt          I    −½(R₀+R₁)dt        ½A₁dt² ]
//   b [                                       I                 I      ]
//
// and the noise of the two samples enters as P ← F P Fᵀ + V Q Vᵀ (VINS-Mono's report, eqs. 9–10). Both sparse
// matrices are applied block by block: written out densely, this would be most of a window's preintegration time.
void Preintegration::Step(const ImuSample& s0, const ImuSample& s1) {
  const double dt = s1.dt, dt2 = dt * dt;
  const Vec3 omega = 0.5 * (s0.gyroscope + s1.gyroscope) - b_g_;
  const Vec3 half = 0.5 * dt * omega;
  const Qd gamma1 = (gamma_ * Qd(1.0, half.x(), half.y(), half.z())).normalized();
  const Mat33 R0 = gamma_.toRotationMatrix(), R1 = gamma1.toRotationMatrix();
  const Vec3 a0 = s0.acceleration - b_a_, a1 = s1.acceleration - b_a_;
  const Vec3 a = 0.5 * (R0 * a0 + R1 * a1);

  const Mat33 A0 = R0 * Hat(a0), A1 = R1 * Hat(a1);
  const Mat33 E = Mat33::Identity() - dt * Hat(omega);
  const Mat33 F_vq = -0.5 * dt * (A0 + A1 * E);
  const Mat33 F_va = -0.5 * dt * (R0 + R1);
  const Mat33 F_vg = 0.5 * dt2 * A1;

  // F X for X = J or P: only the rows p, θ and v change; p's are those of v times dt/2, plus p's own and v dt.
  const auto apply_F = [&](auto&& X) {
    using Row = Eigen::Matrix<double, 3, 15>;
    const Row dv =
        F_vq * X.template middleRows<3>(3) + F_va * X.template middleRows<3>(9) + F_vg * X.template middleRows<3>(12);
    X.template middleRows<3>(0) += dt * X.template middleRows<3>(6) + (0.5 * dt) * dv;
    X.template middleRows<3>(3) = (E * X.template middleRows<3>(3) - dt * X.template middleRows<3>(12)).eval();
    X.template middleRows<3>(6) += dv;
  };
  apply_F(J_);
  apply_F(P_);
  Mat1515 PFt = P_.transpose();
  apply_F(PFt);
  P_ = PFt.transpose();
  AddNoise(A1, dt);

  alpha_ += beta_ * dt + 0.5 * dt2 * a;
  beta_ += a * dt;
  gamma_ = gamma1;
  sum_dt_ += dt;
}

// V Q Vᵀ for isotropic noise, where R₀R₀ᵀ = R₁R₁ᵀ = I. The columns of V, over a₀, g₀, a₁, g₁, w_a, w_g:
//   p: ¼R₀dt², −⅛A₁dt³, ¼R₁dt², −⅛A₁dt³;   θ: –, ½dt I, –, ½dt I;   v = p · 2/dt;   b_a: dt I;   b_g: dt I
void Preintegration::AddNoise(const Mat33& A1, double dt) {
  // A density σ_c spreads over a step as σ_c²/dt; a midpoint step averages two samples, hence the 2.
  const double per_sample = noise_.continuous ? 2.0 / dt : 1.0;
  const double per_step = noise_.continuous ? 1.0 / dt : 1.0;
  const auto square = [](double x) { return x * x; };
  const double var_a = per_sample * square(noise_.accelerometer), var_g = per_sample * square(noise_.gyroscope);
  const double var_wa = per_step * square(noise_.accelerometer_walk);
  const double var_wg = per_step * square(noise_.gyroscope_walk);

  const double dt2 = dt * dt;
  const Mat33 Q_vv = 0.5 * dt2 * var_a * Mat33::Identity() + 0.125 * dt2 * dt2 * var_g * A1 * A1.transpose();
  const Mat33 Q_vq = -0.25 * dt2 * dt * var_g * A1;
  const double h = 0.5 * dt;  // p's row is v's times dt/2
  P_.block<3, 3>(0, 0) += h * h * Q_vv;
  P_.block<3, 3>(0, 6) += h * Q_vv;
  P_.block<3, 3>(6, 0) += h * Q_vv;
  P_.block<3, 3>(6, 6) += Q_vv;
  P_.block<3, 3>(0, 3) += h * Q_vq;
  P_.block<3, 3>(3, 0) += h * Q_vq.transpose();
  P_.block<3, 3>(6, 3) += Q_vq;
  P_.block<3, 3>(3, 6) += Q_vq.transpose();
  P_.block<3, 3>(3, 3).diagonal().array() += 0.5 * dt2 * var_g;
  P_.block<3, 3>(9, 9).diagonal().array() += dt2 * var_wa;
  P_.block<3, 3>(12, 12).diagonal().array() += dt2 * var_wg;
}

}  // namespace ch5
