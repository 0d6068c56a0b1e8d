#include "ch5_homework/judge/scenes/bundle.h"

namespace ch5::homework {
namespace {

MonoBaOptions Options(int frames, int points, double position_sigma, double rotation_sigma) {
  MonoBaOptions options;
  options.frames = frames;
  options.points = points;
  options.position_sigma = position_sigma;
  options.rotation_sigma = rotation_sigma;
  options.seed = Seed(options.seed);
  return options;
}

[[maybe_unused]] const bool bundles_added =
    Scene::Add("start",
               [](const std::string&, const Scene::Sizes&) { return std::unique_ptr<Scene>(new StartScene); }) &&
    Scene::Add("bundle", [](const std::string&, const Scene::Sizes& sizes) {
      return std::unique_ptr<Scene>(new BundleScene(sizes.at(0), sizes.at(1), sizes.at(2) > 0));
    });

}  // namespace

MonoScene::MonoScene(std::string name, Sizes sizes, const MonoBaOptions& options)
    : Scene(std::move(name), std::move(sizes)), scene(SimulateMonoBa(options)) {
  for (const Transform& T_W_C : scene.initial_frames) {
    ba.poses.push_back(std::make_shared<VertexPose>(T_W_C.q, T_W_C.p));
    ba.graph.AddVertex(ba.poses.back());
  }
  for (const double inverse_depth : scene.initial_inverse_depths) {
    ba.landmarks.push_back(std::make_shared<VertexInverseDepth>(inverse_depth));
    ba.graph.AddVertex(ba.landmarks.back());
  }
}

// Away from the identity, where the course's frame 0 is: there a pose and one relative to frame 0 are the same.
StartScene::StartScene() : MonoScene("start", {}, Options(kFrames, kPoints, 0.1, 0.02)) {
  const Transform away{ExpSO3(Vec3(0.5, -0.4, 0.8)), Vec3(3.0, -2.0, 1.0)};
  const auto move = [&](const Vec3& p) -> Vec3 { return away.p + away.q * p; };
  for (std::vector<Transform>* frames : {&scene.frames, &scene.initial_frames}) {
    for (Transform& T_W_C : *frames) T_W_C = {away.q * T_W_C.q, move(T_W_C.p)};
  }
  for (Vec3& p_W : scene.points) p_W = move(p_W);
  for (size_t i = 0; i < ba.poses.size(); ++i)
    ba.poses[i]->SetPose(scene.initial_frames[i].q, scene.initial_frames[i].p);
}

// Not BuildMonoBa, which calls stage 3's function.
void MonoScene::AddReprojections() {
  for (size_t k = 0; k < ba.landmarks.size(); ++k) {
    for (size_t j = 1; j < ba.poses.size(); ++j) {
      ba.graph.AddEdge(std::make_shared<EdgeReprojection>(ba.landmarks[k], ba.poses[0], ba.poses[j], scene.pixels[0][k],
                                                          scene.pixels[j][k]));
    }
  }
}

BundleScene::BundleScene(int frames, int points, bool fixed)
    : MonoScene("bundle", {frames, points, fixed}, Options(frames, points, 0.0, 0.0)) {
  Random random(Seed(13));
  for (size_t i = 0; i < 2; ++i) ba.poses[i]->SetFixed(fixed);
  AddReprojections();
  for (const auto& edge : ba.graph.Edges()) {
    if (!fixed) edge->SetInformation(RandomPositiveDefinite(2, &random));
  }
}

}  // namespace ch5::homework
