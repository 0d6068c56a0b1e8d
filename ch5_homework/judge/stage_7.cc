/// Stage 7, TODOs 7b to 7e: H and b in blocks, then S and Δx, each against a dense oracle; stage_7_pattern.cc comes before.
/// From simple to hard; the first failure ends the check.

#include <gtest/gtest.h>

#include <sstream>

#include "ch5_backend/simulate/mono_ba.h"
#include "ch5_homework/judge/mistakes/stage_7_solve.h"
#include "ch5_homework/judge/mistakes/stage_7_system.h"
#include "ch5_homework/judge/stage_7_scene.h"

namespace ch5::homework {
namespace {

using namespace stage_7;

// ---- 7b, 7c: b and H ---------------------------------------------------------------------------------------------

void CheckSystem(PlainBlockSolver* solver, const Graph& graph, const std::string& scene) {
  solver->BuildSystem();
  const Ordering& ordering = solver->GetOrdering();
  const System right = StackedNormalEquations(graph, ordering.Size());
  const Names names = RowNames(ordering, true);
  ASSERT_NO_STORY({"7",
                   "b of " + scene,
                   right.b,
                   solver->RightHandSide(),
                   names,
                   MistakesInB(graph, ordering),
                   1e-10,
                   {},
                   "7b",
                   "b_"});
  ASSERT_NO_STORY({"7",
                   "H of " + scene,
                   right.H,
                   solver->DenseHessian(),
                   names,
                   MistakesInH(graph, ordering.Size()),
                   1e-10,
                   {},
                   "7c",
                   "H"});
}

TEST(Stage7, RightHandSideAndHessian) {
  for (const bool fix_one : {false, true}) {
    Row row(fix_one);
    CheckSystem(MakeSolver(&row.graph).get(), row.graph,
                fix_one ? "5 points and 5 poses in a row, one of them fixed" : "5 points and 5 poses in a row");
    if (HasFatalFailure()) return;
  }
}

TEST(Stage7, HessianOfMixedLandmarksAndLosses) {
  Random random(Seed(73));
  Graph graph;
  const Poses poses = AddPoses(&graph, 3);
  const auto depths = AddInverseDepths(&graph, 3);
  const Points points = AddPoints(&graph, 2);
  for (const auto& depth : depths) {
    AddRandomEdge<2>(&graph, &random, depth, poses[0], poses[2]);
    AddRandomEdge<2>(&graph, &random, poses[2], depth, poses[1]);  // the later pose first
    graph.Edges().back()->SetLossFunction(std::make_shared<CauchyLoss>(1.0));
  }
  for (const auto& point : points) AddRandomEdge<2>(&graph, &random, poses[1], point);
  const auto solver = MakeSolver(&graph);
  for (int again = 0; again < 2; ++again) {  // the second time H is not empty at the start
    CheckSystem(solver.get(), graph, "3 poses, 3 inverse depths and 2 points, edges of three vertices, Cauchy losses");
    if (HasFatalFailure()) return;
  }
}

// ---- 7d, 7e: S and Δx --------------------------------------------------------------------------------------------

void CheckReducedSystem(const Case& c, const PlainBlockSolver& solver, const std::string& where) {
  const Names names = RowNames(solver.GetOrdering(), true);
  ASSERT_NO_STORY({"7",
                   "b_p − Σ_l H_pl H_ll⁻¹ b_l" + where,
                   c.Reduced(),
                   solver.ReducedRightHandSide(),
                   names,
                   ReducedMistakes(c),
                   1e-9,
                   {},
                   "7d",
                   "b_schur_"});
  ASSERT_NO_STORY({"7",
                   "S = H_pp − Σ_l H_pl H_ll⁻¹ H_plᵀ" + where,
                   c.Schur(),
                   solver.SchurComplement(),
                   names,
                   SchurMistakes(c),
                   1e-9,
                   {},
                   "7d",
                   "S_"});
}

void CheckSolve(PlainBlockSolver* solver, const Graph& graph, double lambda, Damping damping,
                const std::string& scene) {
  const System system = StackedNormalEquations(graph, solver->Size());
  const Case c(system, solver->GetOrdering(), lambda, damping);
  solver->SetDamping(damping);
  solver->BuildSystem();
  VecX delta_x;
  const bool solved = solver->Solve(lambda, &delta_x);
  std::ostringstream where;
  where << " of " << scene << ", λ = " << lambda << (damping == Damping::kIdentity ? "" : ", D = diag(H)");
  CheckReducedSystem(c, *solver, where.str());
  if (::testing::Test::HasFatalFailure()) return;
  const Names names = RowNames(solver->GetOrdering(), true);
  if (!solved) {
    FAIL() << Story("7", "Δx" + where.str(), "Solve returns true, the system is positive definite", "false",
                    "the function gave up: S is not positive definite, or Δx is not finite", "7d");
  }
  ASSERT_NO_STORY({"7",
                   "Δx" + where.str(),
                   c.Step(c.H_ll_inverse * c.Rest(-1.0)),
                   delta_x,
                   names,
                   StepMistakes(c),
                   1e-8,
                   {},
                   "7e",
                   "delta_x"});
  ASSERT_NO_STORY(
      {"7", "H after Solve (one H serves many λ)" + where.str(), system.H, solver->DenseHessian(), names, {}, 1e-9});
  if (!Equal(solver->RightHandSide(), system.b, 1e-9)) {
    FAIL() << Story("7", "b after Solve (one b serves many λ)" + where.str(), "b as BuildSystem has left it",
                    "another b", "b_ was changed in place, where the next λ meets it: write to b_schur_ and to rest",
                    "7e");
  }
}

TEST(Stage7, SchurComplementAndStep) {
  for (const bool fix_one : {false, true}) {
    Row row(fix_one);
    CheckSolve(MakeSolver(&row.graph).get(), row.graph, 0.0, Damping::kIdentity,
               fix_one ? "5 points and 5 poses in a row, one of them fixed" : "5 points and 5 poses in a row");
    if (HasFatalFailure()) return;
  }
}

TEST(Stage7, LambdaOnEveryDiagonalEntry) {
  Row row;
  const auto solver = MakeSolver(&row.graph);
  for (const double lambda : {10.0, 1e-3, 0.5}) {  // the same solver each time
    for (const Damping damping : {Damping::kIdentity, Damping::kDiagonal}) {
      CheckSolve(solver.get(), row.graph, lambda, damping, "5 points and 5 poses in a row");
      if (HasFatalFailure()) return;
    }
  }
}

TEST(Stage7, LandmarksOrPosesAlone) {
  for (const bool landmarks : {true, false}) {
    Row row;
    for (const auto& pose : row.poses) pose->SetFixed(landmarks);
    for (const auto& point : row.points) point->SetFixed(!landmarks);
    CheckSolve(MakeSolver(&row.graph).get(), row.graph, 0.1, Damping::kIdentity,
               landmarks ? "5 points, all poses fixed" : "5 poses, all points fixed");
    if (HasFatalFailure()) return;
  }
}

TEST(Stage7, BundleAdjustmentOfTheCourse) {
  MonoBaOptions options;
  options.seed = Seed(options.seed);
  options.frames = 4;
  options.points = Vary(20, 30, 74);
  MonoBa ba;
  BuildMonoBa(SimulateMonoBa(options), Gauge::kFixTwoFrames, 1.0, 0.0, &ba);
  const auto solver = MakeSolver(&ba.graph);
  CheckSolve(solver.get(), ba.graph, 1e-2, Damping::kIdentity, "the course's scene, 2 of 4 poses fixed");
  if (HasFatalFailure()) return;
  const double before = solver->ComputeChi();
  const Summary summary = Minimize(solver.get(), SolveOptions{});
  if (!IsConverged(summary.termination) || summary.final_cost > 1e-2 * before) {
    FAIL() << Story("7", "the course's scene solved with your BuildSystem and Solve",
                    "converged, at less than a hundredth of the cost",
                    summary.message + ", at " + Number(summary.final_cost) + " from " + Number(before),
                    "one call is right, many are not: something is kept from the call before", "");
  }
}

}  // namespace
}  // namespace ch5::homework
