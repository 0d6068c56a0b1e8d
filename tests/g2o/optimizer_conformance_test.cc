// What g2o promises of SparseOptimizer and its graph. The rows and where they are tested:
//
//   G1   H Δx = b with b = −JᵀΩe                  solve/normal_equations.h     ../sparse/structure_test.cc, ../dense/problem_test.cc
//   G2   initializeOptimization, levels           graph/ordering.h             graph_conformance_test.cc, optimizer_conformance_test.cc
//   G3   the index mapping, in order of ids       graph/ordering.h             graph_conformance_test.cc, system_conformance_test.cc
//   G4   no edge between landmarks                sparse/steps/structure.h     system_conformance_test.cc
//   G5   numeric Jacobians                        graph/edge.h                 system_conformance_test.cc
//   G6   robust kernels                           graph/loss.h                 system_conformance_test.cc, ../graph/loss_test.cc
//   G7   Levenberg–Marquardt                      solve/step_strategy.h         algorithm_conformance_test.cc, ../solve/minimizer_test.cc
//   G8   Dogleg                                   solve/step_strategy.h         algorithm_conformance_test.cc
//   G9   the terminate action                     solve/minimizer.h            optimizer_conformance_test.cc
//   G10  what optimize returns                    sparse/sparse_optimizer.h     optimizer_conformance_test.cc
//   G11  computeMarginals, the true ones          sparse/covariance.h           covariance_conformance_test.cc
//   G12  push, pop, clear, gauge …                graph/graph.h                graph_conformance_test.cc, optimizer_conformance_test.cc
//   G13  all linear solvers give the same x       linear/reduced_solver.h       ../sparse/equality_test.cc
//   G14  what a graph refuses                     graph/graph.h                graph_conformance_test.cc
//   G15  .g2o files, the choice in three steps    files/g2o_file.h                   optimizer_conformance_test.cc, ../files/g2o_file_test.cc
//        buildStructure, setLambda, saveHessian   sparse/sparse_solver.h                system_conformance_test.cc, ../sparse/structure_test.cc
#include <gtest/gtest.h>

#include <fstream>

#include "ch5_backend/dense/blocks/plain_block_solver.h"
#include "ch5_backend/dense/problem.h"
#include "ch5_backend/files/g2o_file.h"
#include "ch5_backend/sparse/sparse_optimizer.h"
#include "ch5_backend/sparse/sparse_solver.h"
#include "ch5_backend/types/edge_se3_prior.h"
#include "tests/g2o/bundle.h"
#include "tests/g2o/point_chain.h"

