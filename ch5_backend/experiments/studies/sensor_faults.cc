#include "ch5_backend/experiments/studies/sensor_faults.h"

#include <algorithm>
#include <cmath>

#include "ch5_backend/experiments/studies/recording_warnings.h"
#include "ch5_backend/math/median.h"
#include "ch5_backend/sparse/covariance.h"
#include "ch5_backend/types/inertial/edge_imu.h"
#include "ch5_backend/window/batch.h"
#include "ch5_backend/window/landmarks.h"
#include "ch5_backend/window/prediction.h"

namespace ch5 {
namespace {

using Fault = VertexVector<4>;

// EdgeImu's r with α and β of corrected readings, in which they are linear.
class EdgeImuOfReadings : public SizedEdge<15, VertexPose, VertexSpeedBias, VertexPose, VertexSpeedBias, Fault> {
 public:
  EdgeImuOfReadings(const Frame& i, const Frame& j, std::shared_ptr<Fault> fault, double gravity)
      : SizedEdge(i.pose, i.speed_bias, j.pose, j.speed_bias, std::move(fault)),
        imu_(i.pose, i.speed_bias, j.pose, j.speed_bias, j.imu, Vec3(0, 0, gravity)) {
    SetW(imu_.W());
    const std::vector<ImuSample>& samples = j.imu->Samples();
    for (int number = 0; number < 4; ++number) {
      std::vector<ImuSample> added = samples;  // to the readings, by 1 of it
      for (size_t k = 0; k < samples.size(); ++k) {
        const size_t from = k > 0 ? k - 1 : 0, to = std::min(k + 1, samples.size() - 1);
        const double seconds = samples[to].dt + (k > 0 && k < to ? samples[k].dt : 0.0);
        const Vec3& a = samples[k].acceleration;
        added[k].acceleration = number < 3 ? Vec3(a[number] * Vec3::Unit(number))
                                           : (samples[to].acceleration - samples[from].acceleration) / seconds;
      }
      const Preintegration imu(added, Vec3::Zero(), j.imu->BiasGyroscope(), ImuNoise());
      J_.col(number) << -imu.Alpha(), Vec3::Zero(), -imu.Beta(), Vec3::Zero(), Vec3::Zero();
    }
  }
  void ComputeResidual() override {
    imu_.ComputeResidual();
    r_ = imu_.GetResidual() + J_ * GetVertex<4>().GetEstimate();
  }
  void ComputeJacobians() override {
    imu_.ComputeJacobians();
    const EdgeImu& imu = imu_;
    J<0>() = imu.J<0>(), J<1>() = imu.J<1>(), J<2>() = imu.J<2>(), J<3>() = imu.J<3>(), J<4>() = J_;
  }
  std::string TypeInfo() const override { return "EdgeImuOfReadings"; }

