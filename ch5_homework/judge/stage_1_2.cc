/// Stage 1.2: Δx equals a dense solve of the damped system (H + λD) Δx = b. H and b come from elsewhere, so that
/// stage 1.1 may be blank. From simple to hard; the first failure ends the check.

#include <gtest/gtest.h>

#include <algorithm>

#include "ch5_homework/judge/ask.h"
#include "ch5_homework/judge/oracle.h"
#include "ch5_homework/judge/right/formulas.h"
#include "ch5_homework/judge/scenes/bundle.h"
#include "ch5_homework/judge/unset_memory.h"

namespace ch5::homework {
namespace {

// Why SolveLinearSystem may return false.
Text CauseOfGivingUp(const Ordering& ordering, const VecX& delta_x) {
  if (ordering.poses.empty()) return "1.2.gave_up_without_poses";
  if (std::any_of(delta_x.begin(), delta_x.end(), &IsFreed)) return "matrix.freed_memory_read";
  if (std::any_of(delta_x.begin(), delta_x.end(), &IsFresh)) return "1.2.landmark_step_unset";
  if (!delta_x.allFinite()) return "matrix.not_finite";
  return "1.2.function_gave_up";
}

// Calls one after the other of the same problem.
std::vector<Solved> Solve(Scene* scene, const System& system, const VecX& lambdas, Damping damping) {
  const Answer answer =
      Ask("SolveLinearSystem", *scene, {{"H", system.H}, {"b", system.b}, {"lambdas", lambdas}, {"damping", damping}});
  std::vector<Solved> calls;
  for (size_t k = 0; k < static_cast<size_t>(lambdas.size()); ++k) calls.emplace_back(answer, k);
  return calls;
}

// One call, checked in the order in which a student computes.
void CheckCall(const Solved& got, const Ordering& ordering, const System& system, double lambda, Damping damping,
               const Text& scene, double tolerance) {
  const VecX& delta_x = got.delta_x;
  const auto with = [&](const char* quantity) { return right::With(Word(quantity), scene, lambda, damping); };
  const Names names = RowNames(ordering);
  const right::SchurSolve right(system, ordering, lambda, damping, got.b_S);
  // Solving the whole system without a Schur complement is right too: then there is none to compare.
  const bool reduced = got.S.size() > 0 && !ordering.landmarks.empty();
  if (reduced) {
    Require({with("H_pp − H_pm H_mm⁻¹ H_mp"), {}, "H_pp_schur_", names, 1e-9}, right.S, got.S);
    Require({with("b_p − H_pm H_mm⁻¹ b_m"), {}, "b_pp_schur_", names, 1e-9}, right.b_S, got.b_S);
  }
  if (!got.solved) {
    const bool landmarks = delta_x.size() > 0;  // their step is computed last
    Fail({with("Δx"), "1.2.solver_returns_true", Word("false"), CauseOfGivingUp(ordering, delta_x),
          landmarks ? "1.2c" : "1.2b"});
  }
  if (delta_x.size() == 0) {
    const Text size = Word(std::to_string(names.size()) + "×1");
    Fail({with("Δx"),
          {"matrix.size_expected", {{"size", size}}},
          {"matrix.size_got", {{"size", Word("0×1")}}},
          "1.2.returned_too_early"});
  }
  Require({with("Δx"), "1.2c", "delta_x_ll", names, tolerance}, right.delta_x, delta_x);
}

/// How many vertices a problem has, in this order.
struct Counts {
  int points, poses, depths, more_points = 0;  // the first points have smaller ids than the poses, later rows
};

/// A problem over a graph whose vertices all have an edge, with a random system in place of MakeHessian's.
/// @param unit  of H, and of b too but for a step that is `far` times as long
void CheckRandom(const Counts& n, double lambda, Damping damping, const Text& words, double unit = 1.0,
                 double far = 1.0) {
  GraphScene scene("edges of one vertex", {n.points, n.poses, n.depths, n.more_points});
  const Ordering ordering = MakeOrdering(scene.graph);
  // Other numbers for each λ, as when LM has made a step, and for each unit: what is kept from another call shows.
  Random random(Seed(12 + static_cast<int>(1000.0 * lambda) + (unit != 1.0)));
  const System random_system = RandomSystem(ordering, &random);
  const System system{unit * random_system.H, far * unit * random_system.b};
  const Solved got = Solve(&scene, system, VecX::Constant(1, lambda), damping)[0];
  CheckCall(got, ordering, system, lambda, damping, words, 1e-8);
}

TEST(Stage12, AsManyPoseRowsAsLandmarkRows) {  // first: here no assertion betrays an exchange of p and m
  CheckRandom({0, 1, 6}, 0.0, Damping::kIdentity, "1.2.as_many_pose_as_landmark_rows");
}

TEST(Stage12, LandmarksOfDimensionOne) {
  const int depths = Vary(5, 9, 22);
  CheckRandom({0, 2, depths}, 0.0, Damping::kIdentity, {"1.2.two_poses_and_inverse_depths", {{"n", Word(depths)}}});
  CheckRandom({0, 2, 5}, 0.0, Damping::kIdentity, "1.2.two_poses_large_numbers", 1e9);  // whose inverses are small
  CheckRandom({0, 2, 5}, 0.0, Damping::kIdentity, "1.2.two_poses_large_numbers", 1e9, 1e9);
}

TEST(Stage12, LandmarksOfDimensionThree) {
  CheckRandom({2, 2, 1, 1}, 0.0, Damping::kIdentity, "1.2.two_poses_points_and_inverse_depth");
}

TEST(Stage12, WithOneLandmarkAndWithNone) {
  for (const int landmarks : {1, 0}) {
    CheckRandom({0, 2, landmarks}, 0.5, Damping::kIdentity,
                landmarks ? "1.2.two_poses_one_landmark" : "1.2.two_poses_no_landmarks");
  }
  CheckRandom({1, 0, 2}, 0.5, Damping::kIdentity, "1.2.landmarks_alone");  // as with all poses fixed
}

TEST(Stage12, LambdaOnEveryDiagonalEntry) {
  for (const double lambda : {1e-3, 0.3, 10.0}) {
    CheckRandom({0, 2, 3, 1}, lambda, Damping::kIdentity, "1.2.two_poses_inverse_depths_and_point");
  }
}

TEST(Stage12, LambdaTimesTheDiagonal) {
  const int depths = Vary(7, 11, 23);
  CheckRandom({0, 2, depths}, 0.3, Damping::kDiagonal, {"1.2.two_poses_and_inverse_depths", {{"n", Word(depths)}}});
}

TEST(Stage12, BundleAdjustmentWithManyLambdas) {
  const int frames = Vary(8, 10, 29);
  BundleScene scene(frames, 120, true);
  const Text words("1.2.course_scene", {{"n", Word(frames)}, {"m", Word(scene.ba.landmarks.size())}});
  const Ordering ordering = MakeOrdering(scene.ba.graph);
  const System system = StackedNormalEquations(scene.ba.graph, ordering.Size());
  const Vec3 lambdas(1.0, 0.0, 1e-4);  // the same H each time, as LM asks for it
  const auto calls = Solve(&scene, system, lambdas, Damping::kIdentity);
  for (size_t k = 0; k < calls.size(); ++k) {
    const Solved& got = calls[k];
    // Explicit inverses and conjugate gradients are welcome, and lose some digits here.
    CheckCall(got, ordering, system, lambdas[static_cast<Eigen::Index>(k)], Damping::kIdentity, words, 1e-7);
    const Mistakes in_H{{"1.2a", right::ChangedInPlace("Hessian_", "H"), got.H}},
        in_b{{"1.2b", right::ChangedInPlace("b_", "b_pp_schur_"), got.b}};
    Require({"1.2.hessian_after_call", {}, {}, RowNames(ordering), 1e-10, in_H}, system.H, got.H);
    Require({"1.2.b_after_call", {}, {}, RowNames(ordering), 1e-10, in_b}, system.b, got.b);
  }
}

}  // namespace
}  // namespace ch5::homework
