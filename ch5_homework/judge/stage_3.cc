/// Stage 3: exactly one prior on each of the first two frames, and the gauge obeys it.

#include <gtest/gtest.h>

#include <cmath>
#include <map>

#include "ch5_backend/simulate/random.h"
#include "ch5_backend/types/edge_se3_prior.h"
#include "ch5_homework/judge/narrate.h"
#include "ch5_homework/judge/seed.h"
#include "ch5_homework/judge/submission.h"

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
    for (size_t i = 0; i < ba.poses.size(); ++i) {  // whoever moves a vertex to the truth needs no priors
      ba.poses[i]->SetPose(scene.initial_frames[i].q, scene.initial_frames[i].p);
    }
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
  if (W.rows() != 6 || W.cols() != 6) return "a prior on a pose has six rows: prior_weight times the 6×6 identity";
  const auto is = [&](const MatXX& other) { return Equal(W, other, 1e-9); };
  const auto all = [&](double w) { return is(w * MatXX::Identity(6, 6)); };
  const auto halves = [&](double rotation, double position) {
    const VecX w = (VecX(6) << Vec3::Constant(rotation), Vec3::Constant(position)).finished();
    return is(w.asDiagonal());
  };
  if (weight != std::trunc(weight) && (all(std::trunc(weight)) || all(std::round(weight)))) {
    return "the weight was truncated to an integer: keep it a double";
  }
  if (W.isZero(0.0)) return "the information is zero: between integers 1 / 2 is 0, write 1.0 / 2";
  if (all(1.0)) return "the information is the identity: SetInformation is missing, or without prior_weight";
  if (all(weight * weight)) return "the weight is squared; the information is prior_weight itself";
  if (all(std::sqrt(weight))) return "the root of the weight; the information is prior_weight itself";
  if (all(1.0 / weight)) return "the inverse of the weight: that would be a covariance";
  if (all(1.0 / (weight * weight))) return "the weight is taken for a standard deviation, 1/w²; it is the information";
  if (all(pixel_information)) return "this is the pixels' information; the prior's is prior_weight";
  if (all(pixel_information * weight)) return "the pixels' information is multiplied in; the prior's is prior_weight";
  if (all(0.5 * weight)) return "half the weight: the ½ is in the cost already";
  if (halves(weight, 0.0)) return "rotations only: the last three rows of the residual, the position, have no weight";
  if (halves(0.0, weight)) return "positions only: the first three rows of the residual, the rotation, have no weight";
  if (halves(weight, 1.0) || halves(1.0, weight))
    return "only one half of the residual has the weight, the other has 1";
  if (is(MatXX::Constant(6, 6, weight)))
    return "every entry is the weight; Mat66::Identity() has it on the diagonal only";
  return "the information of a prior is prior_weight times the 6×6 identity";
}

// Of W, the entry that is farthest from w·I₆.
std::string WorstEntry(const MatXX& W, double weight) {
  int row = 0, column = 0;
  if (W.rows() != 6 || W.cols() != 6) return std::to_string(W.rows()) + "×" + std::to_string(W.cols()) + " entries";
  (W - weight * MatXX::Identity(6, 6)).cwiseAbs().maxCoeff(&row, &column);
  return "W(" + std::to_string(row) + ", " + std::to_string(column) + ") = " + Number(W(row, column));
}

