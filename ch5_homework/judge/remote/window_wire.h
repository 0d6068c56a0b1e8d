#pragma once
/// A sliding window on the wire. Its vertices and edges are known by their places in two lists, the graph's edges as
/// WireEdges; frames, landmarks and the prior are as they are in Window.

#include <vector>

#include "ch5_backend/window/vins_window.h"
#include "ch5_homework/judge/remote/graph_wire.h"

namespace ch5::homework {

struct ImuNumbers {
  bool there = false;
  Vec3 b_a = Vec3::Zero(), b_g = Vec3::Zero();
  std::vector<ImuSample> samples;
};

struct FrameNumbers {
  int id = 0;
  double t = 0.0;
  int pose = kNull, speed_bias = kNull;
  ImuNumbers imu;
};

struct LandmarkNumbers {
  int track = 0;
  int inverse_depth = kNull;
  std::vector<WindowObservation> seen;
};

struct PriorNumbers {
  std::vector<int> vertices;
  std::vector<VecX> x0;
  MatXX J;
  VecX r0;
};

struct WindowNumbers {
  GraphNumbers graph;
  int extrinsic = kNull, time_offset = kNull;
  std::vector<FrameNumbers> frames;
  std::vector<LandmarkNumbers> landmarks;
  bool has_prior = false;
  PriorNumbers prior;
  int prior_edge = kNull;  ///< its place among the graph's edges
};

Writer& operator<<(Writer& out, const PriorNumbers& prior);
Reader& operator>>(Reader& in, PriorNumbers& prior);
Writer& operator<<(Writer& out, const WindowNumbers& window);
Reader& operator>>(Reader& in, WindowNumbers& window);

PriorNumbers NumbersOf(const Prior& prior, const VertexList& vertices);
/// @param foreign  stands in where the prior has a vertex that is not in the list
/// @throws WireError if it has none at all, or J and r₀ do not fit together
Prior MakePrior(const PriorNumbers& numbers, const VertexList& vertices, const std::shared_ptr<Vertex>& foreign);

/// All vertices of a window, those of its frames first; `known` stand before them.
VertexList VerticesOf(const Window& window, VertexList known = {});
/// Frames and landmarks alone, with the places in this list.
WindowNumbers StatesOf(const Window& window, const VertexList& vertices);
/// The graph and the prior too.
WindowNumbers NumbersOf(const Window& window);

/// Frames and landmarks. Of the IMU's pieces, those that the window holds already, or begins with, are kept.
/// @throws WireError if a frame lacks its states, or one is not of its type
void SetStates(const WindowNumbers& numbers, const VertexList& vertices, Window* window);

/// A window that came over the wire.
struct WireWindow {
  Window window;
  VertexList vertices;
  EdgeList edges;
  explicit WireWindow(const WindowNumbers& numbers);
};

}  // namespace ch5::homework
