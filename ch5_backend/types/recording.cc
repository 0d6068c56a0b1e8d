#include "ch5_backend/types/recording.h"

#include <algorithm>
#include <iomanip>
#include <sstream>

#include "ch5_backend/math/median.h"
#include "ch5_backend/math/option_checks.h"

namespace ch5 {

void Calibration::Validate() const {
  CheckOption("Calibration::T_B_C.q.norm()", T_B_C.q.norm(), 0.99, 1.01);
  CheckOption("Calibration::T_B_C.p.norm()", T_B_C.p.norm(), 0, 1e3);
  CheckPositive("Calibration::fx", fx);
  CheckPositive("Calibration::fy", fy);
  CheckPositive("Calibration::gravity", gravity);
  if (camera1) {
    CheckOption("Calibration::camera1->T_B_C.q.norm()", camera1->T_B_C.q.norm(), 0.99, 1.01);
    CheckOption("Calibration::camera1->T_B_C.p.norm()", camera1->T_B_C.p.norm(), 0, 1e3);
    CheckPositive("Calibration::camera1->fx", camera1->fx);
    CheckPositive("Calibration::camera1->fy", camera1->fy);
  }
  noise.Validate();
}

namespace {
constexpr double kLongestGap = 1.0;  // [s]
constexpr double kOffCenter = 0.45;  // of the image: what is cut off an image may shift its principal point far
}  // namespace

std::string WhyNotInPixels(const Camera& camera) {
  const double size = std::max(camera.width, camera.height), cx = camera.cx, cy = camera.cy;
  const auto [least, most] = std::minmax(camera.fx, camera.fy);
  std::ostringstream why;
  if (!(least >= 0.1 * size && most <= 100.0 * size)) {  // a fisheye of 270° has 0.21, half a degree 115
    why << "focal lengths of " << camera.fx << " and " << camera.fy << " px do not fit";
  } else if (std::abs(cx / camera.width - 0.5) > kOffCenter || std::abs(cy / camera.height - 0.5) > kOffCenter) {
    why << "the principal point (" << cx << ", " << cy << ") px lies outside or at the edge of";
  } else {
    return "";
  }
  why << " an image of " << camera.width << " × " << camera.height << " pixels";
  return why.str();
}

std::string WhyNotInUnits(const std::vector<ImuMeasurement>& imu, const Calibration& calibration) {
  if (imu.size() < 2) return "at least two IMU measurements are needed";
  std::vector<double> steps, forces, turns;
  for (size_t k = 1; k < imu.size(); ++k) steps.push_back(imu[k].t - imu[k - 1].t);
  for (const ImuMeasurement& measurement : imu) {
    forces.push_back(measurement.acceleration.norm());
    turns.push_back(measurement.gyroscope.lpNorm<Eigen::Infinity>());
  }
  const double force = Median(forces);
  constexpr double kFastest = 40.0;  // [rad/s]: no common gyroscope measures more than 2,000°/s
  const double rate_of_turns = Quantile(turns, 0.99);
  std::ostringstream why;
  if (const double rate = 1.0 / Median(steps);
      rate > 20.0 * calibration.imu_rate || rate < calibration.imu_rate / 20.0) {
    why << "the timestamps tell of " << rate << " measurements a second, the calibration of " << calibration.imu_rate
        << ": is one of them wrong? Timestamps are in nanoseconds";
  } else if (rate_of_turns > kFastest) {
    why << "the rates are up to " << rate_of_turns
        << " rad/s (a hundredth is above), more than a gyroscope measures: are "
        << "they in degrees? Then call their columns w_x [deg/s] and so on";
  } else if (force < 0.4 * calibration.gravity || force > 2.5 * calibration.gravity) {
    why << "the accelerations are " << force << " m/s² long (median), where gravity alone is " << calibration.gravity
        << ": are they swapped with the rates, in another unit, or without gravity?";
  }
  return why.str();
}

std::string ClocksDiffer(double first, double last, const std::vector<ImuMeasurement>& imu) {
  std::ostringstream what;
  what << std::fixed << std::setprecision(2)
       << "the clocks of camera and IMU differ: no image lies within the IMU's time; the images are from " << first
       << " s to " << last << " s after its first measurement, its last is at " << imu.back().t << " s";
  return what.str();
}

void DifferentiatePositions(std::vector<StampedState>* states) {
  for (size_t i = 0; i < states->size(); ++i) {
    const StampedState& before = (*states)[i == 0 ? 0 : i - 1];
    const StampedState& after = (*states)[std::min(i + 1, states->size() - 1)];
    if (after.t > before.t) (*states)[i].v_W = (after.T_W_B.p - before.T_W_B.p) / (after.t - before.t);
  }
}

std::optional<StampedState> StateAt(const std::vector<StampedState>& states, double t) {
  const auto after = std::lower_bound(states.begin(), states.end(), t,
                                      [](const StampedState& state, double s) { return state.t < s; });
  if (after == states.end()) return std::nullopt;
  if (after->t == t) return *after;
  if (after == states.begin()) return std::nullopt;
  const auto before = std::prev(after);
  if (after->t - before->t > kLongestGap) return std::nullopt;
  const double weight = (t - before->t) / (after->t - before->t);
  const auto blend = [weight](const Vec3& x0, const Vec3& x1) -> Vec3 { return x0 + weight * (x1 - x0); };
  StampedState state;
  state.t = t;
  state.T_W_B = {before->T_W_B.q.slerp(weight, after->T_W_B.q), blend(before->T_W_B.p, after->T_W_B.p)};
  state.v_W = blend(before->v_W, after->v_W);
  state.b_a = blend(before->b_a, after->b_a);
  state.b_g = blend(before->b_g, after->b_g);
  return state;
}

}  // namespace ch5
