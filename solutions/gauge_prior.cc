// Homework of chapter 5, stage 3.  Handout: ch5_homework/handout/stage_3.md, .zh.md.
#include "ch5_backend/homework_missing.h"
#include "ch5_backend/simulate/mono_ba.h"
#include "ch5_backend/types/edge_se3_prior.h"

namespace ch5 {

void AddMonoBaEdges(const MonoBaScene& scene, double pixel_information, double prior_weight, MonoBa* problem) {
  // The gauge: a prior keeps the first two frames at their true poses, scene.frames[0] and scene.frames[1].
  if (prior_weight > 0.0) {
    // TODO:: home work 3. One EdgeSE3Prior with information prior_weight·I₆ on each of the first two frames.
    // BEGIN SOLUTION 3 AddMonoBaEdges, the priors
    for (size_t i = 0; i < 2; ++i) {
      auto edge = std::make_shared<EdgeSE3Prior>(problem->poses[i], scene.frames[i].q, scene.frames[i].p);
      edge->SetInformation(prior_weight * Mat66::Identity());
      problem->graph.AddEdge(edge);
    }
    // BLANK
    // for (size_t i = 0; i < ?; ++i) {
    //   auto edge = std::make_shared<EdgeSE3Prior>(?, ?, ?);
    //   edge->SetInformation(?);
    //   problem->graph.AddEdge(edge);
    // }
    // END SOLUTION
  }

  // The measurements: frame 0 hosts every landmark, the other frames see it.
  for (size_t k = 0; k < problem->landmarks.size(); ++k) {
    for (size_t j = 1; j < problem->poses.size(); ++j) {
      auto edge = std::make_shared<EdgeReprojection>(problem->landmarks[k], problem->poses[0], problem->poses[j],
                                                     scene.pixels[0][k], scene.pixels[j][k]);
      edge->SetInformation(pixel_information * Mat22::Identity());
      problem->graph.AddEdge(edge);
    }
  }
}

}  // namespace ch5
