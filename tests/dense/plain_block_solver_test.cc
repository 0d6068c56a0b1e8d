/// PlainBlockSolver against Problem, which computes the same without blocks.
#include "ch5_backend/dense/blocks/plain_block_solver.h"

#include <gtest/gtest.h>

#include <set>
#include <stdexcept>

#include "ch5_backend/dense/problem.h"
#include "ch5_backend/simulate/mono_ba.h"
#include "ch5_backend/types/visual/edge_reprojection.h"

namespace ch5::test {
namespace {

struct Scene {
  MonoBa ba;
  Scene() {
    MonoBaOptions options;
    options.frames = 4;
    options.points = 12;
    options.position_sigma = 0.05;
    BuildMonoBa(SimulateMonoBa(options), Gauge::kPriorMinimal, 1e3, 1e3, &ba);
  }
};

TEST(SparseBlocks, HaveTheBlocksThatWereAddedAndNameTheOthers) {
  SparseBlocks A("H_pl");
  A.Add(1, 4, 6, 3);
  A(1, 4).setOnes();
  A.Add(1, 4, 6, 3);
  EXPECT_EQ(A(1, 4), MatXX::Ones(6, 3)) << "adding it again changes nothing";
  EXPECT_EQ(A.All().size(), 1u);
  A.SetZero();
  EXPECT_EQ(A(1, 4), MatXX::Zero(6, 3));
  try {
    A(4, 1);
    FAIL() << "there is no such block";
  } catch (const std::out_of_range& error) {
    EXPECT_STREQ(error.what(), "H_pl has no block (4, 1)");
  }
}

TEST(PlainBlockSolver, HasTheSystemOfProblem) {
  Scene scene;
  Problem problem(&scene.ba.graph);
  problem.MakeHessian();
  PlainBlockSolver blocks(&scene.ba.graph);
  blocks.SetOrdering();
  blocks.BuildSystem();
  ASSERT_EQ(blocks.Size(), problem.Size());
  const MatXX& H = problem.Hessian();
  EXPECT_LT((blocks.DenseHessian() - H).cwiseAbs().maxCoeff(), 1e-13 * H.cwiseAbs().maxCoeff());
  EXPECT_LT((blocks.RightHandSide() - problem.RightHandSide()).norm(), 1e-13 * problem.RightHandSide().norm());
  EXPECT_LT((blocks.HessianDiagonal() - H.diagonal()).norm(), 1e-13 * H.diagonal().norm());
  const VecX v = VecX::LinSpaced(blocks.Size(), -1.0, 1.0);
  EXPECT_LT((blocks.MultiplyHessian(v) - H * v).norm(), 1e-12 * (H * v).norm());
  EXPECT_DOUBLE_EQ(blocks.Cost(), problem.Cost());
  EXPECT_DOUBLE_EQ(blocks.StateNorm(), problem.StateNorm());
}

TEST(PlainBlockSolver, TakesTheStepOfProblem) {
  for (const auto damping : {Damping::kIdentity, Damping::kDiagonal}) {
    Scene scene;
    Problem problem(&scene.ba.graph);
    PlainBlockSolver blocks(&scene.ba.graph);
    blocks.SetOrdering();
    VecX expected, step;
    for (NormalEquations* system : {static_cast<NormalEquations*>(&problem), static_cast<NormalEquations*>(&blocks)}) {
      system->SetDamping(damping);
      system->MakeHessian();
      ASSERT_TRUE(system->SolveLinearSystem(1e-2, system == &problem ? &expected : &step));
    }
    // S has a condition of some 1e6.
    EXPECT_LT((step - expected).norm(), 1e-9 * expected.norm());
    const MatXX& S = problem.SchurComplement();
    EXPECT_LT((blocks.SchurComplement() - S).cwiseAbs().maxCoeff(), 1e-11 * S.cwiseAbs().maxCoeff());
  }
}

TEST(PlainBlockSolver, EliminatingALandmarkTiesThePosesThatSeeIt) {
  Graph graph;
  std::vector<std::shared_ptr<VertexPose>> poses;
  for (int i = 0; i < 4; ++i) {
    poses.push_back(std::make_shared<VertexPose>());
    graph.AddVertex(poses.back());
  }
  const auto see = [&](const std::vector<int>& seen_by) {
    const auto point = std::make_shared<VertexPointXYZ>(Vec3(0, 0, 4));
    graph.AddVertex(point);
    for (const int i : seen_by) graph.AddEdge(std::make_shared<EdgeReprojectionXYZ>(point, poses[i], Vec2::Zero()));
  };
  see({0, 2});
  see({1, 3});
  PlainBlockSolver blocks(&graph);
  blocks.SetOrdering();
  const auto pattern = blocks.SchurPattern();
  const std::set<std::pair<int, int>> S(pattern.begin(), pattern.end());
  EXPECT_EQ(S, (std::set<std::pair<int, int>>{{0, 0}, {1, 1}, {2, 2}, {3, 3}, {2, 0}, {3, 1}}));
}

TEST(PlainBlockSolver, ALandmarkThatNobodySeesWellEnoughIsRefused) {
  Graph graph;
  const auto pose = std::make_shared<VertexPose>();
  pose->SetFixed();
  const auto point = std::make_shared<VertexPointXYZ>(Vec3(0, 0, 4));
  graph.AddVertex(pose);
  graph.AddVertex(point);
  graph.AddEdge(std::make_shared<EdgeReprojectionXYZ>(point, pose, Vec2(0.1, 0.2)));
  PlainBlockSolver blocks(&graph);
  blocks.SetOrdering();
  blocks.MakeHessian();
  VecX step;
  EXPECT_FALSE(blocks.SolveLinearSystem(0.0, &step)) << "one image does not determine a depth";
  EXPECT_TRUE(blocks.SolveLinearSystem(1e-3, &step));
}

}  // namespace
}  // namespace ch5::test
