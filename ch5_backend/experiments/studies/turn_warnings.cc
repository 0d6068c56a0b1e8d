#include "ch5_backend/experiments/studies/turn_warnings.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <map>
#include <utility>

#include "ch5_backend/evaluate/turn_agreement.h"
#include "ch5_backend/experiments/studies/clock_check.h"
#include "ch5_backend/experiments/studies/lens_check.h"
#include "ch5_backend/experiments/studies/recording_warnings.h"

namespace ch5 {
namespace {

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

double Duration(const Recording& recording) { return recording.imu.back().t - recording.imu.front().t; }

// The one cause, beside the lens, by which images and gyroscope agree best, if that is certain; else null. Of recordings that are
// in order a focal length and a gyroscope are within 0.02 (0.06 with a guessed focal length), the others' values at most 7 of
// their σ; 10 % to four times beyond the limits here in recordings with 25 ms of shutter, 4° or 0.02 rad/s, the gain greatest.
// @param allowed  the drift that is no fault [rad/s²]
const Cause* CertainCause(const Disagreement& found, double allowed) {
  constexpr double kLeastFocal = 0.07, kLeastGyroscope = 0.03, kLeastTurn = 0.02, kLeastGain = 1.15, kMost = 1.0;
  const struct {
    const Cause& cause;
    double least, sigmas, gain;
  } limits[] = {{found.focal, kLeastFocal, 8.0, kLeastGain},
                {found.gyroscope, kLeastGyroscope, 8.0, kLeastGain},
                {found.shutter, 0.0, 10.0, 1.0},
                {found.drift, 3.0 * allowed, 6.0, 1.0},
                {found.rotation, kLeastTurn, 12.0, 1.0}};
  const auto gain = [](const auto& limit) { return std::abs(limit.cause.value) < kMost ? limit.cause.gain : 0.0; };
  const auto best = std::max_element(std::begin(limits), std::end(limits),
                                     [&](const auto& a, const auto& b) { return gain(a) < gain(b); });
  const auto [value, sigma, times_better] = best->cause;
  const double size = std::abs(value);
  const bool is_doubtful =
      size < std::max(best->least, best->sigmas * sigma) || size > kMost || times_better < best->gain;
  return is_doubtful ? nullptr : &best->cause;
}

RecordingWarning GainWarning(bool is_focal, double value, double error) {
  const double times = is_focal ? 1.0 / (1.0 + value) : 1.0 + value;
  return {
      is_focal ? "turns_focal" : "turns_gyroscope", times, error,
      Join("the images turn ", times, " ± ", error, " times as far as the gyroscope: ",
           is_focal
               ? "is the focal length right? Images and gyroscope agree best with it multiplied by this factor"
               : "is the gyroscope's scale factor right? Both agree best with its rates multiplied by this factor")};
}

// What certainly turns the images otherwise than the gyroscope is named, and taken away but for a gain (CorrectTurnGain).
RecordingWarning TakeAway(const Cause& cause, const Disagreement& found, Recording* recording,
                          OdometrySettings* settings) {
  constexpr double kDegrees = 180.0 / M_PI;
  const double value = cause.value;
  const double error = std::max(cause.sigma, 0.1 * std::abs(value));  // such are the errors in simulation
  Calibration& c = recording->calibration;
  if (&cause == &found.shutter) {
    const double ms = 1e3 * c.height / c.fy;  // of all rows
    TakeBackShutter(value, recording);
    return {"turns_shutter", ms * value, ms * error,
            Join("the camera sees its rows one after another, the last ", ms * value, " ± ", ms * error,
                 " ms after the first, as a rolling shutter does: the estimators correct for it")};
  }
  if (&cause == &found.drift) {
    const double seconds = Duration(*recording), allowed = c.noise.gyroscope_walk * std::sqrt(seconds);
    c.noise.gyroscope_walk = value * std::sqrt(seconds);
    return {"turns_drift", value * seconds, allowed,
            Join("the gyroscope's bias drifts by ", std::setprecision(3), value * seconds,
                 " rad/s; imu.gyroscope_random_walk lets one expect ", allowed, ": the estimators use what was found")};
  }
  if (&cause == &found.rotation) {
    settings->estimator.estimate_extrinsic = true;
    return {"turns_rotation", kDegrees * value, kDegrees * error,
            Join("the camera is turned by ", kDegrees * value, " ± ", kDegrees * error,
                 "° against camera.q_B_C, or its principal point is off; its place on the body is estimated")};
  }
  return GainWarning(&cause == &found.focal, value, error);
}

void CheckTurnGain(const TurnAgreement& turns, const std::optional<Disagreement>& found, Recording* recording,
                   OdometrySettings* settings, RecordingWarnings* warnings) {
  constexpr double kAlike = 0.8, kOtherUnit = 1.7;  // of correlation, of all turns together
  const double slope = turns.at_delay * std::sqrt(turns.noise);
  if (turns.at_delay > kAlike && std::max(slope, 1.0 / slope) > kOtherUnit) {
    warnings->push_back({"turns_unit", slope, kNoNumber,
                         Join("the images turn ", slope, " times as far as the gyroscope: is it in rad/s?")});
    return;
  }
  if (!found) return;
  const double allowed = recording->calibration.noise.gyroscope_walk / std::sqrt(Duration(*recording));
  if (const Cause* cause = CertainCause(*found, allowed))
    warnings->push_back(TakeAway(*cause, *found, recording, settings));
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

// Several readings of the axes may explain the turns equally well.
RecordingWarning AxesWarning(const TurnAgreement& turns) {
  constexpr double kAgree = 0.6, kAsGood = 0.05;
  const std::pair<double, std::string> others[] = {
      {turns.with_inverse, "with the inverse of camera.q_B_C, which must rotate camera coordinates into the IMU's"},
      {turns.with_axes, "with the gyroscope's columns read as " + NameAxes(turns.axes)},
      {turns.with_tracks, "with the tracks' x, y read as " + turns.tracks}};
  const double best = std::max_element(std::begin(others), std::end(others))->first;
  std::string words;
  for (const auto& [correlation, reading] : others)
    if (correlation > best - kAsGood) words += (words.empty() ? Join("; it is ", best, " ") : ", or ") + reading;
  if (best < std::max(kAgree, turns.as_given))
    words =
        ", whatever the order and the signs of the axes: do the tracks show the scene, in this camera, and are the "
        "clocks of "
        "camera and IMU within 1.2 s?";
  return {"turns", turns.as_given, best,
          Join("the camera's rotation disagrees with the gyroscope (correlation ", turns.as_given, ")", words)};
}

RecordingWarning DelayWarning(const DelayChange& change) {
  if (change.step == 0.0) {
    const double percent = 100.0 * change.rate, sigma = 100.0 * change.sigma;
    return {"clock_rate", percent, sigma,
            Join(std::setprecision(3), "the IMU's clock runs ", std::abs(percent), " ± ", sigma, " % ",
                 percent > 0.0 ? "faster" : "slower", " than the camera's: its stamps are rescaled (corrected)")};
  }
  const double milliseconds = 1e3 * change.step, sigma = 1e3 * change.sigma;
  return {"delay_jump",
          milliseconds,
          sigma,
          Join("at ", change.t, " s the delay between camera and IMU jumps by ", std::lround(milliseconds), " ± ",
               std::lround(sigma), " ms: one of their clocks was set, or stamps were lost (corrected)"),
          "",
          change.t};
}

}  // namespace

void CheckTurns(OdometrySettings* settings, Recording* recording, bool seeks_cause, RecordingWarnings* warnings) {
  constexpr double kGood = 0.8, kGainOfAxes = 2.0;  // of the variance that is left
  auto turns = CompareTurns(*recording);
  if (turns && turns->change) {
    Recording even = *recording;
    EvenOut(*turns->change, &even);
    const auto again = CompareTurns(even);
    constexpr double kNotWorse = 1.005;
    if (again && LeftVariance(again->at_delay) < kNotWorse * LeftVariance(turns->at_delay)) {
      warnings->push_back(DelayWarning(*turns->change));
      *recording = std::move(even);
      turns = again;
    }
  }
  if (!turns) return;
  const auto delay = ClearDelay(*turns);
  const double otherwise = std::max(turns->with_axes, turns->with_inverse);
  const bool is_turned = otherwise > kGood && LeftVariance(turns->at_delay) > kGainOfAxes * LeftVariance(otherwise);
  // A lens spoils the turns of the images too.
  const auto found = is_turned || !seeks_cause ? std::nullopt : FindDisagreement(*recording, delay.value_or(0.0));
  if (found && IsBent(*found)) {
    const Cause& lens = found->lens;
    warnings->push_back({"lens", lens.value, lens.gain,
                         Join("the images agree with one another and the gyroscope ", lens.gain,
                              " times better if their points are moved by 1 + k r², k = ", lens.value,
                              ": does the lens model (radial-tangential, equidistant or none) fit this camera?")});
    return;
  }
  if (is_turned || TurnOtherwise(*turns)) {
    warnings->push_back(AxesWarning(*turns));
    return;
  }
  CheckTurnGain(*turns, found, recording, settings, warnings);
  if (delay && (settings->finds_clock || settings->estimator.estimate_time_offset)) {
    settings->estimator.time_offset = *delay;
  } else if (delay) {
    warnings->push_back(ClockWarning("seems", {*delay, kErrorOfTurns}));
  }
}

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

}  // namespace ch5
