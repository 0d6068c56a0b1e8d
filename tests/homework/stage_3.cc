/// Stage 3: exactly one prior on each of the first two frames, and the gauge obeys it.

#include <gtest/gtest.h>

#include <map>

#include "ch5_backend/types/edge_se3_prior.h"
#include "tests/homework/narrate.h"
#include "tests/homework/seed.h"
#include "tests/homework/submission.h"

namespace ch5::homework {
namespace {

constexpr int kFrames = 4, kPoints = 6;

MonoBaScene PerturbedScene() {
  MonoBaOptions options;
  options.seed = Seed(options.seed);
  options.frames = kFrames;
  options.points = kPoints;
  options.position_sigma = 0.1;  // so that the start is not the truth
  options.rotation_sigma = 0.02;
  return SimulateMonoBa(options);
}

/// The scene's vertices at their start, the edges by the submission.
struct Built {
  MonoBa ba;

  Built(const MonoBaScene& scene, double pixel_information, double prior_weight) {
    for (const Transform& T_W_C : scene.initial_frames) {
      ba.poses.push_back(std::make_shared<VertexPose>(T_W_C.q, T_W_C.p));
      ba.graph.AddVertex(ba.poses.back());
    }
    for (const double inverse_depth : scene.initial_inverse_depths) {
      ba.landmarks.push_back(std::make_shared<VertexInverseDepth>(inverse_depth));
      ba.graph.AddVertex(ba.landmarks.back());
    }
    Chosen().add_mono_ba_edges(scene, pixel_information, prior_weight, &ba);
  }

