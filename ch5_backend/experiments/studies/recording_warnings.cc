#include "ch5_backend/experiments/studies/recording_warnings.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <map>
#include <utility>

#include "ch5_backend/evaluate/turn_agreement.h"
#include "ch5_backend/experiments/studies/clock_check.h"
#include "ch5_backend/experiments/studies/lens_check.h"
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

// "-y, x, z"
std::string NameAxes(const Mat33& axes) {
  std::string names;
  for (int row = 0; row < 3; ++row) {
    Eigen::Index column;
    axes.row(row).cwiseAbs().maxCoeff(&column);
    names += std::string(row > 0 ? ", " : "") + (axes(row, column) < 0.0 ? "-" : "") + "xyz"[column];
  }
  return names;
}

// The gain is up to 1.03 in recordings that are in order, 1.3 to 4.7 with another lens's model, whose k is −0.2 to 0.55.
bool IsBent(const Disagreement& found) {
  const auto [k, sigma, gain] = found.lens;
  return gain > 1.2 && gain > std::max(found.focal.gain, found.gyroscope.gain) && std::abs(k) > 0.05 && k > -0.5 &&
         k < 1.0;
}

// Moves each point to where it was when the middle row was seen, if each 1 of y is seen `line` [s] later: x − ẋ line y.
void TakeBackShutter(double line, Recording* recording) {
  constexpr double kLongest = 0.5;  // between images of a track [s]
  struct Seen {
    double t;
    Vec2* x;
  };
  std::map<std::pair<int, int>, std::vector<Seen>> tracks;  // by camera and id
  for (Image& image : recording->images) {
    for (TrackedPoint& point : image.tracks) tracks[{0, point.id}].push_back({image.t, &point.x});
    for (TrackedPoint& point : image.tracks1) tracks[{1, point.id}].push_back({image.t, &point.x});
  }
  for (auto& [id, seen] : tracks) {
    std::vector<Vec2> moved;
    for (size_t k = 0; k < seen.size(); ++k) {
      const bool first = k == 0 || seen[k].t - seen[k - 1].t > kLongest;
      const bool last = k + 1 == seen.size() || seen[k + 1].t - seen[k].t > kLongest;
      const Seen &a = seen[first ? k : k - 1], &b = seen[last ? k : k + 1];
      const Vec2 velocity = (*b.x - *a.x) / std::max(b.t - a.t, 1e-9);
      moved.push_back(*seen[k].x - line * seen[k].x->y() * velocity);
    }
    for (size_t k = 0; k < seen.size(); ++k) *seen[k].x = moved[k];
  }
}

// The one cause, beside the lens, by which images and gyroscope agree best, if that is certain. Of recordings that are in
// order a focal length and a gyroscope are within 0.02 (0.06 with a guessed focal length), the others' values at most 7 of
// their σ; 10 % to four times beyond the limits here in recordings with 25 ms of shutter, 4° or 0.02 rad/s, the gain greatest.
void CheckTurnGain(const TurnAgreement& turns, const std::optional<Disagreement>& found, Recording* recording,
                   OdometrySettings* settings, RecordingWarnings* warnings) {
  constexpr double kLeastFocal = 0.07, kLeastGyroscope = 0.03, kLeastTurn = 0.02, kLeastGain = 1.15, kMost = 1.0;
  constexpr double kAlike = 0.8, kOtherUnit = 1.7;  // of correlation, of all turns together
  const double slope = turns.at_delay * std::sqrt(turns.noise);
  if (turns.at_delay > kAlike && std::max(slope, 1.0 / slope) > kOtherUnit) {
    warnings->push_back({"turns_unit", slope, kNoNumber,
                         Join("the images turn ", slope, " times as far as the gyroscope: is it in rad/s?")});
    return;
  }
  if (!found) return;
  Calibration& c = recording->calibration;
  const double seconds = recording->imu.back().t - recording->imu.front().t;
  const double allowed = c.noise.gyroscope_walk * std::sqrt(seconds);
  const struct {
    const Cause& cause;
    double least, sigmas, gain;
  } limits[] = {{found->focal, kLeastFocal, 8.0, kLeastGain},
                {found->gyroscope, kLeastGyroscope, 8.0, kLeastGain},
                {found->shutter, 0.0, 10.0, 1.0},
                {found->drift, 3.0 * allowed / seconds, 6.0, 1.0},
                {found->rotation, kLeastTurn, 12.0, 1.0}};
  const auto gain = [](const auto& limit) { return std::abs(limit.cause.value) < kMost ? limit.cause.gain : 0.0; };
  const auto best = std::max_element(std::begin(limits), std::end(limits),
                                     [&](const auto& a, const auto& b) { return gain(a) < gain(b); });
  const auto [value, sigma, times_better] = best->cause;
  if (std::abs(value) < std::max(best->least, best->sigmas * sigma) || std::abs(value) > kMost ||
      times_better < best->gain)
    return;
  const double error = std::max(sigma, 0.1 * std::abs(value));  // such are the errors in simulation
  if (&best->cause == &found->focal || &best->cause == &found->gyroscope) {
    const bool is_focal = &best->cause == &found->focal;
    const double times = is_focal ? 1.0 / (1.0 + value) : 1.0 + value;
    warnings->push_back(
        {is_focal ? "turns_focal" : "turns_gyroscope", times, error,
         Join(
             "the images turn ", times, " ± ", error, " times as far as the gyroscope: ",
             is_focal
                 ? "is the focal length right? Images and gyroscope agree best with it multiplied by this factor"
                 : "is the gyroscope's scale factor right? Both agree best with its rates multiplied by this factor")});
  } else if (&best->cause == &found->shutter) {
    const double ms = 1e3 * c.height / c.fy;  // of all rows
    TakeBackShutter(value, recording);
    warnings->push_back({"turns_shutter", ms * value, ms * error,
                         Join("the camera sees its rows one after another, the last ", ms * value, " ± ", ms * error,
                              " ms after the first, as a rolling shutter does: the estimators correct for it")});
  } else if (&best->cause == &found->drift) {
    c.noise.gyroscope_walk = value * std::sqrt(seconds);
    warnings->push_back(
        {"turns_drift", value * seconds, allowed,
         Join("the gyroscope's bias drifts by ", std::setprecision(3), value * seconds,
              " rad/s; imu.gyroscope_random_walk lets one expect ", allowed, ": the estimators use what was found")});
  } else {
    constexpr double kDegrees = 180.0 / M_PI;
    settings->estimator.estimate_extrinsic = true;
    warnings->push_back(
        {"turns_rotation", kDegrees * value, kDegrees * error,
         Join("the camera is turned by ", kDegrees * value, " ± ", kDegrees * error,
              "° against camera.q_B_C, or its principal point is off; its place on the body is estimated")});
  }
}

