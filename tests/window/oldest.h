#pragma once
/// VINS' MARGIN_OLD of a window dump, for tests and benchmarks.

#include <algorithm>

#include "ch5_backend/experiments/studies/window_graph.h"
#include "ch5_backend/marginalize/marginalization_info.h"

namespace ch5 {

/// Frame 0, its speed and biases, the landmarks it hosts, and every edge at them.
struct Oldest {
  std::vector<std::shared_ptr<Vertex>> drop;
  std::vector<std::shared_ptr<Edge>> edges;
  std::vector<ResidualBlockInfo> blocks;  ///< the edges again, with the positions of what is dropped

  Oldest(const WindowDump& dump, const WindowGraph& window) {
    drop = {window.poses[0], window.speed_biases[0]};
    for (size_t l = 0; l < dump.landmarks.size(); ++l) {
      if (dump.landmarks[l].host == 0) drop.push_back(window.landmarks[l]);
    }
    for (const auto& edge : window.graph.Edges()) {
      ResidualBlockInfo block{edge, {}};
      for (size_t i = 0; i < edge->Vertices().size(); ++i) {
        if (std::find(drop.begin(), drop.end(), edge->Vertices()[i]) == drop.end()) continue;
        block.drop_set.push_back(static_cast<int>(i));
      }
      if (block.drop_set.empty()) continue;
      edges.push_back(edge);
      blocks.push_back(block);
    }
  }

  /// In the plain way of MarginalizationInfo.
  Prior MarginalizeLikeVins() const {
    MarginalizationInfo info;
    for (const auto& block : blocks) info.AddResidualBlockInfo(block);
    info.PreMarginalize();
    info.Marginalize();
    return info.GetParameterBlocks();
  }
};

}  // namespace ch5
