#include "ch5_backend/window/prediction.h"

#include <algorithm>
#include <cmath>

#include "ch5_backend/math/array_memory.h"
#include "ch5_backend/window/measurement_checks.h"

namespace ch5 {

std::shared_ptr<Preintegration> IntegrateFrom(const StampedState& from, const std::vector<ImuMeasurement>& imu,
                                              double t1, const ImuNoise& noise) {
  const ImuMeasurement &first = imu.front(), &last = imu.back();
  if (first.t > from.t || last.t < t1) {
    std::vector<ImuMeasurement> held = imu;
    if (first.t > from.t) held.insert(held.begin(), {from.t, first.acceleration, first.gyroscope});
    if (last.t < t1) held.push_back({t1, last.acceleration, last.gyroscope});
    return IntegrateFrom(from, held, t1, noise);
  }
  std::vector<ImuSample> samples = SamplesBetween(imu, from.t, t1);
  if (samples.size() == 2) {  // a single step would give position and speed the same noise: a singular covariance
    const double half = 0.5 * samples[1].dt;
    samples.insert(samples.begin() + 1, {half, 0.5 * (samples[0].acceleration + samples[1].acceleration),
                                         0.5 * (samples[0].gyroscope + samples[1].gyroscope)});
    samples[2].dt = half;
  }
  return MakeShared<Preintegration>(std::move(samples), from.b_a, from.b_g, noise);
}

void ImuUnsteadiness::Add(const ImuMeasurement& measurement) {
  constexpr double kStep = 0.1, kMemory = 5.0;  // [s]: over the former noise and vibration hardly count
  if (!from_) from_ = measurement;
  const double dt = measurement.t - from_->t;
  if (dt < kStep) return;
  const auto update = [&](const Vec3& step, double* q2) {
    const double now = step.squaredNorm() / (3.0 * dt);
    *q2 += (q2_a_ < 0.0 ? 1.0 : std::min(1.0, dt / kMemory)) * (now - *q2);
  };
  update(measurement.gyroscope - from_->gyroscope, &q2_g_);
  update(measurement.acceleration - from_->acceleration, &q2_a_);
  from_ = measurement;
}

ImuNoise ImuUnsteadiness::AcrossGap(double seconds, ImuNoise noise) const {
  const double times = seconds / std::sqrt(12.0);
  noise.accelerometer = std::hypot(noise.accelerometer, times * std::sqrt(std::max(0.0, q2_a_)));
  noise.gyroscope = std::hypot(noise.gyroscope, times * std::sqrt(std::max(0.0, q2_g_)));
  noise.continuous = true;
  return noise;
}

StampedState Predict(const StampedState& from, const Preintegration& imu, double gravity) {
  const double t = imu.SumDt();
  const Vec3 G(0, 0, gravity);
  const Qd& q = from.T_W_B.q;
  StampedState to = from;
  to.t = from.t + t;
  to.T_W_B.p = from.T_W_B.p + t * from.v_W - 0.5 * t * t * G + q * imu.Alpha();
  to.T_W_B.q = q * imu.Gamma();
  to.v_W = from.v_W - t * G + q * imu.Beta();
  return to;
}

std::optional<StampedState> PredictAt(const StampedState& from, const std::vector<ImuMeasurement>& imu, double t,
                                      const Calibration& calibration, double max_gap, double max_age) {
  if (t == from.t) return from;
  if (!(t > from.t && t - from.t <= max_age) || LongestImuGap(imu, from.t, t) > max_gap) return std::nullopt;
  StampedState state = Predict(from, *IntegrateFrom(from, imu, t, calibration.noise), calibration.gravity);
  state.t = t;  // without the rounding of a sum
  return state;
}

}  // namespace ch5
