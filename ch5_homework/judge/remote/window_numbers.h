#pragma once
/// What a student's SlideWindow has made of a window, and a prior, as numbers. Vertices are places in a list that both
/// sides know; of those that are new, only the parameters come.

#include "ch5_homework/judge/remote/travel.h"
#include "ch5_homework/judge/scenes/windows.h"

namespace ch5::homework {

struct SlotNumbers {
  int place = kNull;
  VecX x;
};

struct FrameNumbers {
  int id = 0;
  double t = 0.0;
  SlotNumbers pose, speed_bias;
  bool has_imu = false;
  Vec3 b_a = Vec3::Zero(), b_g = Vec3::Zero();
  std::vector<ImuSample> imu;
};

struct LandmarkNumbers {
  int track = 0;
  SlotNumbers inverse_depth;
  std::vector<WindowObservation> seen;
};

struct WindowNumbers {
  std::vector<FrameNumbers> frames;
  std::vector<LandmarkNumbers> landmarks;
  bool has_prior = false;
};

/// @param known  the window's vertices before the slide
WindowNumbers NumbersOf(const Window& window, const VertexList& known);
/// Frames and landmarks, and whether there is a prior. Of the IMU's intervals, those that the window holds already, or
/// begins with, are kept.
/// @throws WireError if a frame lacks its states, one is not of its type, or a number is not finite
void SetInto(const WindowNumbers& numbers, const VertexList& known, Window* window);

struct PriorNumbers {
  std::vector<int> vertices;
  std::vector<VecX> x0;
  MatXX J;
  VecX r0;
};

PriorNumbers NumbersOf(const Prior& prior, const VertexList& vertices);
/// @param foreign  stands in where the prior has a vertex that is not in the list
/// @throws WireError if it has none at all, or J and r₀ do not fit together
Prior MakePrior(const PriorNumbers& numbers, const VertexList& vertices, const std::shared_ptr<Vertex>& foreign);

inline auto Fields(ImuSample& s, Wire) { return std::tie(s.dt, s.acceleration, s.gyroscope); }
inline auto Fields(WindowObservation& o, Wire) { return std::tie(o.frame, o.x, o.velocity); }
inline auto Fields(SlotNumbers& slot, Wire) { return std::tie(slot.place, slot.x); }
inline auto Fields(FrameNumbers& f, Wire) {
  return std::tie(f.id, f.t, f.pose, f.speed_bias, f.has_imu, f.b_a, f.b_g, f.imu);
}
inline auto Fields(LandmarkNumbers& l, Wire) { return std::tie(l.track, l.inverse_depth, l.seen); }
inline auto Fields(WindowNumbers& w, Wire) { return std::tie(w.frames, w.landmarks, w.has_prior); }
inline auto Fields(PriorNumbers& p, Wire) { return std::tie(p.vertices, p.x0, p.J, p.r0); }

}  // namespace ch5::homework
