#pragma once
/// A window dump as a graph: poses, speeds and biases, landmarks, and their edges.

#include <memory>
#include <vector>

#include "ch5_backend/files/window_dump.h"
#include "ch5_backend/graph/graph.h"
#include "ch5_backend/types/vertices.h"
#include "ch5_backend/window/vins_window.h"

namespace ch5 {

struct WindowGraph {
  Graph graph;
  std::vector<std::shared_ptr<VertexPose>> poses;              ///< T_W_B, one per frame
  std::vector<std::shared_ptr<VertexSpeedBias>> speed_biases;  ///< one per frame; empty without an IMU
  std::vector<std::shared_ptr<VertexInverseDepth>> landmarks;  ///< in the order of the dump
  std::shared_ptr<VertexPose> extrinsic;                       ///< T_B_C
};

/// The dump's problem at its initial estimates, with its IMU intervals integrated, its losses and its prior.
/// @throws std::invalid_argument if an IMU interval has no samples, or the prior holds speeds and biases of a window
///         without an IMU
WindowGraph BuildWindowGraph(const WindowDump& dump);

/// What leaves with the oldest frame: its pose, its speed and biases, the landmarks that it hosts, and all edges at these.
DropSet OldestFrameOf(const WindowDump& dump, const WindowGraph& window);

}  // namespace ch5
