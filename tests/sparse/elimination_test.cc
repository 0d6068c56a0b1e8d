// The steps of the sparse solver one by one: H and b, S and b_S, Δx; by hand, and against the dense solver's matrices.
#include <gtest/gtest.h>

#include <Eigen/LU>

#include "ch5_backend/dense/problem.h"
#include "ch5_backend/sparse/hessian_product.h"
#include "ch5_backend/sparse/hold_poses.h"
#include "ch5_backend/sparse/steps/back_substitute.h"
#include "ch5_backend/sparse/steps/eliminate.h"
#include "ch5_backend/sparse/steps/implicit_solver.h"
#include "ch5_backend/sparse/steps/linearize.h"
#include "tests/scenes.h"
#include "tests/sparse/scalar_graph.h"

namespace ch5::test {
namespace {

// Structure → Linearized → Eliminated → Step, as SparseSolver calls them.
struct Steps {
  Structure structure;
  ThreadPool pool{1};
  Linearized linearized;
  SchurGroups groups;
  Eliminated eliminated;
  Step step;

  explicit Steps(const Graph& graph) : structure(BuildStructure(MakeOrdering(graph))) {
    LandmarkEdgeBatches batches;
    if (structure.sizes.AreFixed()) batches.Assign(structure);
    if (batches.Active()) batches.LoadPoses();
    linearized.factors.Prepare(structure, batches.Active() ? structure.num_landmark_edges : 0);
    linearized.Resize(structure);
    eliminated.Resize(structure);
    eliminated.S.SetPattern(structure.pose_dim, SchurPattern(structure));
    groups = PrepareSchurGroups(structure, eliminated.S, 1);
    Linearize(structure, batches, &pool, &linearized);
  }
  bool Eliminate(const DampingRule& rule) {
    if (!InvertLandmarks(structure, linearized, rule, &pool, &eliminated)) return false;
    FormSchurComplement(structure, linearized, rule, &groups, &pool, &eliminated);
    return true;
  }
  void Complete(const VecX& delta_poses) {
    step.delta_x = VecX::Zero(structure.Size());
    step.delta_x.head(delta_poses.size()) = delta_poses;
    step.H_pp_delta.setZero(delta_poses.size());
    BackSubstitute(structure, linearized, eliminated, &pool, &step);
  }
  MatXX H() const { return DenseHessian(structure, linearized); }
};

TEST(Elimination, OfOneLandmarkByHand) {
  const OnePoseOneLandmark small;
  Steps steps(small.graph);
  EXPECT_EQ(steps.H(), (MatXX(2, 2) << 2, -1, -1, 2).finished());
  EXPECT_EQ(steps.linearized.b, Vec2(-1, 7));
  EXPECT_EQ(HessianDiagonal(steps.structure, steps.linearized), Vec2(2, 2));
  EXPECT_EQ(MultiplyHessian(steps.structure, steps.linearized, Vec2(1, 3), &steps.pool), Vec2(-1, 5));

  ASSERT_TRUE(steps.Eliminate({0.0, Damping::kIdentity}));  // S = 2 − 1/2, b_S = −1 + 7/2
  EXPECT_DOUBLE_EQ(steps.eliminated.H_ll_inverse[0], 0.5);
  EXPECT_DOUBLE_EQ(steps.eliminated.S.Dense()(0, 0), 1.5);
  EXPECT_DOUBLE_EQ(steps.eliminated.b_S[0], 2.5);
  steps.Complete(VecX::Constant(1, 5.0 / 3.0));
  EXPECT_DOUBLE_EQ(steps.step.delta_x[1], 13.0 / 3.0);
  EXPECT_DOUBLE_EQ(steps.step.model_cost_change, 43.0 / 3.0);  // ½bᵀΔx

  ASSERT_TRUE(steps.Eliminate({1.0, Damping::kIdentity}));  // S = 3 − 1/3, b_S = −1 + 7/3
  EXPECT_DOUBLE_EQ(steps.eliminated.S.Dense()(0, 0), 8.0 / 3.0);
  EXPECT_DOUBLE_EQ(steps.eliminated.damped_diagonal[0], 3.0);
  steps.Complete(VecX::Constant(1, 0.5));
  EXPECT_DOUBLE_EQ(steps.step.delta_x[1], 2.5);
  EXPECT_DOUBLE_EQ(steps.step.model_cost_change, 11.75);  // bᵀΔx − ½ΔxᵀHΔx, H without damping

  ASSERT_TRUE(steps.Eliminate({1.0, Damping::kDiagonal}));  // S = 4 − 1/4
  EXPECT_DOUBLE_EQ(steps.eliminated.S.Dense()(0, 0), 3.75);
}

TEST(Elimination, RefusesALandmarkThatIsNotPositiveDefinite) {
  OnePoseOneLandmark small;
  for (const auto& edge : small.graph.Edges()) edge->SetInformation(MatXX::Zero(1, 1));
  Steps steps(small.graph);
  EXPECT_FALSE(steps.Eliminate({0.0, Damping::kIdentity}));
  EXPECT_TRUE(steps.Eliminate({1.0, Damping::kIdentity}));
}

// C δ = 0 with C = (1): the pose is held, its row and column leave the system.
TEST(HoldPoses, TakesTheHeldDirectionsOut) {
  const OnePoseOneLandmark small;
  Steps steps(small.graph);
  const auto one = [] { return MatXX(MatXX::Ones(1, 1)); };
  EXPECT_TRUE(FindHeldPoses(steps.structure, {{small.origin, one}}).empty()) << "what is fixed is held already";
  EXPECT_THROW(FindHeldPoses(steps.structure, {{small.landmarks[0], one}}), std::invalid_argument);
  const std::vector<HeldPose> held = FindHeldPoses(steps.structure, {{small.poses[0], one}});
  ASSERT_EQ(held.size(), 1u);
  EXPECT_DOUBLE_EQ(held[0].projection(0, 0), 0.0);
  HoldPoses(steps.structure, held, &steps.linearized);
  const MatXX H = steps.H();
  EXPECT_GT(H(0, 0), 0.0) << "to keep it regular";
  EXPECT_DOUBLE_EQ(H(0, 1), 0.0);
  EXPECT_DOUBLE_EQ(H(1, 1), 2.0);
  EXPECT_EQ(steps.linearized.b, Vec2(0, 7));
}

class EliminationSteps : public testing::TestWithParam<Scene> {};

TEST_P(EliminationSteps, AreThoseOfTheDenseMatrices) {
  Graph graph;
  GetParam().build(&graph);
  Steps steps(graph);
  Problem problem(&graph);
  problem.MakeHessian();
  const MatXX& H = problem.Hessian();
  const VecX& b = problem.RightHandSide();
  EXPECT_LT((steps.H() - H).norm(), 1e-12 * H.norm());
  EXPECT_LT((steps.linearized.b - b).norm(), 1e-12 * b.norm());
  EXPECT_LT((HessianDiagonal(steps.structure, steps.linearized) - H.diagonal()).norm(), 1e-12 * H.diagonal().norm());
  EXPECT_LT((MultiplyHessian(steps.structure, steps.linearized, b, &steps.pool) - H * b).norm(),
            1e-12 * H.norm() * b.norm());

  constexpr double kLambda = 1e-2;
  MatXX damped = H;
  damped.diagonal() *= 1.0 + kLambda;
  const int p = steps.structure.ordering.dim_poses, m = steps.structure.ordering.dim_landmarks;
  MatXX H_ll_inverse(m, m);  // Eigen inverts no empty matrix
  if (m > 0) H_ll_inverse = damped.bottomRightCorner(m, m).inverse();
  const MatXX K = damped.topRightCorner(p, m) * H_ll_inverse;
  const MatXX S = damped.topLeftCorner(p, p) - K * damped.bottomLeftCorner(m, p);
  const VecX b_S = b.head(p) - K * b.tail(m);
  VecX delta_poses(p);
  if (p > 0) delta_poses = S.fullPivLu().solve(b_S);
  ASSERT_TRUE(steps.Eliminate({kLambda, Damping::kDiagonal}));
  // S is what remains of numbers as large as H_pp.
  EXPECT_LE((steps.eliminated.S.Dense() - S).norm(), 1e-11 * damped.topLeftCorner(p, p).norm());
  EXPECT_LT((steps.eliminated.b_S - b_S).norm(), 1e-10 * b.norm());
  EXPECT_LT((steps.eliminated.damped_diagonal - damped.diagonal().head(p)).norm(), 1e-12 * H.norm());

  steps.Complete(delta_poses);
  const VecX& x = steps.step.delta_x;
  const VecX rest =
      damped.bottomLeftCorner(m, p) * delta_poses + damped.bottomRightCorner(m, m) * x.tail(m) - b.tail(m);
  EXPECT_LT(rest.norm(), 1e-10 * (b.norm() + H.norm() * x.norm()));
  const double decrease = b.dot(x) - 0.5 * x.dot(H * x);
  EXPECT_NEAR(steps.step.model_cost_change, decrease, 1e-9 * std::abs(b.dot(x)));
}

TEST_P(EliminationSteps, AreSolvedWithoutFormingS) {
  Graph graph;
  GetParam().build(&graph);
  Steps steps(graph);
  if (steps.structure.NumPoses() == 0) GTEST_SKIP() << "landmarks alone have no S";
  const DampingRule rule{1e-2, Damping::kDiagonal};
  ASSERT_TRUE(steps.Eliminate(rule));
  const MatXX S = steps.eliminated.S.Dense();
  const VecX b_S = steps.eliminated.b_S;
  for (const auto type : {ReducedSolverType::kImplicitPcg, ReducedSolverType::kPowerSeries}) {
    const auto solver = MakeImplicitSolver(type, IterativeOptions::Exact());
    solver->Prepare(steps.structure, &steps.pool);
    VecX x = VecX::Zero(b_S.size());
    ASSERT_TRUE(solver->Solve(steps.linearized, rule, &steps.eliminated, &x));
    EXPECT_LT((S * x - b_S).norm(), 1e-6 * b_S.norm());
    EXPECT_LT((steps.eliminated.b_S - b_S).norm(), 1e-10 * steps.linearized.b.norm());
    EXPECT_GT(solver->Products(), 0);
  }
}

INSTANTIATE_TEST_SUITE_P(Scenes, EliminationSteps, testing::ValuesIn(AllScenes()),
                         [](const testing::TestParamInfo<Scene>& info) { return info.param.name; });

}  // namespace
}  // namespace ch5::test