constexpr double kErrorOfTurns = 0.005;  // half a step of their search [s]

// "seems": the turns look like it; "corrected": the estimators run with it.
RecordingWarning ClockWarning(const std::string& kind, const ClockOffset& clock) {
  const bool is_late = clock.offset < 0.0;
  const double milliseconds = 1e3 * std::abs(clock.offset), sigma = std::max(1.0, std::round(1e3 * clock.sigma));
  const auto shown = std::lround(milliseconds);
  const std::string of = is_late ? "late" : "early";
  if (kind == "seems") {
    return {of, static_cast<double>(shown), sigma,
            Join("the images seem to be stamped about ", shown, " ms too ", of,
                 " for the IMU; --estimate-time-offset estimates how much")};
  }
  return {of + "_corrected", static_cast<double>(shown), sigma,
          Join("the camera's stamps are ", shown, " ± ", std::lround(sigma), " ms ", of, " (corrected)")};
}

void CheckTurns(OdometrySettings* settings, Recording* recording, bool seeks_cause, RecordingWarnings* warnings) {
  constexpr double kGood = 0.8, kGainOfAxes = 2.0;  // of the variance that is left
  const auto turns = CompareTurns(*recording);
  if (!turns) return;
  const auto delay = ClearDelay(*turns);
  const double otherwise = std::max(turns->with_axes, turns->with_inverse);
  const bool is_turned = otherwise > kGood && LeftVariance(turns->at_delay) > kGainOfAxes * LeftVariance(otherwise);
  // A lens spoils the turns of the images too.
  const auto found = is_turned || !seeks_cause ? std::nullopt : FindDisagreement(*recording, turns->delay);
  if (found && IsBent(*found)) {
    const Cause& lens = found->lens;
    warnings->push_back({"lens", lens.value, lens.gain,
                         Join("the images agree with one another and the gyroscope ", lens.gain,
                              " times better if their points are moved by 1 + k r², k = ", lens.value,
                              ": does the lens model (radial-tangential, equidistant or none) fit this camera?")});
    return;
  }
  if (is_turned || TurnOtherwise(*turns)) {
    warnings->push_back({"turns", turns->as_given, turns->with_inverse,
                         Join("the camera's rotation disagrees with the gyroscope (correlation ", turns->as_given,
                              "; with the inverse of camera.q_B_C ", turns->with_inverse,
                              "): it must rotate camera coordinates into the IMU's; ", turns->with_axes,
                              " with the gyroscope's columns read as ", NameAxes(turns->axes),
                              "; or are the clocks of camera and IMU more than 1.2 s apart?")});
    return;
  }
  CheckTurnGain(*turns, found, recording, settings, warnings);
  if (delay && (settings->finds_clock || settings->estimator.estimate_time_offset)) {
    settings->estimator.time_offset = *delay;
  } else if (delay) {
    warnings->push_back(ClockWarning("seems", {*delay, kErrorOfTurns}));
  }
}