  /// The priors on each frame.
  std::vector<std::vector<std::shared_ptr<Edge>>> Priors() const {
    std::vector<std::vector<std::shared_ptr<Edge>>> priors(ba.poses.size());
    for (const auto& edge : ba.graph.Edges()) {
      if (edge->TypeInfo() != "EdgeSE3Prior") continue;
      for (size_t i = 0; i < ba.poses.size(); ++i) {
        if (edge->Vertices()[0] == ba.poses[i]) priors[i].push_back(edge);
      }
    }
    return priors;
  }
};

std::string Join(const std::vector<int>& numbers) {
  std::string text;
  for (const int number : numbers) text += (text.empty() ? "" : ", ") + std::to_string(number);
  return text;
}

// The counts of priors per frame that typical mistakes give.
std::string CauseOfCounts(const std::vector<int>& counts) {
  const auto both = [&](int count) { return counts[0] == count && counts[1] == count; };
  static const std::map<std::vector<int>, std::string> causes{
      {{0, 0, 0, 0}, "no prior has reached the graph: each edge needs problem->graph.AddEdge(edge)"},
      {{1, 0, 0, 0}, "only frame 0 has a prior: the scale is still free, 6 constraints for 7 freedoms"},
      {{0, 1, 0, 0}, "only frame 1 has a prior"},
      {{2, 0, 0, 0}, "both priors are on frame 0: the vertex must be problem->poses[i]"},
      {{0, 2, 0, 0}, "both priors are on frame 1: the vertex must be problem->poses[i]"},
      {{0, 1, 1, 0}, "the count begins at 0: the priors are on frames 1 and 2"},
      {{1, 1, 1, 0}, "one frame too many: the loop runs over i = 0, 1, so i < 2"},
      {{1, 1, 1, 1}, "every frame has a prior; only the first two hold the gauge"},
      {{2, 2, 0, 0}, "each prior is added twice: the gauge then feels twice the weight"},
  };
  if (const auto it = causes.find(counts); it != causes.end()) return it->second;
  if (both(kPoints) || both(kPoints * (kFrames - 1))) {
    return "the priors are added inside the landmark loop: their effective weight is the weight × the number of times";
  }
  return "the priors' loop does not run over frames 0 and 1 once each";
}

TEST(Stage3, OnePriorOnEachOfTheFirstTwoFrames) {
  const Built built(PerturbedScene(), 1.0, 100.0);
  std::vector<int> counts;
  for (const auto& priors : built.Priors()) counts.push_back(static_cast<int>(priors.size()));
  const std::vector<int> right{1, 1, 0, 0};
  if (counts != right) {
    FAIL() << Story("3", "the number of EdgeSE3Prior on each of 4 frames, weight 100", Join(right), Join(counts),
                    CauseOfCounts(counts), "3");
  }
}

// What a prior's information is instead of w·I, in words.
std::string CauseOfInformation(const MatXX& W, double weight, double pixel_information) {
  const auto is = [&](double factor) { return Equal(W, factor * MatXX::Identity(6, 6), 1e-9); };
  if (is(1.0)) return "the information is the identity: SetInformation is missing, or without prior_weight";
  if (is(weight * weight)) return "the weight is squared; the information is prior_weight itself";
  if (is(std::sqrt(weight))) return "the root of the weight; the information is prior_weight itself";
  if (is(1.0 / weight)) return "the inverse of the weight: that would be a covariance";
  if (is(pixel_information)) return "this is the pixels' information; the prior's is prior_weight";
  if (is(0.5 * weight)) return "half the weight: the ½ is in the cost already";
  return "the information of a prior is prior_weight times the 6×6 identity";
}

TEST(Stage3, InformationIsTheWeight) {
  const double weight = 100.0, pixel_information = 7.0;
  const Built built(PerturbedScene(), pixel_information, weight);
  for (const auto& priors : built.Priors()) {
    for (const auto& prior : priors) {
      const MatXX W = prior->Information();
      if (Equal(W, weight * MatXX::Identity(6, 6), 1e-12)) continue;
      FAIL() << Story("3", "the information of the prior on frame " + std::to_string(prior->Vertices()[0]->Id()),
                      "100·I₆, so W(0, 0) = 100", "W(0, 0) = " + std::to_string(W(0, 0)),
                      CauseOfInformation(W, weight, pixel_information), "3");
    }
  }
}

// The prior's residual where its pose is set to `T_W_C`: zero if that is the pose that the prior asks for.
double ResidualAt(const Transform& T_W_C, VertexPose* pose, Edge* prior) {
  pose->SetPose(T_W_C.q, T_W_C.p);
  prior->ComputeResidual();
  return prior->Residual().norm();
}

TEST(Stage3, PriorAsksForTheTruePose) {
  const MonoBaScene scene = PerturbedScene();
  const Built built(scene, 1.0, 100.0);
  const auto all_priors = built.Priors();
  for (size_t i = 0; i < 2; ++i) {
    ASSERT_EQ(all_priors[i].size(), 1u);
    VertexPose* pose = built.ba.poses[i].get();
    Edge* prior = all_priors[i][0].get();
    const double residual = ResidualAt(scene.frames[i], pose, prior);
    if (residual < 1e-9) continue;
    std::string cause = "the prior's rotation and position are those of scene.frames[i]";
    if (ResidualAt(scene.initial_frames[i], pose, prior) < 1e-9) {
      cause =
          "the prior asks for the pose at which the optimisation starts (initial_frames, or the vertex' own "
          "value); the true pose is scene.frames[i]";
    } else if (ResidualAt(scene.frames[1 - i], pose, prior) < 1e-9) {
      cause = "the prior asks for the pose of the other frame: the index of scene.frames must be the vertex' own";
    }
    FAIL() << Story("3", "the residual of the prior on frame " + std::to_string(i) + " at the frame's true pose", "0",
                    std::to_string(residual), cause, "3");
  }
}

TEST(Stage3, NoneAtWeightZero) {
  const Built with_priors(PerturbedScene(), 1.0, 100.0);  // otherwise nothing is shown
  ASSERT_FALSE(with_priors.Priors()[0].empty()) << "Stage 3: no prior at weight 100";
  const Built built(PerturbedScene(), 1.0, 0.0);
  for (const auto& priors : built.Priors()) {
    for (const auto& prior : priors) {
      if (prior->Information().isZero(0.0)) continue;
      FAIL() << Story("3", "the prior at weight 0", "none, or one with zero information", "one with information",
                      "the weight 0 means a free gauge: prior_weight must be the information", "3");
    }
  }
}

TEST(Stage3, NoFrameIsFixed) {
  const Built built(PerturbedScene(), 1.0, 100.0);
  for (size_t i = 0; i < built.ba.poses.size(); ++i) {
    if (!built.ba.poses[i]->IsFixed()) continue;
    FAIL() << Story("3", "frame " + std::to_string(i), "free, held by its prior alone", "fixed",
                    "prior and fixed pose together: a fixed pose has no rows in H, so its prior acts on nothing", "3");
  }
}

TEST(Stage3, MeasurementsAreUntouched) {
  const MonoBaScene scene = PerturbedScene();
  const Built built(scene, 7.0, 100.0);
  int measurements = 0;
  for (const auto& edge : built.ba.graph.Edges()) {
    if (edge->TypeInfo() != "EdgeReprojection") continue;
    ++measurements;
    ASSERT_TRUE(edge->Information().isApprox(7.0 * Mat22::Identity()))
        << Story("3", "the information of a reprojection edge", "7·I₂", "another",
                 "the loop of the measurements was changed; it was right", "");
  }
  if (measurements != kPoints * (kFrames - 1)) {
    FAIL() << Story("3", "the number of reprojection edges of 6 points in 4 frames", "18", std::to_string(measurements),
                    "the loop of the measurements was changed; it was right", "");
  }
}

TEST(Stage3, DriftOfTheFirstFrameGoesToZero) {
  const MonoBaScene scene = PerturbedScene();
  double last_drift = 1.0;
  for (const double weight : {1e2, 1e5, 1e8, 1e11}) {
    Built built(scene, 1e6, weight);
    Problem problem(&built.ba.graph);
    SolveOptions options;
    options.max_iterations = 50;
    problem.Solve(options);
    const double drift = (built.ba.poses[0]->p() - scene.frames[0].p).norm();
    // While the pixels outweigh the priors, it need not fall.
    EXPECT_LT(drift, 2.0 * last_drift) << "Stage 3: the position of frame 0 after solving with weight " << weight;
    last_drift = drift;
  }
  EXPECT_LT(last_drift, 1e-6) << "Stage 3: the drift of frame 0 [m] must vanish as the weight grows";
}

}  // namespace
}  // namespace ch5::homework
