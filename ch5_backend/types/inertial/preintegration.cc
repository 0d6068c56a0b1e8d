#include "ch5_backend/types/inertial/preintegration.h"

#include <cmath>
#include <stdexcept>
#include <string>
#include <utility>

#include "ch5_backend/math/simd.h"

namespace ch5 {
namespace {

void RequireFinite(const ImuSample& sample) {
  if (!sample.acceleration.allFinite() || !sample.gyroscope.allFinite()) {
    throw std::invalid_argument("Preintegration: an IMU sample holds a number that is not finite");
  }
}

void RequireStep(const ImuSample& sample) {
  RequireFinite(sample);
  if (!(sample.dt > 0.0) || !std::isfinite(sample.dt)) {
    throw std::invalid_argument("Preintegration: the time step must be positive, got " + std::to_string(sample.dt));
  }
}

}  // namespace

Preintegration::Preintegration(const ImuSample& first, const Vec3& b_a, const Vec3& b_g, const ImuNoise& noise)
    : Preintegration(std::vector<ImuSample>{first}, b_a, b_g, noise) {}

Preintegration::Preintegration(std::vector<ImuSample> samples, const Vec3& b_a, const Vec3& b_g, const ImuNoise& noise)
    : samples_(std::move(samples)), b_a_(b_a), b_g_(b_g), noise_(noise) {
  if (samples_.empty()) throw std::invalid_argument("Preintegration: there is no IMU sample");
  RequireFinite(samples_.front());
  samples_.front().dt = 0.0;
  Reset();
  for (size_t k = 1; k < samples_.size(); ++k) {
    RequireStep(samples_[k]);
    Step(samples_[k - 1], samples_[k]);
  }
}

void Preintegration::Add(const ImuSample& sample) {
  RequireStep(sample);
  Step(samples_.back(), sample);
  samples_.push_back(sample);
}

void Preintegration::Reintegrate(const Vec3& b_a, const Vec3& b_g) {
  b_a_ = b_a;
  b_g_ = b_g;
  Reset();
  for (size_t k = 1; k < samples_.size(); ++k) Step(samples_[k - 1], samples_[k]);
  AddWalk(walk_seconds_);
}

void Preintegration::LetBiasesWalk(double seconds) {
  walk_seconds_ += seconds;
  AddWalk(seconds);
  ++revision_;
}

// As the steps of the interval add, each a number per step where the noise is not a density.
void Preintegration::AddWalk(double seconds) {
  const double step =
      noise_.continuous || samples_.size() < 2 ? 1.0 : sum_dt_ / static_cast<double>(samples_.size() - 1);
  P_.block<3, 3>(9, 9).diagonal().array() += seconds * step * noise_.accelerometer_walk * noise_.accelerometer_walk;
  P_.block<3, 3>(12, 12).diagonal().array() += seconds * step * noise_.gyroscope_walk * noise_.gyroscope_walk;
}

void Preintegration::Append(const Preintegration& next) {
  const size_t size = next.samples_.size();  // `next` may be this one, which grows
  for (size_t k = 1; k < size; ++k) Add(ImuSample(next.samples_[k]));
  if (next.noise_.accelerometer <= noise_.accelerometer) return;
  noise_ = next.noise_;  // one for all samples: that of a gap, which is not to look like a measurement
  Reintegrate(b_a_, b_g_);
}

void Preintegration::Reset() {
  sum_dt_ = 0.0;
  alpha_.setZero();
  beta_.setZero();
  gamma_.setIdentity();
  J_.setZero();
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
// and the noise of the two samples enters as P ← F P Fᵀ + V Q Vᵀ (VINS-Mono's report, eqs. 9–10).
CH5_FLATTEN void Preintegration::Step(const ImuSample& s0, const ImuSample& s1) {
  ++revision_;
  const double dt = s1.dt, dt2 = dt * dt;
  const Vec3 omega = 0.5 * (s0.gyroscope + s1.gyroscope) - b_g_;
  const Vec3 half = 0.5 * dt * omega;
  const Qd gamma1 = (gamma_ * Qd(1.0, half.x(), half.y(), half.z())).normalized();
  const Mat33 R0 = gamma_.toRotationMatrix(), R1 = gamma1.toRotationMatrix();
  const Vec3 a0 = s0.acceleration - b_a_, a1 = s1.acceleration - b_a_;
  const Vec3 a = 0.5 * (R0 * a0 + R1 * a1);

  const Mat33 A0 = R0 * Hat(a0), A1 = R1 * Hat(a1);
  Transition F;
  F.dt = dt;
  F.qq = Mat33::Identity() - dt * Hat(omega);
  F.vq = -0.5 * dt * (A0 + A1 * F.qq);
  F.va = -0.5 * dt * (R0 + R1);
  F.vg = 0.5 * dt2 * A1;
  MoveBiasJacobian(F);
  MoveCovariance(F);
  AddNoise(A1, dt);

  alpha_ += beta_ * dt + 0.5 * dt2 * a;
  beta_ += a * dt;
  gamma_ = gamma1;
  sum_dt_ += dt;
}

// J ← F J for the columns of the biases; that of b_a has nothing in the row θ.
CH5_FLATTEN void Preintegration::MoveBiasJacobian(const Transition& F) {
  auto J_pa = J_.block<3, 3>(0, 0), J_pg = J_.block<3, 3>(0, 3), J_qg = J_.block<3, 3>(3, 3);
  auto J_va = J_.block<3, 3>(6, 0), J_vg = J_.block<3, 3>(6, 3);
  const double h = 0.5 * F.dt;  // p's row is v's times dt/2, plus p's own and v dt
  const Mat33 dv_g = F.vq * J_qg + F.vg;
  J_pa += F.dt * J_va + h * F.va;
  J_pg += F.dt * J_vg + h * dv_g;
  J_qg = (F.qq * J_qg).eval();
  J_qg.diagonal().array() -= F.dt;
  J_va += F.va;
  J_vg += dv_g;
}

// P ← F P Fᵀ, block by block: M = F P, then M Fᵀ on and above the diagonal. As the biases walk each for itself, their own
// blocks are multiples of I, P_ag and P_qa are zero, and F leaves all of these as they are: written out densely, this
// would be most of a window's preintegration.
CH5_FLATTEN void Preintegration::MoveCovariance(const Transition& F) {
  const double dt = F.dt, h = 0.5 * dt, P_aa = P_(9, 9), P_gg = P_(12, 12);
  const auto block = [this](int row, int column) { return P_.block<3, 3>(row, column); };
  const Mat33 P_qq = block(3, 3), P_qv = block(3, 6), P_pa = block(0, 9), P_va = block(6, 9);
  const Mat33 P_pq = block(0, 3), P_pg = block(0, 12), P_qg = block(3, 12), P_vg = block(6, 12);
  const Mat33 P_pv = block(0, 6), P_vv = block(6, 6);

  // What v's row gains in each column;  p's row gains dt times v's, and h times that.
  const Mat33 dv_p = F.vq * P_pq.transpose() + F.va * P_pa.transpose() + F.vg * P_pg.transpose();
  const Mat33 dv_q = F.vq * P_qq + F.vg * P_qg.transpose();
  const Mat33 dv_v = F.vq * P_qv + F.va * P_va.transpose() + F.vg * P_vg.transpose();
  const Mat33 dv_a = P_aa * F.va;
  const Mat33 dv_g = F.vq * P_qg + P_gg * F.vg;
  const Mat33 M_pp = block(0, 0) + dt * P_pv.transpose() + h * dv_p, M_pv = P_pv + dt * P_vv + h * dv_v;
  const Mat33 M_pq = P_pq + dt * P_qv.transpose() + h * dv_q, M_vq = P_qv.transpose() + dv_q;
  const Mat33 M_pa = P_pa + dt * P_va + h * dv_a, M_va = P_va + dv_a;
  const Mat33 M_pg = P_pg + dt * P_vg + h * dv_g, M_vg = P_vg + dv_g, M_vv = P_vv + dv_v;
  Mat33 M_qg = F.qq * P_qg;
  M_qg.diagonal().array() -= dt * P_gg;
  const Mat33 M_qq = F.qq * P_qq - dt * P_qg.transpose();

  // The same for the columns.
  const Mat33 p_dv = M_pq * F.vq.transpose() + M_pa * F.va.transpose() + M_pg * F.vg.transpose();
  const Mat33 v_dv = M_vq * F.vq.transpose() + M_va * F.va.transpose() + M_vg * F.vg.transpose();
  block(0, 0) = M_pp + dt * M_pv + h * p_dv;
  block(0, 3) = M_pq * F.qq.transpose() - dt * M_pg;
  block(0, 6) = M_pv + p_dv;
  block(0, 9) = M_pa;
  block(0, 12) = M_pg;
  block(3, 3) = M_qq * F.qq.transpose() - dt * M_qg;
  block(3, 6) = F.qq * M_vq.transpose() - dt * M_vg.transpose();
  block(3, 12) = M_qg;
  block(6, 6) = M_vv + v_dv;
  block(6, 9) = M_va;
  block(6, 12) = M_vg;
}

// V Q Vᵀ for isotropic noise, where R₀R₀ᵀ = R₁R₁ᵀ = I. The columns of V, over a₀, g₀, a₁, g₁, w_a, w_g:
//   p: ¼R₀dt², −⅛A₁dt³, ¼R₁dt², −⅛A₁dt³;   θ: –, ½dt I, –, ½dt I;   v = p · 2/dt;   b_a: dt I;   b_g: dt I
CH5_FLATTEN void Preintegration::AddNoise(const Mat33& A1, double dt) {
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
  P_.block<3, 3>(6, 6) += Q_vv;
  P_.block<3, 3>(0, 3) += h * Q_vq;
  P_.block<3, 3>(3, 6) += Q_vq.transpose();
  P_.block<3, 3>(3, 3).diagonal().array() += 0.5 * dt2 * var_g;
  P_.block<3, 3>(9, 9).diagonal().array() += dt2 * var_wa;
  P_.block<3, 3>(12, 12).diagonal().array() += dt2 * var_wg;
}

}  // namespace ch5