// By how much the truth is stamped later than the estimates [s], where that is most of their distance; else 0. Too short a
// recording, or too small a distance, looks like many things.
double DelayOfTruth(const OdometryRun& run, const std::vector<StampedState>& truth) {
  constexpr double kStep = 0.02, kGain = 2.0, kLeastShare = 0.8;
  constexpr double kLeastSeconds = 5.0, kLeastError = 0.02;  // [m]
  constexpr int kSteps = 50;
  double delay = 0.0;
  if (!run.error || run.segments.size() != 1) return delay;
  if (run.states.back().t - run.states.front().t < kLeastSeconds || run.error->position_rmse < kLeastError)
    return delay;
  double least = run.error->position_rmse / kGain;
  for (int k = -kSteps; k <= kSteps; ++k) {
    std::vector<StampedState> states = run.states;
    for (StampedState& state : states) state.t += k * kStep;
    const auto error = CompareTrajectories(states, truth);
    const double fewest = kLeastShare * static_cast<double>(run.error->time.size());
    if (!error || error->position_rmse >= least || static_cast<double>(error->time.size()) < fewest) continue;
    least = error->position_rmse;
    delay = k * kStep;
  }
  return delay;
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

void CorrectTurnGain(const OdometrySettings& settings, RecordingWarnings* warnings, Recording* recording) {
  const auto found = std::find_if(warnings->begin(), warnings->end(), [](const RecordingWarning& warning) {
    return warning.name == "turns_focal" || warning.name == "turns_gyroscope";
  });
  Calibration& c = recording->calibration;
  if (found == warnings->end()) return;
  const bool is_focal = found->name == "turns_focal";
  if (is_focal && (c.camera1 || !settings.corrects_focal_length)) return;
  double times = 1.0;
  const auto correct = [&](double factor) {
    times *= factor;
    if (is_focal) {
      c.fx *= factor, c.fy *= factor;
      for (Image& image : recording->images)
        for (TrackedPoint& track : image.tracks) track.x /= factor;
    } else {
      for (ImuMeasurement& m : recording->imu) m.gyroscope *= factor;
    }
  };
  correct(found->value);
  // Each estimate errs by about a tenth of what it finds.
  std::optional<Cause> left;
  for (int round = 0; round < 2; ++round) {
    const auto now = FindDisagreement(*recording, settings.estimator.time_offset);
    left = now ? std::optional(is_focal ? now->focal : now->gyroscope) : std::nullopt;
    if (left) correct(is_focal ? 1.0 / (1.0 + left->value) : 1.0 + left->value);
  }
  // Where nothing is left to correct, the last estimate has no σ: it is told by what the correction gains.
  const double sigma = std::max(0.01 * times, left ? std::min(left->sigma, found->other) : found->other);
  *found = {is_focal ? "focal_corrected" : "gyroscope_corrected", times, sigma,
            Join("the images turn ", times, " ± ", sigma, " times as far as the gyroscope: ",
                 is_focal ? "the focal length" : "its rates", " multiplied by this factor (corrected)")};
}

RecordingWarnings CheckClock(const Recording& recording, OdometrySettings* settings) {
  if (!settings->finds_clock) return {};
  double* const offset = &settings->estimator.time_offset;
  const double guess = *offset;  // by the turns, 0 where they do not tell
  const auto clock = EstimateClockOffset(recording, settings->estimator, guess);
  if (clock && IsDecided(*clock)) {
    *offset = clock->offset;
    settings->clock_sigma = clock->sigma;
    return {ClockWarning("corrected", *clock)};
  }
  if (guess == 0.0) return {};
  // The turns of a few seconds, which are few, look like 20 ms now and then.
  constexpr double kSure = 0.035;  // [s]
  if (!clock && std::abs(guess) > kSure) {
    settings->clock_sigma = kErrorOfTurns;
    return {ClockWarning("corrected", {guess, kErrorOfTurns})};
  }
  *offset = 0.0;
  return {ClockWarning("seems", {guess, kErrorOfTurns})};
}

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
  if (best->inliers < kTimes * as_given.inliers + 1.0) return {};
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
  const double delay = DelayOfTruth(study.runs.front(), truth);
  if (delay != 0.0) {
    const auto milliseconds = std::lround(1e3 * std::abs(delay));
    warnings.push_back({delay > 0.0 ? "truth_late" : "truth_early", static_cast<double>(milliseconds), kNoNumber,
                        Join("groundtruth.csv seems to be stamped about ", milliseconds, " ms too ",
                             delay > 0.0 ? "late" : "early", " for the IMU, which explains most of the error")});
  }
  return warnings;
}

}  // namespace ch5
