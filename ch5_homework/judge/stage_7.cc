/// Stage 7, TODOs 7b to 7e: H and b in blocks, then S and Δx, each against a dense oracle; stage_7_pattern.cc comes before.
/// From simple to hard; the first failure ends the check.

#include <gtest/gtest.h>

#include <functional>

#include "ch5_homework/judge/mistakes/stage_7_solve.h"
#include "ch5_homework/judge/mistakes/stage_7_system.h"
#include "ch5_homework/judge/scenes/bundle.h"
#include "ch5_homework/judge/stage_7_scene.h"

namespace ch5::homework {
namespace {

using namespace stage_7;

// ---- 7b, 7c: b and H ---------------------------------------------------------------------------------------------

void CheckSystem(PlainBlockSolver* solver, const Graph& graph, const Text& scene) {
  solver->BuildSystem();
  const Ordering& ordering = solver->GetOrdering();
  const System right = StackedNormalEquations(graph, ordering.Size());
  const Names names = RowNames(ordering, true);
  const Loop loop{graph.Edges(), ordering.Size()};
  Require(
      "7", {"scene.b_of", {{"what", scene}}}, right.b, solver->RightHandSide(), names,
      [&] { return MistakesInB(loop, ordering); }, 1e-10, "7b", "b_");
  Require(
      "7", {"scene.H_of", {{"what", scene}}}, right.H, solver->DenseHessian(), names,
      [&] { return MistakesInH(loop, ordering); }, 1e-10, "7c", "H");
}

TEST(Stage7, RightHandSideAndHessian) {
  for (const bool fix_one : {false, true}) {
    GraphScene row("row", {fix_one});
    CheckSystem(MakeSolver(&row.graph).get(), row.graph, fix_one ? "7.row_one_fixed" : "7.row");
  }
}

TEST(Stage7, HessianOfMixedLandmarksAndLosses) {
  GraphScene scene("mixed landmarks");
  const auto solver = MakeSolver(&scene.graph);
  for (int again = 0; again < 2; ++again) {  // the second time H is not empty at the start
    CheckSystem(solver.get(), scene.graph, "7.mixed_landmarks");
  }
}

// ---- 7d, 7e: S and Δx --------------------------------------------------------------------------------------------

// "Δx of the scene, λ = 0.5, D = diag(H)"
Text With(const Text& quantity, const Text& scene, double lambda, Damping damping) {
  return {damping == Damping::kIdentity ? "scene.with_lambda" : "scene.with_lambda_and_D",
          {{"quantity", quantity}, {"scene", scene}, {"l", Word(lambda)}}};
}

void CheckReducedSystem(const Case& c, const PlainBlockSolver& solver,
                        const std::function<Text(const Text& quantity)>& with) {
  const Names names = RowNames(solver.GetOrdering(), true);
  Require(
      "7", with(Word("b_p − Σ_l H_pl H_ll⁻¹ b_l")), c.Reduced(), solver.ReducedRightHandSide(), names,
      [&] { return ReducedMistakes(c); }, 1e-9, "7d", "b_schur_");
  Require(
      "7", with(Word("S = H_pp − Σ_l H_pl H_ll⁻¹ H_plᵀ")), c.Schur(), solver.SchurComplement(), names,
      [&] { return SchurMistakes(c); }, 1e-9, "7d", "S_");
}

void CheckSolve(PlainBlockSolver* solver, const Graph& graph, double lambda, Damping damping, const Text& scene) {
  const System system = StackedNormalEquations(graph, solver->Size());
  const Case c(system, solver->GetOrdering(), lambda, damping);
  solver->SetDamping(damping);
  solver->BuildSystem();
  VecX delta_x;
  const bool solved = solver->Solve(lambda, &delta_x);
  const auto with = [&](const Text& quantity) { return With(quantity, scene, lambda, damping); };
  CheckReducedSystem(c, *solver, with);
  const Names names = RowNames(solver->GetOrdering(), true);
  const VecX step = c.Step(c.H_ll_inverse * (c.b_l - c.H_pl.transpose() * c.StepOfPoses()));
  if (!solved) {
    Fail({"7", with(Word("Δx")), "7.solver_returns_true", Word("false"), "7.function_gave_up", "7d"});
  }
  Require(
      "7", with(Word("Δx")), step, delta_x, names, [&] { return StepMistakes(c); }, 1e-8, "7e", "delta_x");
  Require("7", with("7.H_after_solve"), system.H, solver->DenseHessian(), names, {}, 1e-9);
  if (!Equal(solver->RightHandSide(), system.b, 1e-9)) {
    Fail({"7", with("7.b_after_solve"), "7.b_unchanged", "7.another_b", "7.b_changed_in_place",
          Equal(solver->RightHandSide().head(c.p), system.b.head(c.p), 1e-9) ? "7e" : "7d"});
  }
}

TEST(Stage7, SchurComplementAndStep) {
  for (const bool fix_one : {false, true}) {
    GraphScene row("row", {fix_one});
    CheckSolve(MakeSolver(&row.graph).get(), row.graph, 0.0, Damping::kIdentity, fix_one ? "7.row_one_fixed" : "7.row");
  }
  GraphScene scene("poses of two sizes");
  CheckSolve(MakeSolver(&scene.graph).get(), scene.graph, 0.0, Damping::kIdentity, "7.poses_of_two_sizes");
}

TEST(Stage7, LambdaOnEveryDiagonalEntry) {
  GraphScene row("row", {false});
  const auto solver = MakeSolver(&row.graph);
  for (const double lambda : {10.0, 1e-3, 0.5}) {  // the same solver each time
    for (const Damping damping : {Damping::kIdentity, Damping::kDiagonal}) {
      CheckSolve(solver.get(), row.graph, lambda, damping, "7.row");
    }
  }
}

TEST(Stage7, LandmarksOrPosesAlone) {
  for (const bool landmarks : {true, false}) {
    GraphScene row("row", {false});
    for (const auto& pose : row.poses) pose->SetFixed(landmarks);
    for (const auto& point : row.points) point->SetFixed(!landmarks);
    CheckSolve(MakeSolver(&row.graph).get(), row.graph, 0.1, Damping::kIdentity,
               landmarks ? "7.only_points" : "7.only_poses");
  }
}

TEST(Stage7, BundleAdjustmentOfTheCourse) {
  BundleScene scene(4, Vary(20, 30, 74), true);
  const auto solver = MakeSolver(&scene.ba.graph);
  CheckSolve(solver.get(), scene.ba.graph, 1e-2, Damping::kIdentity, "7.course_scene");
  const double before = solver->Cost();
  const Summary summary = Minimize(solver.get(), SolveOptions{});
  if (!IsConverged(summary.termination) || summary.final_cost > 1e-2 * before) {
    Fail({"7", "7.course_scene_solved", "7.converged",
          Text("7.ended_at",
               {{"message", Text::Quoted(summary.message)}, {"a", Word(summary.final_cost)}, {"b", Word(before)}}),
          "7.something_kept_between_calls", ""});
  }
}

}  // namespace
}  // namespace ch5::homework
