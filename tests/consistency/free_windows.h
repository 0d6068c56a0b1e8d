#pragma once
/// Windows whose gauge nothing fixes.

#include "ch5_backend/consistency/gauge_audit.h"
#include "ch5_backend/marginalize/marginalize.h"
#include "ch5_backend/marginalize/scoped_linearization_point.h"
#include "tests/marginalize/small_graphs.h"

namespace ch5 {

inline GaugeLeak LeakAlong(const std::string& direction, const std::vector<GaugeLeak>& leaks) {
  for (const GaugeLeak& leak : leaks) {
    if (leak.direction == direction) return leak;
  }
  ADD_FAILURE() << "no direction " << direction;
  return {};
}

struct FreeWindow : SmallWindow {
  explicit FreeWindow(int frames = 4) : SmallWindow(1, frames) {
    graph.RemoveEdge(graph.Edges().front());  // the prior on frame 0
    options.local_poses = {extrinsic.get()};
  }
  GaugeOptions options;
};

}  // namespace ch5
