#include "ch5_backend/initialize/graduated.h"

#include <gtest/gtest.h>

#include <cmath>
#include <tuple>

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

// A walk of 40 poses there and back, 0.1 m beside itself, with loops across that agree to 1 mm. W claims 1 m.
TEST(Graduated, LoopsThatAgreeBetterThanTheirInformationLowerTheLimit) {
  for (const double noise : {0.001, 1.0}) {
    Graph graph;
    std::vector<std::shared_ptr<VertexSE2>> poses;
    for (int i = 0; i < 80; ++i) graph.AddVertex(poses.emplace_back(std::make_shared<VertexSE2>()));
    const auto measure = [&](int i, int j, double x, double y) {
      graph.AddEdge(std::make_shared<EdgeSE2Between>(poses[i], poses[j], Vec2(x, y), 0.0));
    };
    for (int i = 1; i < 80; ++i) measure(i - 1, i, i == 40 ? 0.0 : i < 40 ? 1.0 : -1.0, i == 40 ? 0.1 : 0.0);
    for (int i = 0; i < 38; ++i) measure(i, 79 - i, noise * std::sin(3.7 * i), 0.1);
    const double limit = FindLoops(graph).front().limit;
    const double by_information = ChiSquaredLimit(3, -std::expm1(std::log(0.99) / 38.0));
    if (noise < 1.0) {
      EXPECT_LT(limit, 0.1 * by_information);
    } else {
      EXPECT_NEAR(limit, by_information, 1e-9);
    }
  }
}

// 0 ► 1 ► 2 ► 3, W = 1: by the path pose 3 is known to a variance of 3 along x, so that a loop 0 ► 3 that is off by 4 has
// χ² = 16 / (1 + 3).
TEST(Graduated, ALoopIsJudgedByWhatIsUncertainOfItsPredictionToo) {
  Graph graph;
  std::vector<std::shared_ptr<VertexSE2>> poses;
  for (int i = 0; i < 4; ++i) graph.AddVertex(poses.emplace_back(std::make_shared<VertexSE2>(Vec2(i, 0.0), 0.0)));
  poses[0]->SetFixed();
  for (const auto& [i, j, x] : {std::tuple(0, 1, 1.0), {1, 2, 1.0}, {2, 3, 1.0}, {0, 3, 7.0}})
    graph.AddEdge(std::make_shared<EdgeSE2Between>(poses[i], poses[j], Vec2(x, 0.0), 0.0));
  for (const double limit : {15.0, 3.9}) {
    std::vector<LoopVerdict> loops = FindLoops(graph, std::sqrt(limit));
    MeasureLoops(&loops);
    ASSERT_EQ(loops.size(), 1);
    EXPECT_NEAR(loops[0].chi2, 16.0, 1e-12);
    EXPECT_TRUE(SeparateFalseLoops(loops));
    ReadmitLoops(&graph, &loops);
    EXPECT_NEAR(loops[0].chi2, limit > 4.0 ? 4.0 : 16.0, 1e-9);
    loops[0].edge->SetLevel(0);
  }
}

}  // namespace
}  // namespace ch5
