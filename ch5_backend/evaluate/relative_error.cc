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
  RelativeError error;
  double unseen = 0.0;  // the estimate's way since the last pair
  for (size_t i = 0; i < estimate.size(); ++i) {
    const bool follows = i > 0 && !pairs.empty() && pairs.back().t == estimate[i - 1].t;
    if (i > 0) unseen += (estimate[i].T_W_B.p - estimate[i - 1].T_W_B.p).norm();
    const std::optional<StampedState> there = StateAt(truth, estimate[i].t);
    if (!there) continue;
    if (!pairs.empty()) error.path += follows ? (there->T_W_B.p - pairs.back().truth.p).norm() : unseen;
    pairs.push_back({estimate[i].t, estimate[i].T_W_B, there->T_W_B});
    unseen = 0.0;
  }
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
  error.position_rmse = std::sqrt(sum / count);
  error.end = ErrorBetween(pairs.front(), pairs.back());
  return error;
}

}  // namespace ch5
