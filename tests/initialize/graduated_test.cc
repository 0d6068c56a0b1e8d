#include "ch5_backend/initialize/graduated.h"

#include <gtest/gtest.h>

#include "ch5_backend/math/chi_squared.h"
#include "ch5_backend/types/pose_graph/edge_between.h"

namespace ch5 {
namespace {

TEST(ChiSquared, LimitsAreThoseOfTheTables) {
  EXPECT_NEAR(ChiSquaredLimit(1, 0.05), 3.841459, 1e-6);
  EXPECT_NEAR(ChiSquaredLimit(2, 0.05), 5.991465, 1e-6);
  EXPECT_NEAR(ChiSquaredLimit(3, 0.01), 11.344867, 1e-6);
  EXPECT_NEAR(ChiSquaredLimit(6, 0.01), 16.811894, 1e-6);
}

// μ = 1: 1 up to u = 1/2, √(2/u) − 1, 0 from u = 2.
TEST(Graduated, TruncatedWeightsAreTheClosedForm) {
  const auto w = [](double u, double mu) { return GraduatedWeight(Surrogate::kTruncated, u, mu); };
  EXPECT_EQ(w(0.0, 1.0), 1.0);
  EXPECT_EQ(w(0.5, 1.0), 1.0);
  EXPECT_NEAR(w(1.0, 1.0), 0.41421356237309505, 1e-15);
  EXPECT_NEAR(w(1.28, 1.0), 0.25, 1e-15);
  EXPECT_EQ(w(2.0, 1.0), 0.0);
  EXPECT_NEAR(w(100.0, 1.0 / 199.0), 0.41421356237309505 / 199.0, 1e-15);  // where it starts: (√2 − 1) μ
}

TEST(Graduated, GemanMcClureWeightsAreTheClosedForm) {
  const auto w = [](double u, double mu) { return GraduatedWeight(Surrogate::kGemanMcClure, u, mu); };
  EXPECT_EQ(w(0.0, 5.0), 1.0);
  EXPECT_EQ(w(1.0, 1.0), 0.25);
  EXPECT_EQ(w(3.0, 1.0), 0.0625);
  EXPECT_NEAR(w(100.0, 200.0), 4.0 / 9.0, 1e-15);
}

// 0 ► 1 ► 2 and 2 ► 3 by a loop edge only, 0 ► 1 a second time.
TEST(Graduated, EdgesThatNothingElseStandsInForAreNoLoops) {
  Graph graph;
  std::vector<std::shared_ptr<VertexSE2>> poses;
  for (int i = 0; i < 4; ++i) graph.AddVertex(poses.emplace_back(std::make_shared<VertexSE2>()));
  for (const auto& [i, j] : {std::pair(0, 1), {1, 2}, {1, 3}, {0, 1}, {0, 2}})
    graph.AddEdge(std::make_shared<EdgeSE2Between>(poses[i], poses[j], Vec2(1, 0), 0.0));
  std::vector<LoopVerdict> loops = FindLoops(graph, 2.0);
  ASSERT_EQ(loops.size(), 2);
  MeasureLoops(&loops);
  EXPECT_EQ(loops[0].limit, 4.0);
  EXPECT_EQ(loops[0].chi2, 1.0);  // (0, 0, 0) predicted, (1, 0, 0) measured
  EXPECT_EQ(loops[1].edge, graph.Edges()[4].get());
}

}  // namespace
}  // namespace ch5
