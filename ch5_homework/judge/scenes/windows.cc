#include "ch5_homework/judge/scenes/windows.h"

#include <algorithm>
#include <cmath>

#include "ch5_backend/window/landmarks.h"

namespace ch5::homework {
namespace {

// A frame 0.3 m further along x, with an IMU interval whose measurements are its own.
void AddFrame(Window* window) {
  Frame frame;
  frame.id = window->frames.empty() ? kFirstId : window->frames.back().id + 1;
  const int k = frame.id - kFirstId;
  frame.t = 0.2 * k;
  frame.is_keyframe = k % 2 == 0;
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

void AddFrames(int count, Window* window) {
  for (int k = 0; k < count; ++k) AddFrame(window);
  window->extrinsic->SetPose(ExpSO3(Vec3(0.02, -0.01, 0.03)), Vec3(0.05, 0.02, 0.01));
  window->time_offset->SetFixed();
}

// Lets the frames first … last see a point, a little wrongly.
void See(int track, const Vec3& p_W, int first, int last, Window* window) {
  const Transform T_B_C = window->T_B_C();
  for (int k = first; k <= last; ++k) {
    const Frame& frame = window->frames.at(static_cast<size_t>(k));
    const Vec3 p_C = T_B_C.q.conjugate() * (frame.pose->q().conjugate() * (p_W - frame.pose->p()) - T_B_C.p);
    const Vec2 noise = 0.002 * Vec2(std::sin(7.0 * k + track), std::cos(5.0 * k - track));
    window->landmarks[track].seen.push_back({frame.id, p_C.hnormalized() + noise, Vec2::Zero()});
  }
}

bool UseAll(const Window&, const WindowLandmark& landmark) { return landmark.seen.size() >= 2; }

std::shared_ptr<EdgePrior> PriorOn(const VertexList& vertices) {
  Prior prior;
  prior.vertices = vertices;
  for (const auto& vertex : vertices) prior.x0.push_back(vertex->Parameters());
  const int size = RowsOf(vertices);
  prior.J = 10.0 * MatXX::Identity(size, size);
  prior.r0 = VecX::Constant(size, 0.01);
  return std::make_shared<EdgePrior>(std::move(prior));
}

/// @param last  of the frames that see what the oldest one hosts
void Fill(int last, Window* window) {
  AddFrames(11, window);
  See(kHostedByOldest, Vec3(1, 1, 6), 0, last, window);
  See(kHostedByNext, Vec3(1, -1, 7), 1, 6, window);
  See(kSeenTwice, Vec3(0, 1, 5), 0, 1, window);
  See(kHostedEarlier, Vec3(2, 1, 8), 4, 10, window);
  TriangulateLandmarks(window);
  See(kWithoutDepth, Vec3(0, 0.5, 6), 0, 3, window);  // its tracks have come, its depth has not
  See(kHostedBySecondNew, Vec3(3, 0.5, 6), 9, 10, window);
}

void BuildFull(Window* window) {
  Fill(5, window);
  const auto& frames = window->frames;
  window->prior = PriorOn({frames[0].pose, frames[0].speed_bias, frames[1].pose, frames[9].pose, window->extrinsic});
  BuildGraph({}, UseAll, window);
}

// Whether a frame is a keyframe, how long a landmark is seen and where it is now say nothing of who leaves.
void BuildWithoutPrior(Window* window) {
  Fill(10, window);
  for (Frame& frame : window->frames) frame.is_keyframe = !frame.is_keyframe;
  window->landmarks[kSeenTwice].inverse_depth = std::make_shared<VertexInverseDepth>(-2.0);
  window->extrinsic->SetFixed();
  BuildGraph({}, UseAll, window);
}

void BuildOtherPrior(Window* window) {
  Fill(5, window);
  window->prior = PriorOn({window->frames[1].pose, window->frames[8].pose});
  BuildGraph({}, UseAll, window);
}

void BuildLong(Window* window) {
  AddFrames(12, window);
  window->prior = PriorOn({window->frames[9].pose, window->frames[10].pose});
  BuildGraph({}, UseAll, window);
}

// On its depth a solve has failed: it lies behind its host, and behind the next.
void BuildBehind(Window* window) {
  AddFrames(11, window);
  See(kHostedByOldest, Vec3(1, 1, 6), 0, 5, window);
  window->landmarks[kHostedByOldest].inverse_depth = std::make_shared<VertexInverseDepth>(-0.25);
}

void BuildFrames(Window* window) { AddFrames(11, window); }

void BuildSliding(Window* window) {
  AddFrames(6, window);
  See(1, Vec3(1, 1, 6), 0, 4, window);
  See(2, Vec3(0, -1, 7), 1, 5, window);
  window->prior = PriorOn({window->frames[0].pose, window->frames[0].speed_bias});
}

const std::map<std::string, void (*)(Window*)>& Builds() {
  static const std::map<std::string, void (*)(Window*)> builds{{"full window", &BuildFull},
                                                               {"full window without prior", &BuildWithoutPrior},
                                                               {"full window, other prior", &BuildOtherPrior},
                                                               {"long window", &BuildLong},
                                                               {"landmark behind", &BuildBehind},
                                                               {"frames", &BuildFrames},
                                                               {"sliding window", &BuildSliding}};
  return builds;
}

[[maybe_unused]] const bool windows_added = [] {
  for (const auto& build : Builds()) {
    Scene::Add(build.first, [](const std::string& name, const Scene::Sizes&) {
      return std::unique_ptr<Scene>(new WindowScene(name));
    });
  }
  return true;
}();

}  // namespace

WindowScene::WindowScene(const std::string& name) : Scene(name, {}), random_(Seed(68)) { Builds().at(name)(&window); }

void WindowScene::Step() {
  if (++steps_ > 1) AddFrame(&window);
  const double x = random_.Uniform(0, 3), y = random_.Uniform(-1, 1);
  See(10 + steps_, Vec3(x, y, 6.0), 1, 5, &window);
  TriangulateLandmarks(&window);
  BuildGraph({}, UseAll, &window);
}

VertexList VerticesOf(const Window& window) {
  VertexList vertices;
  const auto add = [&](const std::shared_ptr<Vertex>& vertex) {
    if (vertex && std::find(vertices.begin(), vertices.end(), vertex) == vertices.end()) vertices.push_back(vertex);
  };
  for (const Frame& frame : window.frames) {
    add(frame.pose);
    add(frame.speed_bias);
  }
  for (const auto& [track, landmark] : window.landmarks) add(landmark.inverse_depth);
  add(window.extrinsic);
  add(window.time_offset);
  return vertices;
}

}  // namespace ch5::homework
