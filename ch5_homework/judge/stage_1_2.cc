/// Stage 1.2: Δx equals a dense solve of the damped system (H + λD) Δx = b. H and b come from elsewhere, so that
/// stage 1.1 may be blank. From simple to hard; the first failure ends the check.

#include <gtest/gtest.h>

#include "ch5_homework/judge/mistakes/stage_1_2.h"
#include "ch5_homework/judge/scenes.h"
#include "ch5_homework/judge/submission.h"

namespace ch5::homework {
namespace {

using namespace stage_1_2;

// Why SolveLinearSystem may return false.
std::string CauseOfGivingUp(const Problem& problem, const Parts& right, const VecX& delta_x) {
  if (problem.SchurComplement().size() == 0 && right.b_m.size() > 0) {
    return "still empty: nothing was assigned to H_pp_schur_";
  }
  if (delta_x.size() > 0 && !delta_x.allFinite()) return "nothing was assigned to delta_x_ll, or not to all of it";
  return "the function gave up: Hmm is not made of the landmarks' blocks, which are positive definite";
}

// One call, checked in the order in which a student computes.
void CheckCall(Problem* problem, const Case& c, const std::string& scene) {
  problem->SetDamping(c.damping);
  VecX delta_x;
  const bool solved = problem->SolveLinearSystem(c.lambda, &delta_x);

  std::ostringstream where;
  where << " of " << scene << ", λ = " << c.lambda << (c.damping == Damping::kIdentity ? "" : ", D = diag(H)");
  const Names names = RowNames(problem->GetOrdering());
  const Parts right = c.Right();
  // Who solves the whole system without a Schur complement is right too: then there is none to compare.
  const bool reduced = problem->SchurComplement().size() > 0 && right.b_m.size() > 0;
  if (reduced) {
    ASSERT_NO_STORY({"1.2", "H_pp − H_pm H_mm⁻¹ H_mp" + where.str(), right.Schur(), problem->SchurComplement(), names,
                     c.SchurMistakes(), 1e-9});
    ASSERT_NO_STORY({"1.2",
                     "b_p − H_pm H_mm⁻¹ b_m" + where.str(),
                     right.Reduced(),
                     ReducedRightHandSide(*problem),
                     names,
                     c.ReducedMistakes(),
                     1e-9,
                     {},
                     "1.2b",
                     "b_pp_schur_"});
  }
  if (!solved) {
    FAIL() << Story("1.2", "Δx" + where.str(), "SolveLinearSystem returns true, the system is positive definite",
                    "false", CauseOfGivingUp(*problem, right, delta_x), "1.2b");
  }
  // Explicit inverses and conjugate gradients are welcome, and lose some digits.
  ASSERT_NO_STORY({"1.2",
                   "Δx" + where.str(),
                   Solve(c.Damped(), c.system.b),
                   delta_x,
                   names,
                   c.StepMistakes(),
                   1e-7,
                   {},
                   "1.2c",
                   "delta_x_ll"});
}

/// A problem over a graph whose vertices all have an edge, with a random system in place of MakeHessian's.
void CheckRandom(Graph* graph, double lambda, Damping damping, const std::string& scene) {
  Random random(Seed(21));
  for (const auto& vertex : graph->Vertices()) {
    if (auto pose = std::dynamic_pointer_cast<VertexPose>(vertex)) AddRandomEdge<1>(graph, &random, pose);
    if (auto depth = std::dynamic_pointer_cast<VertexInverseDepth>(vertex)) AddRandomEdge<1>(graph, &random, depth);
    if (auto point = std::dynamic_pointer_cast<VertexPointXYZ>(vertex)) AddRandomEdge<1>(graph, &random, point);
  }
  const auto problem = Chosen().make_problem(graph);
  const System system = RandomSystem(problem->GetOrdering(), &random);
  SetSystem(system, problem.get());
  CheckCall(problem.get(), {system, problem->GetOrdering().dim_poses, lambda, damping}, scene);
}

TEST(Stage12, AsManyPoseRowsAsLandmarkRows) {  // first: here no assertion betrays an exchange of p and m
  Graph graph;
  AddPoses(&graph, 1);
  AddInverseDepths(&graph, 6);
  CheckRandom(&graph, 0.0, Damping::kIdentity, "a random system, 6 rows of a pose and 6 inverse depths");
}

TEST(Stage12, LandmarksOfDimensionOne) {
  Graph graph;
  AddPoses(&graph, 2);
  const int depths = Vary(5, 9, 22);
  AddInverseDepths(&graph, depths);
  CheckRandom(&graph, 0.0, Damping::kIdentity,
              "a random system, 2 poses and " + std::to_string(depths) + " inverse depths");
}

TEST(Stage12, LandmarksOfDimensionThree) {
  Graph graph;
  AddPoints(&graph, 2);  // smaller ids than the poses, later rows
  AddPoses(&graph, 2);
  AddInverseDepths(&graph, 1);
  AddPoints(&graph, 1);
  CheckRandom(&graph, 0.0, Damping::kIdentity, "a random system, 2 poses, 3 points of dimension 3, an inverse depth");
}

TEST(Stage12, WithOneLandmarkAndWithNone) {
  for (const int landmarks : {1, 0}) {
    Graph graph;
    AddPoses(&graph, 2);
    AddInverseDepths(&graph, landmarks);
    CheckRandom(&graph, 0.5, Damping::kIdentity,
                "a random system, 2 poses and " + std::string(landmarks ? "one landmark" : "no landmarks"));
    if (HasFatalFailure()) return;
  }
}

TEST(Stage12, LambdaOnEveryDiagonalEntry) {
  for (const double lambda : {1e-3, 0.3, 10.0}) {
    Graph graph;
    AddPoses(&graph, 2);
    AddInverseDepths(&graph, 3);
    AddPoints(&graph, 1);
    CheckRandom(&graph, lambda, Damping::kIdentity, "a random system, 2 poses, 3 inverse depths and a point");
    if (HasFatalFailure()) return;
  }
}

TEST(Stage12, LambdaTimesTheDiagonal) {
  Graph graph;
  AddPoses(&graph, 2);
  const int depths = Vary(7, 11, 23);
  AddInverseDepths(&graph, depths);
  CheckRandom(&graph, 0.3, Damping::kDiagonal,
              "a random system, 2 poses and " + std::to_string(depths) + " inverse depths");
}

TEST(Stage12, BundleAdjustmentWithManyLambdas) {
  MonoBaOptions options;
  options.seed = Seed(options.seed);
  options.frames = 4;
  MonoBa ba;
  BuildMonoBa(SimulateMonoBa(options), Gauge::kFixTwoFrames, 1.0, 0.0, &ba);
  const auto problem = Chosen().make_problem(&ba.graph);
  const System system = StackedNormalEquations(ba.graph, problem->Size());
  SetSystem(system, problem.get());
  for (const double lambda : {1.0, 0.0, 1e-4}) {  // the same H each time, as LM asks for it
    const Case c{system, problem->GetOrdering().dim_poses, lambda, Damping::kIdentity};
    CheckCall(problem.get(), c, "the course's scene, 2 of 4 poses fixed, 20 inverse depths");
    if (HasFatalFailure()) return;
    const Mistake damped{"1.2a",
                         "λ was written into Hessian_ itself, where the next call meets it; H is its damped copy",
                         [&] { return c.Damped(); }};
    ASSERT_NO_STORY({"1.2",
                     "Hessian_ after a call (MakeHessian's H serves many λ)",
                     system.H,
                     problem->Hessian(),
                     RowNames(problem->GetOrdering()),
                     {damped}});
    ASSERT_NO_STORY({"1.2",
                     "b_ after a call (one b serves many λ)",
                     system.b,
                     problem->RightHandSide(),
                     RowNames(problem->GetOrdering()),
                     {{"1.2b", "b_ was changed in place, where the next call meets it; write to b_pp_schur_",
                       [&] { return MatXX(problem->RightHandSide()); }}}});
  }
}

}  // namespace
}  // namespace ch5::homework
