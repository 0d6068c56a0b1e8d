#include "ch5_backend/evaluate/relative_error.h"

#include <algorithm>
#include <cmath>

#include "ch5_backend/evaluate/trajectory_error.h"

namespace ch5 {
namespace {

struct Pair {
  double t;
  Transform estimate, truth;  // T_W_B
  double way;                 // since the first pair: the truth's, the estimate's where the truth has a gap [m]
};

std::vector<Pair> PairsOf(const std::vector<StampedState>& estimate, const std::vector<StampedState>& truth) {
  std::vector<Pair> pairs;
  double unseen = 0.0;  // the estimate's way since the last pair
  for (size_t i = 0; i < estimate.size(); ++i) {
    const bool follows = i > 0 && !pairs.empty() && pairs.back().t == estimate[i - 1].t;
    if (i > 0) unseen += (estimate[i].T_W_B.p - estimate[i - 1].T_W_B.p).norm();
    const std::optional<StampedState> there = StateAt(truth, estimate[i].t);
    if (!there) continue;
    double way = 0.0;
    if (!pairs.empty()) way = pairs.back().way + (follows ? (there->T_W_B.p - pairs.back().truth.p).norm() : unseen);
    pairs.push_back({estimate[i].t, estimate[i].T_W_B, there->T_W_B, way});
    unseen = 0.0;
  }
  return pairs;
}

// The second pose, with position and yaw agreeing in the first.
Transform LaidUpon(const Pair& from, const Pair& to) { return AlignFirstPose(from.estimate, from.truth) * to.estimate; }

double ErrorBetween(const Pair& from, const Pair& to) { return (LaidUpon(from, to).p - to.truth.p).norm(); }

void AppendErrors(const std::vector<Pair>& pairs, LengthErrors* errors) {
  for (size_t i = 0, j = 0; i < pairs.size(); ++i) {
    while (j < pairs.size() && pairs[j].way < pairs[i].way + errors->length) ++j;
    if (j == pairs.size()) break;
    const Transform end = LaidUpon(pairs[i], pairs[j]);
    errors->position.push_back((end.p - pairs[j].truth.p).norm());
    errors->yaw.push_back(std::abs(LogSO3(end.q * pairs[j].truth.q.conjugate()).z()));
  }
}

}  // namespace

std::optional<RelativeError> CompareMotions(const std::vector<StampedState>& estimate,
                                            const std::vector<StampedState>& truth, double seconds) {
  const std::vector<Pair> pairs = PairsOf(estimate, truth);
  double sum = 0.0;
  int count = 0;
  for (size_t i = 0, j = 0; i < pairs.size(); ++i) {
    while (j < pairs.size() && pairs[j].t < pairs[i].t + seconds - 1e-6) ++j;
    if (j == pairs.size() || pairs[j].t > pairs[i].t + 2.0 * seconds) continue;
    const double distance = ErrorBetween(pairs[i], pairs[j]);
    sum += distance * distance;
    ++count;
  }
  if (count == 0) return std::nullopt;
  return RelativeError{std::sqrt(sum / count), pairs.back().way, ErrorBetween(pairs.front(), pairs.back())};
}

std::vector<LengthErrors> ErrorsOverLengths(const std::vector<std::vector<StampedState>>& segments,
                                            const std::vector<StampedState>& truth, const std::vector<double>& shares) {
  std::vector<std::vector<Pair>> compared;
  double path = 0.0;
  for (const auto& segment : segments) {
    compared.push_back(PairsOf(segment, truth));
    if (!compared.back().empty()) path += compared.back().back().way;
  }
  std::vector<LengthErrors> all;
  if (path == 0.0) return all;
  for (const double share : shares) {
    LengthErrors errors{share, share * path, {}, {}};
    for (const auto& pairs : compared) AppendErrors(pairs, &errors);
    std::sort(errors.position.begin(), errors.position.end());
    std::sort(errors.yaw.begin(), errors.yaw.end());
    all.push_back(std::move(errors));
  }
  return all;
}

double QuantileOfSorted(const std::vector<double>& sorted, double q) {
  return sorted.empty() ? std::nan("") : sorted[static_cast<size_t>(q * static_cast<double>(sorted.size() - 1))];
}

}  // namespace ch5