namespace ch5::test {
namespace {

TEST(G2o, G2_OnlyActiveEdgesAreOptimized) {
  PointChain chain(4);
  chain.points[0]->SetFixed();
  chain.edges[2]->SetLevel(1);
  const Vec3 start = chain.points[3]->GetEstimate();
  SparseOptimizer optimizer(&chain.graph);
  ASSERT_TRUE(optimizer.InitializeOptimization());
  EXPECT_EQ(optimizer.ActiveEdges().size(), 2u);
  EXPECT_EQ(optimizer.IndexMapping(), (std::vector<std::shared_ptr<Vertex>>{chain.points[1], chain.points[2]}));
  EXPECT_GT(optimizer.Optimize(5), 0);
  EXPECT_LT((chain.points[2]->GetEstimate() - Vec3(2, 0, 0)).norm(), 1e-9);
  EXPECT_EQ(chain.points[3]->GetEstimate(), start);
  ASSERT_TRUE(optimizer.InitializeOptimization({chain.points[3], chain.points[2]}, /*level=*/-1));
  EXPECT_EQ(optimizer.ActiveEdges(), std::vector<std::shared_ptr<Edge>>{chain.edges[2]});
  EXPECT_GT(optimizer.Optimize(5), 0);
  EXPECT_LT((chain.points[3]->GetEstimate() - chain.points[2]->GetEstimate() - Vec3(1, 0, 0)).norm(), 1e-9);
  EXPECT_FALSE(optimizer.InitializeOptimization(/*level=*/7));
}

TEST(G2o, G2_EveryRoomLeavesOtherLevelsOut) {
  PointChain chain(4);
  chain.points[0]->SetFixed();
  chain.edges[2]->SetLevel(1);
  Problem dense(&chain.graph);
  PlainBlockSolver plain(&chain.graph);
  for (NormalEquations* system : {static_cast<NormalEquations*>(&dense), static_cast<NormalEquations*>(&plain)}) {
    system->SetOrdering();
    system->MakeHessian();
    EXPECT_EQ(system->Size(), 6);
    EXPECT_NEAR(system->Cost(), 0.5 * (0.01 + 0.09 + 0.04 + 0.01), 1e-12);
    EXPECT_LT((system->HessianDiagonal() - (VecX(6) << 2, 2, 2, 1, 1, 1).finished()).norm(), 1e-12);
  }
}

TEST(G2o, G2_AnEdgeWhoseVerticesAreAllFixedIsNotActive) {
  PointChain chain(3);
  chain.points[0]->SetFixed();
  chain.points[1]->SetFixed();
  SparseOptimizer optimizer(&chain.graph);
  ASSERT_TRUE(optimizer.InitializeOptimization());
  EXPECT_EQ(optimizer.ActiveEdges(), std::vector<std::shared_ptr<Edge>>{chain.edges[1]});
  EXPECT_NEAR(optimizer.ActiveChi2(), 0.01, 1e-14) << "0.1 too long, and without the first edge";
  chain.points[2]->SetFixed();
  EXPECT_FALSE(optimizer.InitializeOptimization());
}

// Unlike ActiveChi2, and like Ceres' costs with their fixed part: twice the cost is the χ² of the whole selection.
TEST(G2o, G2_CostsCountTheEdgesThatAreFixed) {
  PointChain chain(3);
  chain.points[0]->SetFixed();
  chain.points[1]->SetFixed();
  Problem dense(&chain.graph);
  SparseOptimizer fast(&chain.graph);
  for (NormalEquations* system :
       {static_cast<NormalEquations*>(&dense), static_cast<NormalEquations*>(&fast.GetSolver())}) {
    chain.points[2]->SetEstimate({2.2, 0.3, -0.2});
    const Summary summary = Minimize(system);
    EXPECT_NEAR(summary.initial_cost, 0.07 + 0.005, 1e-14);  // ½(0.1² + 0.3² + 0.2²) + ½·0.1²
    EXPECT_NEAR(summary.final_cost, 0.07, 1e-14);
  }
}

TEST(G2o, G2_RoundsThatPutOutliersOnLevelOneRecoverTheTruth) {
  Bundle bundle(6, 60, /*noise=*/0.0);
  // Every eleventh pixel is wrong by 50 σ and more: beyond what a robust loss alone forgives.
  std::vector<std::shared_ptr<Edge>> outliers;
  Graph& graph = bundle.graph;
  for (size_t e = 0; e < bundle.edges.size(); e += 11) {
    const auto& vertices = bundle.edges[e]->Vertices();
    auto wrong = std::make_shared<EdgeReprojectionXYZ>(std::static_pointer_cast<VertexPointXYZ>(vertices[0]),
                                                       std::static_pointer_cast<VertexPose>(vertices[1]),
                                                       Vec2(0.05 * static_cast<double>(1 + e % 3), -0.1));
    wrong->SetInformation(bundle.edges[e]->Information());
    graph.AddEdge(wrong);
    outliers.push_back(wrong);
  }
  constexpr double kThreshold = 5.991;  // of χ² with two degrees of freedom, 95 %
  SparseOptimizer optimizer(&graph);
  const auto huber = std::make_shared<HuberLoss>(std::sqrt(kThreshold));
  for (const auto& edge : graph.Edges()) edge->SetLossFunction(huber);
  for (int round = 0; round < 4; ++round) {
    ASSERT_TRUE(optimizer.InitializeOptimization(0));
    ASSERT_GT(optimizer.Optimize(10), 0);
    for (const auto& edge : graph.Edges()) {
      edge->ComputeResidual();
      edge->SetLevel(edge->Chi2() > kThreshold ? 1 : 0);
      if (round == 2) edge->SetLossFunction(nullptr);
    }
  }
  EXPECT_LT(bundle.DistanceToTruth(), 1e-8);
  for (const auto& edge : outliers) EXPECT_EQ(edge->Level(), 1);
  for (const auto& edge : bundle.edges) EXPECT_EQ(edge->Level(), 0);
}

TEST(G2o, G10_OptimizeReturnsMinusOneZeroOrTheIterationsDone) {
  Bundle bundle(5, 30);
  SparseOptimizer optimizer(&bundle.graph);
  EXPECT_EQ(optimizer.Optimize(5), -1) << "not initialized";
  EXPECT_FALSE(optimizer.InitializeOptimization(/*level=*/3));
  EXPECT_EQ(optimizer.Optimize(5), -1) << "nothing is active";
  ASSERT_TRUE(optimizer.InitializeOptimization());
  EXPECT_EQ(optimizer.Optimize(2), 2);
  EXPECT_EQ(optimizer.Optimize(0), 0);
  EXPECT_EQ(optimizer.GetSummary().iterations, 0);
  bundle.poses[1]->SetFixed(false);  // the scale is free, and without damping nothing holds it
  bundle.poses[0]->SetFixed(false);
  optimizer.SetAlgorithm(Algorithm::kGaussNewton);
  for (size_t i = 0; i < bundle.truth.size(); ++i) bundle.graph.Vertices()[i]->Parameters() = bundle.truth[i];
  ASSERT_TRUE(optimizer.InitializeOptimization());
  EXPECT_EQ(optimizer.Optimize(5), 0) << optimizer.GetSummary().message;
}

TEST(G2o, G9_TheTerminateActionEndsAtASmallGain) {
  TerminateAction action(1e-2);
  const auto goes_on = [&](int iteration, double cost) {
    IterationInfo info;
    info.iteration = iteration;
    info.cost = cost;
    return action(info);
  };
  EXPECT_TRUE(goes_on(0, 100.0));
  EXPECT_TRUE(goes_on(1, 50.0));
  EXPECT_TRUE(goes_on(2, 50.0 / 1.0101));
  EXPECT_TRUE(goes_on(3, 51.0)) << "a rise is no convergence";
  EXPECT_FALSE(goes_on(4, 51.0 / 1.0099));
  EXPECT_FALSE(goes_on(5, 51.0 / 1.0099)) << "0 ≤ gain: equal costs end it too";
  EXPECT_TRUE(goes_on(0, 51.0 / 1.0099)) << "a new run begins";

  Bundle with(6, 60), without(6, 60);
  SparseOptimizer a(&with.graph), b(&without.graph);
  a.SetTerminateAction(TerminateAction(1e-6));
  ASSERT_TRUE(a.InitializeOptimization());
  ASSERT_TRUE(b.InitializeOptimization());
  const int iterations = a.Optimize(50);
  EXPECT_EQ(a.GetSummary().termination, Termination::kUserStopped);
  EXPECT_LT(iterations, b.Optimize(50));
  EXPECT_NEAR(a.ActiveChi2(), b.ActiveChi2(), 2e-6 * b.ActiveChi2());
}

TEST(G2o, G12_GaugeFreedomAndFindGauge) {
  Bundle bundle(4, 10);
  SparseOptimizer optimizer(&bundle.graph);
  EXPECT_FALSE(optimizer.GaugeFreedom());
  for (const auto& pose : bundle.poses) pose->SetFixed(false);
  bundle.points[0]->SetFixed();  // a point does not hold a pose
  EXPECT_TRUE(optimizer.GaugeFreedom());
  EXPECT_EQ(optimizer.FindGauge(), bundle.poses[0]);
  optimizer.FindGauge()->SetFixed();
  EXPECT_FALSE(optimizer.GaugeFreedom());
  bundle.poses[0]->SetFixed(false);
  bundle.graph.AddEdge(std::make_shared<EdgeSE3Prior>(bundle.poses[2], Qd::Identity(), Vec3::Zero()));
  EXPECT_FALSE(optimizer.GaugeFreedom()) << "a prior of full dimension holds it too";
  Graph empty;
  EXPECT_FALSE(SparseOptimizer(&empty).GaugeFreedom());
  EXPECT_EQ(SparseOptimizer(&empty).FindGauge(), nullptr);
}

TEST(G2o, G15_AG2oFileIsOptimizedInThreeSteps) {
  const std::string path = testing::TempDir() + "three_steps.g2o";
  std::ofstream(path) << "VERTEX_SE3:QUAT 0 0 0 0 0 0 0 1\nVERTEX_SE3:QUAT 7 1.2 0.1 0 0 0 0.1 0.995\n"
                         "VERTEX_SE3:QUAT 3 2.1 -0.1 0.1 0 0.05 0 0.999\nFIX 0\n"
                         "EDGE_SE3:QUAT 0 7 1 0 0 0 0 0 1 9 0 0 0 0 0 9 0 0 0 0 9 0 0 0 9 0 0 9 0 9\n"
                         "EDGE_SE3:QUAT 7 3 1 0 0 0 0 0 1 9 0 0 0 0 0 9 0 0 0 0 9 0 0 0 9 0 0 9 0 9\n"
                         "EDGE_SE3:QUAT 0 3 2 0 0 0 0 0 1 9 0 0 0 0 0 9 0 0 0 0 9 0 0 0 9 0 0 9 0 9\n";
  for (const ReducedSolverType linear :
       {ReducedSolverType::kDenseCholesky, ReducedSolverType::kSparseCholesky, ReducedSolverType::kPcg}) {
    for (const Algorithm algorithm : {Algorithm::kGaussNewton, Algorithm::kLevenbergMarquardt, Algorithm::kDogleg}) {
      G2oFile file = ReadG2o(path);
      EXPECT_EQ(file.ids, (std::vector<int64_t>{0, 3, 7}));
      SparseOptimizer optimizer(&file.graph);
      optimizer.SetReducedSolver(linear);
      EXPECT_NE(dynamic_cast<SparseSolver*>(&optimizer.GetSolver()), nullptr);
      optimizer.SetAlgorithm(algorithm);
      ASSERT_TRUE(optimizer.InitializeOptimization());
      EXPECT_GT(optimizer.Optimize(20), 0);
      EXPECT_LT(optimizer.ActiveChi2(), 1e-6);
      EXPECT_LT((file.graph.Vertices()[2]->Parameters().head<3>() - Vec3(1, 0, 0)).norm(), 1e-3);
      EXPECT_LT((file.graph.Vertices()[1]->Parameters().head<3>() - Vec3(2, 0, 0)).norm(), 1e-3);
    }
  }
}

}  // namespace
}  // namespace ch5::test
