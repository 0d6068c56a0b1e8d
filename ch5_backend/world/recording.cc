#include "ch5_backend/world/recording.h"

#include <algorithm>

namespace ch5 {
namespace {

// The first entry at or after `t`.
template <typename Entry>
auto Find(const std::vector<Entry>& entries, double t) {
  return std::lower_bound(entries.begin(), entries.end(), t, [](const Entry& entry, double s) { return entry.t < s; });
}

// The linear blend of an entry and the one before it, for a time t between them.
struct Blend {
  double weight;  // of the later one
  template <typename T>
  T operator()(const T& before, const T& after) const {
    return before + weight * (after - before);
  }
};

template <typename Entry>
Blend BlendAt(double t, const Entry& before, const Entry& after) {
  return {(t - before.t) / (after.t - before.t)};
}

}  // namespace

std::vector<ImuSample> SamplesBetween(const std::vector<ImuReading>& imu, double t0, double t1) {
  if (!(t0 < t1) || imu.empty() || t0 < imu.front().t || t1 > imu.back().t) return {};
  std::vector<ImuSample> samples;
  double last = t0;
  const auto add = [&](double t, const Vec3& acceleration, const Vec3& gyroscope) {
    samples.push_back({t - last, acceleration, gyroscope});
    last = t;
  };
  const auto add_interpolated = [&](double t, auto after) {
    if (after->t == t) return add(t, after->acceleration, after->gyroscope);
    const auto before = std::prev(after);
    const Blend blend = BlendAt(t, *before, *after);
    add(t, blend(before->acceleration, after->acceleration), blend(before->gyroscope, after->gyroscope));
  };
  auto next = Find(imu, t0);
  add_interpolated(t0, next);
  if (next->t == t0) ++next;
  for (; next->t < t1; ++next) add(next->t, next->acceleration, next->gyroscope);
  add_interpolated(t1, next);
  return samples;
}

std::optional<StampedState> StateAt(const std::vector<StampedState>& states, double t) {
  const auto after = Find(states, t);
  if (after == states.end()) return std::nullopt;
  if (after->t == t) return *after;
  if (after == states.begin()) return std::nullopt;
  const auto before = std::prev(after);
  const Blend blend = BlendAt(t, *before, *after);
  StampedState state;
  state.t = t;
  state.T_W_B = {before->T_W_B.q.slerp(blend.weight, after->T_W_B.q), blend(before->T_W_B.p, after->T_W_B.p)};
  state.v_W = blend(before->v_W, after->v_W);
  state.b_a = blend(before->b_a, after->b_a);
  state.b_g = blend(before->b_g, after->b_g);
  return state;
}

}  // namespace ch5
