#include "ch5_backend/evaluate/relative_error.h"

#include "ch5_backend/evaluate/trajectory_error.h"

namespace ch5 {
namespace {

struct Pair {
  double t;
  Transform estimate, truth;  // T_W_B
};

// How far two poses are apart when position and yaw agree in two others.
double ErrorBetween(const Pair& from, const Pair& to) {
  return (AlignFirstPose(from.estimate, from.truth) * to.estimate.p - to.truth.p).norm();
}

}  // namespace

std::optional<RelativeError> CompareMotions(const std::vector<StampedState>& estimate,
                                            const std::vector<StampedState>& truth, double seconds) {
  std::vector<Pair> pairs;
  for (const StampedState& state : estimate) {
    if (const auto there = StateAt(truth, state.t)) pairs.push_back({state.t, state.T_W_B, there->T_W_B});
  }
  RelativeError error;
  double sum = 0.0;
  int count = 0;
  for (size_t i = 0, j = 0; i < pairs.size(); ++i) {
    if (i > 0) error.path += (pairs[i].truth.p - pairs[i - 1].truth.p).norm();
    while (j < pairs.size() && pairs[j].t < pairs[i].t + seconds - 1e-6) ++j;
    if (j == pairs.size()) continue;
    const double distance = ErrorBetween(pairs[i], pairs[j]);
    sum += distance * distance;
    ++count;
  }
  if (count == 0) return std::nullopt;
  error.position_rmse = std::sqrt(sum / count);
  error.end = ErrorBetween(pairs.front(), pairs.back());
  return error;
}

}  // namespace ch5
