/// PlainBlockSolver's blocks; ../sparse/equality_test.cc compares its system and its steps with Problem's.
#include "ch5_backend/dense/blocks/plain_block_solver.h"

#include <gtest/gtest.h>

#include <stdexcept>

#include "ch5_backend/types/visual/edge_reprojection.h"
#include "tests/temporary_folder.h"

namespace ch5::test {
namespace {

TEST(SparseBlocks, HaveTheBlocksThatWereAddedAndNameTheOthers) {
  SparseBlocks A("H_pl");
  A.Add(1, 4, 6, 3);
  A(1, 4).setOnes();
  A.Add(1, 4, 6, 3);
  EXPECT_EQ(A(1, 4), MatXX::Ones(6, 3)) << "adding it again changes nothing";
  EXPECT_EQ(A.All().size(), 1u);
  A.SetZero();
  EXPECT_EQ(A(1, 4), MatXX::Zero(6, 3));
  EXPECT_EQ(Refusal<std::out_of_range>([&] { A(4, 1); }), "H_pl has no block (4, 1)");
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
