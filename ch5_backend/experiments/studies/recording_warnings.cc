#include "ch5_backend/experiments/studies/recording_warnings.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "ch5_backend/evaluate/turn_agreement.h"
#include "ch5_backend/experiments/studies/turn_warnings.h"
#include "ch5_backend/math/median.h"
#include "ch5_backend/window/prediction.h"
#include "ch5_backend/window/start/dynamic_initialization.h"

namespace ch5 {
namespace {

// Images or states: the median of the time between two [s]; 0 if there are less than two.
template <typename Stamped>
double MedianStep(const std::vector<Stamped>& sequence) {
  std::vector<double> steps;
  for (size_t k = 1; k < sequence.size(); ++k) steps.push_back(sequence[k].t - sequence[k - 1].t);
  return steps.empty() ? 0.0 : Median(steps);
}

// What measures at another rate than the calibration says, or is lost on the way.
template <typename Stamped>
void CheckRate(const std::string& name, const std::string& spoken, const std::vector<Stamped>& sequence, double told,
               RecordingWarnings* warnings) {
  constexpr double kShare = 0.2;
  const double rate = static_cast<double>(sequence.size() - 1) / (sequence.back().t - sequence.front().t);
  if (std::abs(rate - told) < kShare * told) return;
  warnings->push_back(
      {name + "_rate", rate, told,
       Join("the ", spoken, " measures ", rate, " times a second, and ", told, " by ", name, ".rate_hz")});
}

// How far the positions at the times that both have lie from their mean, RMS [m]; zeros if there are none.
std::pair<double, double> SizesOfPaths(const std::vector<StampedState>& a, const std::vector<StampedState>& b) {
  std::vector<Vec3> of_a, of_b;
  for (auto i = a.begin(), j = b.begin(); i != a.end() && j != b.end();) {
    if (i->t == j->t) {
      of_a.push_back(i++->T_W_B.p);
      of_b.push_back(j++->T_W_B.p);
    } else {
      ++(i->t < j->t ? i : j);
    }
  }
  if (of_a.empty()) return {0.0, 0.0};
  const auto size = [](const std::vector<Vec3>& positions) {
    const Eigen::Map<const Eigen::Matrix3Xd> all(positions[0].data(), 3, static_cast<Eigen::Index>(positions.size()));
    return std::sqrt((all.colwise() - all.rowwise().mean().eval()).colwise().squaredNorm().mean());
  };
  return {size(of_a), size(of_b)};
}

// By how much the truth is stamped later than the estimates [s], where that is most of their distance, or of the angle between
// them; else 0.
double DelayOfTruth(const OdometryRun& run, const std::vector<StampedState>& truth) {
  constexpr double kStep = 0.02, kGain = 2.0, kLeastShare = 0.8;
  constexpr double kLeastError = 0.02, kLeastAngle = 0.02;  // [m, rad]: smaller ones look like many things
  constexpr int kSteps = 150;                               // 3 s
  int best = 0;
  double most = kGain;
  const TrajectoryError& given = *run.error;
  for (int k = -kSteps; k <= kSteps; ++k) {
    std::vector<StampedState> states = run.states;
    for (StampedState& state : states) state.t += k * kStep;
    const auto error = CompareTrajectories(states, truth);
    const double fewest = kLeastShare * static_cast<double>(given.time.size());
    if (!error || static_cast<double>(error->time.size()) < fewest) continue;
    const double gain = std::max(given.position_rmse < kLeastError ? 0.0 : given.position_rmse / error->position_rmse,
                                 given.rotation_rmse < kLeastAngle ? 0.0 : given.rotation_rmse / error->rotation_rmse);
    if (gain > most) most = gain, best = k;
  }
  return std::abs(best) == kSteps ? 0.0 : best * kStep;
}

// What the truth's positions or rotations agree with once they are read otherwise, if that is certain.
RecordingWarnings ReadTruthOtherwise(const OdometryRun& run, const std::vector<StampedState>& truth) {
  constexpr double kGain = 2.0, kLeastError = 0.05, kLeastAngle = 0.1;  // [m, rad]
  const auto error_if = [&](const auto& read) {
    std::vector<StampedState> other = truth;
    for (StampedState& state : other) read(&state.T_W_B);
    return CompareTrajectories(run.states, other);
  };
  const auto inverse = error_if([](Transform* T) { T->q = T->q.conjugate(); });
  if (inverse && run.error->rotation_rmse > std::max(kLeastAngle, kGain * inverse->rotation_rmse)) {
    return {{"truth_inverse", run.error->rotation_rmse, inverse->rotation_rmse,
             Join("the rotations of groundtruth.csv agree with ", run.policy, " only if they are inverted (",
                  inverse->rotation_rmse, " instead of ", run.error->rotation_rmse,
                  " rad): they must rotate the IMU's coordinates into the world's")}};
  }
  double least = run.error->position_rmse / kGain, trace = 0.0;
  std::string axes;
  for (const Mat33& P : SignedPermutations()) {
    const auto error = error_if([&](Transform* T) { T->p = P * T->p; });
    if (run.error->position_rmse < kLeastError || !error || error->position_rmse > 1.001 * least) continue;
    if (error->position_rmse > 0.999 * least && P.trace() <= trace) continue;  // turned about z, it is as good
    least = error->position_rmse;
    trace = P.trace();
    axes = NameAxes(P);
  }
  if (axes.empty()) return {};
  return {{"truth_axes", run.error->position_rmse, least,
           Join("the positions of groundtruth.csv agree with ", run.policy, " to ", least, " instead of ",
                run.error->position_rmse, " m if they are read as ", axes,
                ": its world must have z up and right-handed axes, for positions and rotations alike"),
           axes}};
}

// A truth that is read otherwise, or stamped late.
RecordingWarnings FaultsOfTruth(const OdometryRun& run, const std::vector<StampedState>& truth) {
  constexpr double kLeastSeconds = 5.0;  // shorter ones look like many things
  if (!run.error || run.segments.size() != 1 || run.states.back().t - run.states.front().t < kLeastSeconds) return {};
  const RecordingWarnings otherwise = ReadTruthOtherwise(run, truth);
  const double delay = otherwise.empty() ? DelayOfTruth(run, truth) : 0.0;
  if (delay == 0.0) return otherwise;
  const auto milliseconds = std::lround(1e3 * std::abs(delay));
  return {{delay > 0.0 ? "truth_late" : "truth_early", static_cast<double>(milliseconds), kNoNumber,
           Join("groundtruth.csv seems to be stamped about ", milliseconds, " ms too ", delay > 0.0 ? "late" : "early",
                " for the IMU, which explains most of the error")}};
}

// Whether the truth is many times as large as the estimates, and agrees with them in their size: an estimate that has failed
// may be as large, but of another shape.
bool IsOfAnotherUnit(const OdometryRun& run, std::vector<StampedState> truth) {
  constexpr double kScale = 50.0;  // estimates that have not failed keep theirs better
  constexpr double kPoor = 0.3;    // the error, relative to the size
  if (!run.error || !(std::max(run.error->scale, 1.0 / run.error->scale) > kScale)) return false;
  const double size = run.error->position_rmse / std::max(1.0, run.error->scale);  // the larger of two so unlike
  for (StampedState& state : truth) state.T_W_B.p /= run.error->scale;
  const auto error = CompareTrajectories(run.states, truth);
  return error && error->position_rmse < kPoor * size;
}

constexpr size_t kWindows = 12;  // spread over a recording

// Ten images, from number k on.
std::vector<InitializationImage> WindowFrom(size_t k, const Recording& recording) {
  constexpr size_t kImages = 10;
  constexpr double kSpacing = 0.15;  // [s]
  std::vector<InitializationImage> images;
  StampedState last;
  for (; k < recording.images.size() && images.size() < kImages; ++k) {
    const Image& frame = recording.images[k];
    if (!images.empty() && frame.t < last.t + kSpacing) continue;
    images.push_back({frame.t, frame.tracks, nullptr});
    if (images.size() > 1) images.back().imu = IntegrateFrom(last, recording.imu, frame.t, recording.calibration.noise);
    last.t = frame.t;
  }
  return images;
}

// What has come of the first windows, if the accelerometer's columns are read so.
struct Starts {
  Mat33 axes;
  size_t windows = 0;
  int count = 0;  // of those that start in motion
  double inliers = 0.0;