TEST(Stage3, InformationIsTheWeight) {
  Random random(Seed(34));
  const double pixel_information = 7.0;
  // Weights are no integers; the handout's sweep begins at 1e-3.
  for (const double weight : {100.0, 0.25, 1e-3, std::pow(10.0, random.Uniform(-3.0, 4.0))}) {
    const Built built(PerturbedScene(), pixel_information, weight);
    const auto all_priors = built.Priors();
    for (size_t i = 0; i < 2; ++i) {
      const std::string frame = "the prior on frame " + std::to_string(i) + ", weight " + Number(weight);
      if (all_priors[i].size() != 1) {
        FAIL() << Story("3", frame, "one", std::to_string(all_priors[i].size()),
                        "every weight above 0 has its priors, small ones too", "3");
      }
      const LossFunction* loss = all_priors[i][0]->GetLossFunction();
      if (loss != nullptr && dynamic_cast<const TrivialLoss*>(loss) == nullptr) {
        FAIL() << Story("3", "the loss function of " + frame, "no loss", "a loss",
                        "a prior has no loss function: it would let go of a frame that is far from its pose", "3");
      }
      const MatXX W = all_priors[i][0]->Information();
      if (Equal(W, weight * MatXX::Identity(6, 6), 1e-12)) continue;
      FAIL() << Story("3", "the information of " + frame, Number(weight) + "·I₆", WorstEntry(W, weight),
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

// Which pose a prior on frame i asks for, if not for the true one.
std::string CauseOfPose(const MonoBaScene& scene, size_t i, VertexPose* pose, Edge* prior) {
  const auto asks_for = [&](const Qd& q, const Vec3& p) { return ResidualAt({q, p}, pose, prior) < 1e-9; };
  const Transform &T = scene.frames[i], &start = scene.initial_frames[i];
  const std::string starts =
      " at which the optimisation starts (initial_frames, or the vertex' own value); the true "
      "pose is scene.frames[i]";
  if (asks_for(start.q, start.p)) return "the prior asks for the pose" + starts;
  if (asks_for(start.q, T.p)) return "the prior asks for the rotation" + starts;
  if (asks_for(T.q, start.p)) return "the prior asks for the position" + starts;
  const std::string index = ": the index of scene.frames must be the vertex' own";
  for (size_t k = 0; k < scene.frames.size(); ++k) {
    if (k == i || !asks_for(scene.frames[k].q, scene.frames[k].p)) continue;
    return "the prior asks for the pose of the other frame " + std::to_string(k) + index;
  }
  const Qd inverse = T.q.conjugate(), identity = Qd::Identity();
  if (asks_for(inverse, T.p))
    return "the quaternion is conjugated: this is the inverse rotation; it is scene.frames[i].q";
  if (asks_for(inverse, -(inverse * T.p))) return "this is the inverse of the pose; it is scene.frames[i] as it stands";
  if (asks_for(identity, T.p)) return "the prior asks for no rotation; it is scene.frames[i].q";
  if (asks_for(T.q, Vec3::Zero())) return "the prior asks for the origin; it is scene.frames[i].p";
  if (asks_for(identity, Vec3::Zero())) return "the prior asks for the identity; it is scene.frames[i]";
  if (asks_for(T.q, -T.p)) return "the sign of the position; it is scene.frames[i].p";
  for (size_t k = 0; k < scene.frames.size(); ++k) {
    const std::string other = " of the other frame " + std::to_string(k) + index;
    if (k != i && asks_for(scene.frames[k].q, T.p)) return "the prior asks for the rotation" + other;
    if (k != i && asks_for(T.q, scene.frames[k].p)) return "the prior asks for the position" + other;
  }
  return "the prior's rotation and position are those of scene.frames[i]";
}

TEST(Stage3, PriorAsksForTheTruePose) {
  const MonoBaScene scene = PerturbedScene();
  const Built built(scene, 1.0, 100.0);
  const auto all_priors = built.Priors();
  for (const size_t i : {1u, 0u}) {  // frame 0 stands at the origin, where more mistakes look alike
    ASSERT_EQ(all_priors[i].size(), 1u);
    VertexPose* pose = built.ba.poses[i].get();
    Edge* prior = all_priors[i][0].get();
    const double residual = ResidualAt(scene.frames[i], pose, prior);
    if (residual < 1e-9) continue;
    FAIL() << Story("3", "the residual of the prior on frame " + std::to_string(i) + " at the frame's true pose", "0",
                    Number(residual), CauseOfPose(scene, i, pose, prior), "3");
  }
}

TEST(Stage3, NoneAtWeightZero) {
  const Built with_priors(PerturbedScene(), 1.0, 100.0);
  ASSERT_FALSE(with_priors.Priors()[0].empty()) << "Stage 3: no prior at weight 100";  // otherwise nothing is shown
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
  ASSERT_FALSE(built.Priors()[0].empty()) << "Stage 3: no prior at weight 100";  // otherwise nothing is shown
  for (size_t i = 0; i < built.ba.poses.size(); ++i) {
    if (!built.ba.poses[i]->IsFixed()) continue;
    FAIL() << Story("3", "frame " + std::to_string(i), "free, held by its prior alone", "fixed",
                    "prior and fixed pose together: a fixed pose has no rows in H, so its prior acts on nothing", "3");
  }
}

TEST(Stage3, MeasurementsAreUntouched) {
  const MonoBaScene scene = PerturbedScene();
  const Built built(scene, 7.0, 100.0);
  ASSERT_FALSE(built.Priors()[0].empty()) << "Stage 3: no prior at weight 100";  // otherwise nothing is shown
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
    if (!(drift < 2.0 * last_drift)) {
      FAIL() << Story("3", "the drift of frame 0 [m] after solving with weight " + Number(weight),
                      "it vanishes as the weight grows", Number(drift) + ", more than twice that of a smaller weight",
                      "something else than the two priors acts on the first frames", "3");
    }
    last_drift = drift;
  }
  if (!(last_drift < 1e-6)) {
    FAIL() << Story("3", "the drift of frame 0 [m] after solving with weight 1e11", "less than 1e-6",
                    Number(last_drift), "the priors do not hold frame 0 at scene.frames[0]", "3");
  }
}

}  // namespace
}  // namespace ch5::homework
