#pragma once
/// A window for stage 6 of which everything is known, and its right drop sets, found in another way than the homework's.

#include <algorithm>
#include <cmath>
#include <map>
#include <string>
#include <vector>

#include "ch5_backend/window/landmarks.h"
#include "ch5_homework/judge/diagnosis.h"
#include "ch5_homework/judge/submission.h"

namespace ch5::homework {

constexpr int kFirstId = 20;  // ids are no positions

// A frame 0.3 m further along x, with an IMU piece whose readings are its own.
inline void AddFrame(Window* window) {
  WindowFrame frame;
  frame.id = window->frames.empty() ? kFirstId : window->frames.back().id + 1;
  const int k = frame.id - kFirstId;
  frame.t = 0.2 * k;
  frame.pose = std::make_shared<VertexPose>(ExpSO3(Vec3(0.01 * k, -0.02, 0.015 * k)), Vec3(0.3 * k, 0.05 * k, 0.0));
  Vec9 v_ba_bg;
  v_ba_bg << 1.5, 0.25, 0.01, 0.02, -0.01, 0.03, 0.001, 0.002, -0.001;
  frame.speed_bias = std::make_shared<VertexSpeedBias>(v_ba_bg);
  if (!window->frames.empty()) {
    const ImuNoise noise{0.08, 0.004, 0.02, 0.002, false};
    const auto sample = [&](double dt, int n) {
      return ImuSample{dt, Vec3(0.1 * k, 0.2 * n, 9.8), Vec3(0.05, 0.01 * n, 0.1 * k)};
    };
    frame.imu = std::make_shared<Preintegration>(sample(0.0, 0), Vec3::Zero(), Vec3::Zero(), noise);
    for (int n = 1; n <= 10; ++n) frame.imu->Add(sample(0.02, n));
  }
  window->frames.push_back(std::move(frame));
}

inline Window Frames(int count) {
  Window window;
  for (int k = 0; k < count; ++k) AddFrame(&window);
  window.extrinsic->SetPose(ExpSO3(Vec3(0.02, -0.01, 0.03)), Vec3(0.05, 0.02, 0.01));
  window.extrinsic->SetFixed();
  window.time_offset->SetFixed();
  return window;
}

// Lets the frames first … last see a point, a little wrongly.
inline void See(int track, const Vec3& p_W, int first, int last, Window* window) {
  const Transform T_B_C = window->T_B_C();
  for (int k = first; k <= last; ++k) {
    const WindowFrame& frame = window->frames[static_cast<size_t>(k)];
    const Vec3 p_C = T_B_C.q.conjugate() * (frame.pose->q().conjugate() * (p_W - frame.pose->p()) - T_B_C.p);
    const Vec2 noise = 0.002 * Vec2(std::sin(7.0 * k + track), std::cos(5.0 * k - track));
    window->landmarks[track].seen.push_back({frame.id, p_C.hnormalized() + noise, Vec2::Zero()});
  }
}

inline bool UseAll(const Window&, const WindowLandmark& landmark) { return landmark.seen.size() >= 2; }

inline std::shared_ptr<EdgePrior> PriorOn(const std::vector<std::shared_ptr<Vertex>>& vertices) {
  Prior prior;
  prior.vertices = vertices;
  int size = 0;
  for (const auto& vertex : vertices) {
    prior.x0.push_back(vertex->Parameters());
    size += vertex->LocalDimension();
  }
  prior.J = 10.0 * MatXX::Identity(size, size);
  prior.r0 = VecX::Constant(size, 0.01);
  return std::make_shared<EdgePrior>(std::move(prior));
}

constexpr int kHostedByOldest = 1, kHostedByNext = 2, kWithoutDepth = 3, kSeenTwice = 4, kHostedBySecondNew = 5,
              kHostedEarlier = 6;

// Eleven frames, of which the prior knows the first two and the second newest; landmarks of each kind.
inline Window FullWindow() {
  Window window = Frames(11);
  See(kHostedByOldest, Vec3(1, 1, 6), 0, 5, &window);
  See(kHostedByNext, Vec3(1, -1, 7), 1, 6, &window);
  See(kSeenTwice, Vec3(0, 1, 5), 0, 1, &window);
  See(kHostedEarlier, Vec3(2, 1, 8), 4, 10, &window);
  TriangulateLandmarks(&window);
  See(kWithoutDepth, Vec3(0, 0.5, 6), 0, 3, &window);  // its tracks have come, its depth has not
  See(kHostedBySecondNew, Vec3(3, 0.5, 6), 9, 10, &window);
  const auto& frames = window.frames;
  window.prior = PriorOn({frames[0].pose, frames[0].speed_bias, frames[1].pose, frames[9].pose});
  BuildGraph({}, UseAll, &window);
  return window;
}

inline bool Holds(const std::vector<std::shared_ptr<Vertex>>& vertices, const std::shared_ptr<Vertex>& vertex) {
  return std::find(vertices.begin(), vertices.end(), vertex) != vertices.end();
}

/// How many edges of each type, and how many vertices of each.
inline Text Inventory(const DropSet& drop) {
  std::map<std::string, int> edges, vertices;
  for (const auto& edge : drop.edges) ++edges[edge ? edge->TypeInfo() : "null"];
  for (const auto& vertex : drop.vertices) ++vertices[vertex ? vertex->TypeInfo() : "null"];
  const auto list = [](const std::map<std::string, int>& counts, const char* none) {
    std::string text;
    for (const auto& [type, count] : counts) text += (text.empty() ? "" : ", ") + std::to_string(count) + " " + type;
    return counts.empty() ? Text(none) : Word(text);
  };
  return {"6.inventory", {{"vertices", list(vertices, "6.no_vertex")}, {"edges", list(edges, "6.no_edge")}}};
}

inline int Count(const DropSet& drop, const std::string& type) {
  return static_cast<int>(std::count_if(drop.edges.begin(), drop.edges.end(),
                                        [&](const auto& edge) { return edge && edge->TypeInfo() == type; }));
}

/// The same edges, and the same vertices among theirs; vertices without any of these edges count for nothing.
inline bool Same(const DropSet& a, const DropSet& b) {
  const auto edges = [](const DropSet& drop) {
    std::vector<int> ids;
    for (const auto& edge : drop.edges) ids.push_back(edge ? edge->Id() : -1);
    std::sort(ids.begin(), ids.end());
    return ids;
  };
  const auto vertices = [](const DropSet& drop) {
    std::vector<int> ids;
    for (const auto& vertex : drop.vertices) {
      const bool used = !vertex || std::any_of(drop.edges.begin(), drop.edges.end(), [&](const auto& edge) {
        return edge && Holds(edge->Vertices(), vertex);
      });
      if (used) ids.push_back(vertex ? vertex->Id() : -1);
    }
    std::sort(ids.begin(), ids.end());
    return ids;
  };
  return edges(a) == edges(b) && vertices(a) == vertices(b);
}

inline DropSet RightMarginOld(const Window& window) {
  DropSet drop;
  drop.vertices = {window.frames[0].pose, window.frames[0].speed_bias};
  for (const auto& edge : window.graph.Edges()) {
    const auto& held = edge->Vertices();
    if (Holds(held, window.frames[0].pose) || Holds(held, window.frames[0].speed_bias)) drop.edges.push_back(edge);
    if (edge->TypeInfo() == "EdgeReprojection" && held[1] == window.frames[0].pose && !Holds(drop.vertices, held[0])) {
      drop.vertices.push_back(held[0]);
    }
  }
  return drop;
}

}  // namespace ch5::homework
