#include "ch5_backend/experiments/studies/clock_check.h"

#include <algorithm>
#include <array>

#include "ch5_backend/math/median.h"
#include "ch5_backend/math/parallel.h"

namespace ch5 {
namespace {

constexpr double kSeconds = 40.0;   // of the recording: twice as much says little more and takes twice as long
constexpr double kFinest = 0.3e-3;  // [s]: what estimates that agree by chance still leave open
// Noise of the pixels is noise of their velocities too, and holds an estimate at its guess g: td̂ = g + a (td − g), with a = 1
// where points move fast. Two guesses tell a, and so td.
constexpr double kApart = 5e-3;      // of the guesses [s]
constexpr double kLeastHeard = 0.3;  // of a, to divide by

// What a policy estimates after a half, three quarters and all of the images; empty if it restarts or hardly starts.
std::vector<double> Estimates(const Recording& recording, const EstimatorOptions& options,
                              std::unique_ptr<WindowPolicy> policy) {
  constexpr size_t kFewest = 40;
  std::vector<double> offsets;
  const OdometryRun run =
      RunOdometry(recording, options, std::move(policy), [&](const Estimator& now, const ImageResult& row) {
        if (row.report.state) offsets.push_back(now.TimeOffset());
      });
  const size_t n = offsets.size();
  if (run.restarts > 0 || n < kFewest) return {};
  return {offsets[n / 2], offsets[3 * n / 4], offsets[n - 1]};
}

// Moves back what follows the longest gap near t, if that is half a jump or more. A gap of about a jump tells it exactly.
template <typename Stamped>
bool CloseGap(double t, double jump, std::vector<Stamped>* sequence) {
  constexpr double kNear = 1.0, kAlike = 1.2;  // [s]; times the jump
  std::vector<double> steps;
  for (size_t k = 1; k < sequence->size(); ++k) steps.push_back((*sequence)[k].t - (*sequence)[k - 1].t);
  const double usual = Median(steps);
  double gap = 0.5 * jump;
  size_t after = sequence->size();
  for (size_t k = 1; k < sequence->size(); ++k)
    if (std::abs((*sequence)[k].t - t) < kNear + jump && steps[k - 1] - usual > gap)
      gap = steps[k - 1] - usual, after = k;
  if (after == sequence->size()) return false;
  const double back = gap < kAlike * jump ? gap : jump;
  for (; after < sequence->size(); ++after) (*sequence)[after].t -= back;
  return true;
}

template <typename Stamped>
void MoveAhead(double from, double by, std::vector<Stamped>* sequence) {
  for (Stamped& m : *sequence)
    if (m.t >= from) m.t += by;
}

}  // namespace

void EvenOut(const DelayChange& change, Recording* recording) {
  const double jump = std::abs(change.step);
  const double begin = recording->imu.front().t;
  for (ImuMeasurement& m : recording->imu) m.t = begin + (m.t - begin) / (1.0 + change.rate);
  if (change.step > 0.0 && !CloseGap(change.t, jump, &recording->imu)) {
    MoveAhead(change.t, jump, &recording->images);
  } else if (change.step < 0.0 && !CloseGap(change.t, jump, &recording->images)) {
    MoveAhead(change.t + change.delay, jump, &recording->imu);
  }
}

std::optional<ClockOffset> EstimateClockOffset(const Recording& recording, EstimatorOptions options, double guess) {
  options.calibration = recording.calibration;
  options.estimate_time_offset = true;
  Recording part = recording;
  const double end = part.images.front().t + kSeconds;
  part.images.erase(
      std::find_if(part.images.begin(), part.images.end(), [&](const Image& image) { return image.t > end; }),
      part.images.end());
  std::array<std::vector<double>, 4> runs;  // of each policy from both guesses
  ThreadPool(2).Run(static_cast<int>(runs.size()), [&](int task) {
    const auto run = static_cast<size_t>(task);
    EstimatorOptions from = options;
    from.time_offset = guess + (run % 2 == 0 ? 0.0 : kApart);
    runs[run] = Estimates(part, from, std::move(AllPolicies()[run / 2]));
  });
  std::vector<double> all;
  for (size_t run = 0; run < runs.size(); run += 2) {
    const std::vector<double>&first = runs[run], &second = runs[run + 1];
    if (first.empty() || second.empty()) return std::nullopt;
    for (size_t k = 0; k < first.size(); ++k) {
      const double heard = 1.0 - (second[k] - first[k]) / kApart;
      if (heard < kLeastHeard) return std::nullopt;
      all.push_back(guess + (first[k] - guess) / heard);
    }
  }
  const auto offsets = Eigen::Map<const VecX>(all.data(), static_cast<Eigen::Index>(all.size()));
  const double spread =
      std::sqrt((offsets.array() - offsets.mean()).square().sum() / static_cast<double>(all.size() - 1));
  return ClockOffset{offsets.mean(), std::max(spread, kFinest)};
}

}  // namespace ch5
