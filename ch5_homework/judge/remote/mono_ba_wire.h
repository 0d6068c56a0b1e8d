#pragma once
/// The scene of stage 3 on the wire.

#include "ch5_backend/simulate/mono_ba.h"
#include "ch5_homework/judge/remote/graph_wire.h"

namespace ch5::homework {

inline Writer& operator<<(Writer& out, const Transform& T) { return out << T.q << T.p; }
inline Reader& operator>>(Reader& in, Transform& T) { return in >> T.q >> T.p; }

inline Writer& operator<<(Writer& out, const MonoBaScene& scene) {
  return out << scene.frames << scene.points << scene.pixels << scene.initial_frames << scene.initial_inverse_depths;
}
inline Reader& operator>>(Reader& in, MonoBaScene& scene) {
  return in >> scene.frames >> scene.points >> scene.pixels >> scene.initial_frames >> scene.initial_inverse_depths;
}

/// The poses, then the landmarks.
inline VertexList VerticesOf(const MonoBa& problem) {
  VertexList vertices(problem.poses.begin(), problem.poses.end());
  vertices.insert(vertices.end(), problem.landmarks.begin(), problem.landmarks.end());
  return vertices;
}

}  // namespace ch5::homework