 private:
  EdgeImu imu_;
  Eigen::Matrix<double, 15, 4> J_;
};

void Correct(const Fault::Estimate& fault, std::vector<ImuMeasurement>* imu) {
  const std::vector<ImuMeasurement> before = *imu;
  auto after = before.begin() + 1;
  for (ImuMeasurement& m : *imu) {
    const double t = m.t + fault[3];
    while (after + 1 != before.end() && after->t < t) ++after;
    const auto from = after - 1;
    const double share = std::clamp((t - from->t) / (after->t - from->t), 0.0, 1.0);
    m.acceleration = (from->acceleration + share * (after->acceleration - from->acceleration))
                         .cwiseProduct(Vec3::Ones() + fault.head<3>());
  }
}

void CorrectAccelerometer(const AccelerometerFault& found, Recording* recording, RecordingWarnings* warnings) {
  // At most 5.8 σ in recordings that are in order, 7.2 σ with other faults, 12 σ and more with these.
  constexpr double kLeastScale = 0.03, kLeastDelay = 5e-3, kSigmas = 10.0;
  constexpr double kMostScale = 0.2;  // beyond, something else is wrong
  if (!(found.value.head<3>().cwiseAbs().maxCoeff() < kMostScale)) return;
  Fault::Estimate decided = Fault::Estimate::Zero();
  for (int number = 0; number < 4; ++number) {
    const double value = found.value[number], sigma = found.sigma[number];
    if (!(std::abs(value) > std::max(number < 3 ? kLeastScale : kLeastDelay, kSigmas * sigma))) continue;
    decided[number] = value;
    if (number < 3) {
      const std::string axis(1, "xyz"[number]);
      warnings->push_back({"accelerometer_scale", 1.0 / (1.0 + value), sigma,
                           Join("the accelerometer's axis ", axis, " measures ", 1.0 / (1.0 + value), " ± ", sigma,
                                " times what it feels (corrected)"),
                           axis});
    } else {
      const std::string of = value > 0.0 ? "late" : "early";
      const auto ms = std::lround(1e3 * std::abs(value)), error = std::max(1L, std::lround(1e3 * sigma));
      warnings->push_back({"accelerometer_" + of, static_cast<double>(ms), static_cast<double>(error),
                           Join("the accelerometer's readings are ", ms, " ± ", error, " ms ", of,
                                " for the gyroscope's (corrected)")});
    }
  }
  if (!decided.isZero()) Correct(decided, &recording->imu);
}

// By how much each image is stamped later than images in even intervals about it, of which some may be missing.
std::vector<double> LateForEven(const std::vector<Image>& images) {
  constexpr size_t kBeside = 25;
  double interval = 0.0;
  for (const size_t apart : {size_t{1}, size_t{5}, kBeside}) {  // each so exact that the next can be counted
    std::vector<double> intervals;
    for (size_t k = 0; k + apart < images.size(); ++k) {
      const double seconds = images[k + apart].t - images[k].t;
      intervals.push_back(seconds / (apart == 1 ? 1.0 : std::max(1.0, std::round(seconds / interval))));
    }
    if (!intervals.empty()) interval = Median(intervals);
  }
  std::vector<double> late;
  for (size_t k = 0; k < images.size(); ++k) {
    std::vector<double> places;
    for (size_t i = k > kBeside ? k - kBeside : 0; i < std::min(images.size(), k + kBeside + 1); ++i)
      places.push_back(std::remainder(images[k].t - images[i].t, interval));
    late.push_back(Median(places));
  }
  return late;
}

// Of values among which a few are wild.
double SigmaOf(std::vector<double> values) {
  const double middle = Median(values);
  for (double& value : values) value = std::abs(value - middle);
  return Median(std::move(values)) / kMedianOfNormal;
}

void CorrectStamps(const std::vector<OdometryRun>& runs, Recording* recording, RecordingWarnings* warnings) {
  constexpr double kMost = 2.3e-3, kShare = 0.75;  // up to 1.7 ms in recordings that are in order [s]
  constexpr double kSeen = 0.5;                    // of a jitter; the windows' states take the rest
  constexpr size_t kFewest = 50;
  const std::vector<double> late_for_even = LateForEven(recording->images);
  double found = std::numeric_limits<double>::infinity(), left = 0.0;
  for (const OdometryRun& run : runs) {
    std::vector<double> late, rest;
    for (size_t k = 0; k < run.rows.size(); ++k) {
      if (std::isnan(run.rows[k].late)) continue;
      late.push_back(run.rows[k].late);
      rest.push_back(run.rows[k].late - kSeen * late_for_even[k]);
    }
    if (late.size() < kFewest) continue;
    if (const double sigma = SigmaOf(late); sigma < found) found = sigma, left = SigmaOf(rest);
  }
  if (found < kMost || std::isinf(found) || left > kShare * found) return;
  std::vector<Image> images = recording->images;
  for (size_t k = 0; k < images.size(); ++k) {
    images[k].t -= late_for_even[k];
    if (k > 0 && images[k].t <= images[k - 1].t) return;  // stamps so wrong that two are nearest to one time
  }
  recording->images = std::move(images);
  double squares = 0.0;
  for (const double seconds : late_for_even) squares += seconds * seconds;
  const double ms = 1e3 * std::sqrt(squares / static_cast<double>(late_for_even.size()));
  warnings->push_back({"stamps_even", ms, 1e3 * found,
                       Join("the images' stamps jitter by ", ms,
                            " ms (σ) about even intervals, and what is seen does not (corrected)")});
}

}  // namespace

std::optional<AccelerometerFault> FindAccelerometerFault(const Recording& recording, EstimatorOptions options,
                                                         const OdometryRun& run) {
  constexpr double kSpacing = 0.2, kSeconds = 40.0;  // [s]
  constexpr size_t kFewest = 40;
  std::vector<Image> images;
  std::vector<StampedState> states;
  const auto longest = LongestSegment(run);
  for (size_t k = 0; k < run.rows.size(); ++k) {
    const ImageResult& row = run.rows[k];
    if (!row.report.state || row.report.segment != longest->id) continue;
    if (!images.empty() && (row.t < images.back().t + kSpacing || row.t > images.front().t + kSeconds)) continue;
    images.push_back(recording.images[k]);
    states.push_back(*row.report.state);
  }
  if (images.size() < kFewest) return std::nullopt;
  const auto fault = std::make_shared<Fault>(Fault::Estimate::Zero());
  options.calibration = recording.calibration;
  options.estimate_extrinsic = true;       // a wrong one looks like a wrong axis
  options.start_bias_accelerometer = 3.0;  // an axis' length, times gravity, is a bias at first [m/s²]
  options.weights.max_imu_seconds = 1e-6;  // no other edges of the IMU
  options.own_edges = [&](const Window& window, Graph* graph) {
    graph->AddVertex(fault);
    for (size_t k = 1; k < window.frames.size(); ++k)
      graph->AddEdge(std::make_shared<EdgeImuOfReadings>(window.frames[k - 1], window.frames[k], fault,
                                                         window.calibration.gravity));
  };
  AccelerometerFault found;
  BatchOptions batch;
  batch.watch = [&](const Window& window) {
    found = {fault->GetEstimate(), CovarianceOf(window, *fault).diagonal().cwiseSqrt()};
  };
  try {
    SolveBatch(options, images, states, recording.imu, batch);
  } catch (const CovarianceError&) {
    return std::nullopt;  // a problem so ill determined tells nothing
  }
  return found;
}

double LateOfNewest(const Window& window) {
  constexpr size_t kFewest = 8;
  constexpr double kLeastSpeed = 0.03, kMostSigma = 2e-3;  // [rad/s], [s]
  if (window.frames.size() < 2) return kNoNumber;
  const Frame &newest = window.frames.back(), &before = window.frames[window.frames.size() - 2];
  if (!newest.imu || !before.speed_bias) return kNoNumber;
  const Transform T_W_B = Predict(window.StateOf(before), *newest.imu, window.calibration.gravity).T_W_B;
  const Transform T_B_C = window.T_B_C();
  std::vector<double> late;
  for (const auto& [id, landmark] : window.landmarks) {
    const WindowObservation& seen = landmark.seen.back();
    if (seen.frame != newest.id || !landmark.inverse_depth || seen.velocity.norm() < kLeastSpeed) continue;
    const Vec3 p_B = T_W_B.q.conjugate() * (LandmarkInWorld(window, landmark) - T_W_B.p);
    const Vec3 p_C = T_B_C.q.conjugate() * (p_B - T_B_C.p);
    late.push_back(seen.velocity.dot(p_C.hnormalized() - seen.x) / seen.velocity.squaredNorm());
  }
  if (late.size() < kFewest || SigmaOf(late) > kMostSigma * std::sqrt(late.size())) return kNoNumber;
  return Median(std::move(late));
}

RecordingWarnings CorrectFaults(const OdometryStudy& study, const OdometrySettings& settings, Recording* recording) {
  RecordingWarnings warnings;
  if (const auto found = FindAccelerometerFault(*recording, settings.estimator, study.runs.front()))
    CorrectAccelerometer(*found, recording, &warnings);
  if (warnings.empty()) CorrectStamps(study.runs, recording, &warnings);  // else the estimates err otherwise
  return warnings;
}

}  // namespace ch5