  double AtMost() const { return inliers + static_cast<double>(kWindows - windows); }

  void TryNext(std::vector<InitializationImage> window, const Calibration& calibration) {
    for (InitializationImage& image : window) {
      if (!image.imu) continue;
      std::vector<ImuSample> samples = image.imu->Samples();
      for (ImuSample& sample : samples) sample.acceleration = axes * sample.acceleration;
      image.imu = std::make_shared<Preintegration>(samples, Vec3::Zero(), Vec3::Zero(), calibration.noise);
    }
    DynamicInitializationOptions options;
    options.T_B_C = calibration.T_B_C;
    options.focal_length = calibration.FocalLength();
    options.gravity = calibration.gravity;
    const DynamicInitialization start = InitializeDynamically(window, options);
    ++windows;
    if (start.failure != InitializationFailure::kNone) return;
    ++count;
    inliers += start.inliers;
  }
};

}  // namespace

RecordingWarnings CheckFailures(const OdometryStudy& study) {
  constexpr double kTimes = 1.4;  // and one more: of windows that start, their share of inliers is what counts
  const auto failed = [](const OdometryRun& run) { return run.states.empty() || run.restarts > 0; };
  if (std::none_of(study.runs.begin(), study.runs.end(), failed)) return {};
  const Recording& recording = study.recording;
  std::vector<std::vector<InitializationImage>> windows;
  for (size_t w = 0; w < kWindows; ++w)
    windows.push_back(WindowFrom(w * recording.images.size() / kWindows, recording));
  const auto try_next = [&](Starts* starts) { starts->TryNext(windows[starts->windows], recording.calibration); };
  Starts as_given{Mat33::Identity()};
  while (as_given.windows < kWindows) try_next(&as_given);
  // A window takes long: the axes that may still be the best are tried next, until theirs are all tried or too few remain.
  std::vector<Starts> all;
  for (const Mat33& axes : SignedPermutations()) all.push_back({axes});
  const auto is_less = [](const Starts& a, const Starts& b) { return a.AtMost() < b.AtMost(); };
  auto best = all.begin();
  while ((best = std::max_element(all.begin(), all.end(), is_less))->windows < kWindows) {
    if (best->AtMost() < kTimes * as_given.inliers + 1.0) return {};
    try_next(&*best);
  }
  // On a circle at constant speed hardly a window starts, whatever the axes; 3 or 4 of 12 do with wrong ones.
  if (best->inliers < kTimes * as_given.inliers + 1.0 || 2 * best->count < static_cast<int>(kWindows)) return {};
  return {{"force", static_cast<double>(best->count), static_cast<double>(as_given.count),
           Join("images and accelerometer contradict each other: of ", kWindows, " windows ", as_given.count,
                " start in motion, and ", best->count, " if its columns are read as ", NameAxes(best->axes),
                "; at rest it must measure +", recording.calibration.gravity, " upwards")}};
}

RecordingWarnings CheckStarts(const OdometryStudy& study) {
  // Up to 0.052 in recordings that tell the scale, 0.076 and more on a circle at constant speed.
  constexpr double kMost = 0.06;
  double sigma = kMost, t = 0.0;
  for (const OdometryRun& run : study.runs) {
    for (const ImageResult& row : run.rows) {
      if (row.report.scale_sigma.value_or(0.0) <= sigma) continue;
      sigma = *row.report.scale_sigma;
      t = row.t;
    }
  }
  if (sigma == kMost) return {};
  const auto percent = std::lround(100.0 * std::min(sigma, 10.0));  // beyond, how little is known makes no difference
  return {{"scale", static_cast<double>(percent), t,
           Join("just after the estimator started (at ", t, " s) it knew the scale only to ±", percent,
                " %: lengths may be wrong by as much; only a change of speed or direction determines the scale"),
           "", t}};
}

RecordingWarnings CheckMeasurements(OdometrySettings* settings, Recording* recording, bool seeks_cause) {
  constexpr double kMost = 0.5;  // [s]: see the table in the guide; up to this time between images the policies go on
  RecordingWarnings warnings;
  CheckRate("imu", "IMU", recording->imu, recording->calibration.imu_rate, &warnings);
  CheckRate("camera", "camera", recording->images, recording->calibration.camera_rate, &warnings);
  if (const double median = MedianStep(recording->images); median > kMost) {
    warnings.push_back({"distant_images", median, kMost,
                        Join("the images are ", median, " s apart (median); above ", kMost,
                             " s too few tracks last, and the estimates drift or restart")});
  }
  CheckTurns(settings, recording, seeks_cause, &warnings);
  return warnings;
}

RecordingWarnings CheckAgreement(const OdometryStudy& study) {
  constexpr double kTimes = 1.2;  // at most 1.03 in public recordings and undisturbed flights
  constexpr double kFar = 0.3;    // [m]: smaller paths tell no scale
  std::vector<std::pair<std::string, const OdometrySegment*>> paths;  // by policy
  for (const OdometryRun& run : study.runs) {
    for (const OdometrySegment& segment : run.segments) paths.emplace_back(run.policy, &segment);
  }
  RecordingWarnings found;
  double most = kTimes;
  for (const auto& [policy_a, a] : paths) {
    for (const auto& [policy_b, b] : paths) {
      if (policy_a == policy_b) continue;
      const auto [smaller, larger] = SizesOfPaths(a->states, b->states);  // the other order is another turn
      if (larger < kFar || larger < most * smaller) continue;
      most = larger / smaller;
      found = {{"disagreement", smaller, larger,
                Join("the paths of ", policy_a, " and ", policy_b, " through the same images are ", smaller, " and ",
                     larger, " m large (RMS from their middle): at least one is wrong; calibration, clocks and noise ",
                     "are the usual causes"),
                policy_a + ", " + policy_b}};
    }
  }
  return found;
}

RecordingWarnings CheckResiduals(const OdometryStudy& study, const OdometrySettings& settings) {
  // Up to 0.75 px in recordings that are in order, 1.1 to 3.5 px with faults that make an estimate several times as wrong.
  constexpr double kMost = 1.0;
  constexpr double kHosts = 1.25;  // of the tracks' variance: a landmark's first point has noise too
  const double noise = settings.track_noise, most = std::max(kMost, noise);
  for (const OdometryRun& run : study.runs) {
    const double off = std::sqrt(std::max(0.0, run.pixels_off * run.pixels_off - kHosts * noise * noise));
    if (!(noise > 0.0 && off > most)) continue;
    return {
        {"residuals", off, noise,
         Join("new images lie ", off, " px from where the window of ", run.policy, " and the IMU expect them, beyond ",
              "the ", noise, " px that the tracks' noise explains: images, IMU and calibration contradict each other; ",
              "usual causes are camera.p_B_C, the intrinsics, the IMU's noise, stamps that jitter and tracks that "
              "creep"),
         run.policy}};
  }
  return {};
}

RecordingWarnings CheckComparison(const OdometryStudy& study) {
  constexpr double kMost = 0.25;  // [s]: at 2 m/s² a straight line errs by 2 cm
  const std::vector<StampedState>& truth = study.recording.truth;
  if (truth.empty()) return {};
  const auto is_compared = [](const OdometryRun& run) { return run.error || run.relative; };
  if (std::none_of(study.runs.begin(), study.runs.end(), is_compared)) {
    const std::vector<Image>& frames = study.recording.images;
    return {
        {"no_comparison", kNoNumber, kNoNumber,
         Join("no estimate was compared with groundtruth.csv: its ", truth.size(), " poses are from ", truth.front().t,
              " to ", truth.back().t, " s, the images from ", frames.front().t, " to ", frames.back().t,
              " s after the first IMU measurement; nothing is compared between poses more than 1 s apart")}};
  }
  RecordingWarnings warnings;
  if (const double median = MedianStep(truth); median > kMost) {
    warnings.push_back(
        {"distant_truth", median, kNoNumber,
         Join("the poses of groundtruth.csv are ", median,
              " s apart (median): between them it is interpolated linearly, which adds an error, and where "
              "they are more than 1 s apart nothing is compared")});
  }
  const auto is_of_another_unit = [&](const OdometryRun& run) { return IsOfAnotherUnit(run, truth); };
  const auto run = std::find_if(study.runs.begin(), study.runs.end(), is_of_another_unit);
  if (run != study.runs.end()) {
    warnings.push_back({"truth_unit", run->error->scale, kNoNumber,
                        Join("groundtruth.csv moves ", run->error->scale, " times as far as ", run->policy,
                             " estimates; is it in meters?")});
  }
  const RecordingWarnings of_truth = FaultsOfTruth(study.runs.front(), truth);
  warnings.insert(warnings.end(), of_truth.begin(), of_truth.end());
  return warnings;
}

}  // namespace ch5
