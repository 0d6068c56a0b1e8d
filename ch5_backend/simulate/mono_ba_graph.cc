/// The scene as a graph. Apart from mono_ba.cc, so that a scene can be had without an answer of the homework.

#include "ch5_backend/simulate/mono_ba.h"
#include "ch5_backend/types/edge_se3_prior.h"

namespace ch5 {

MonoBa BuildMonoBa(const MonoBaScene& scene, Gauge gauge, double pixel_information, double prior_weight) {
  MonoBa problem;
  for (const Transform& T_W_C : scene.initial_frames) {
    problem.poses.push_back(std::make_shared<VertexPose>(T_W_C.q, T_W_C.p));
    problem.graph.AddVertex(problem.poses.back());
  }
  for (const double inverse_depth : scene.initial_inverse_depths) {
    problem.landmarks.push_back(std::make_shared<VertexInverseDepth>(inverse_depth));
    problem.graph.AddVertex(problem.landmarks.back());
  }
  if (gauge == Gauge::kFixTwoFrames) {
    problem.poses[0]->SetFixed();
    problem.poses[1]->SetFixed();
  }
  AddMonoBaEdges(scene, pixel_information, gauge == Gauge::kPriorTwoFrames ? prior_weight : 0.0, &problem);
  if (gauge == Gauge::kPriorMinimal && prior_weight > 0.0) AddMinimalGaugePrior(scene, prior_weight, &problem);
  return problem;
}

void AddMinimalGaugePrior(const MonoBaScene& scene, double weight, MonoBa* problem) {
  const auto add = [&](size_t i, const Mat66& information) {
    const Transform& truth = scene.frames[i];
    auto prior = std::make_shared<EdgeSE3Prior>(problem->poses[i], truth.q, truth.p);
    prior->SetInformation(information);
    problem->graph.AddEdge(prior);
  };
  const Vec3 baseline = (scene.frames[1].p - scene.frames[0].p).normalized();
  Mat66 along_baseline = Mat66::Zero();  // rows and columns: rotation, then translation
  along_baseline.bottomRightCorner<3, 3>() = weight * baseline * baseline.transpose();
  add(0, weight * Mat66::Identity());
  add(1, along_baseline);
}

}  // namespace ch5
