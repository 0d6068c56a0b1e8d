// Batches of edges: eight at a time give what each edge gives alone.
#include <gtest/gtest.h>

#include "ch5_backend/graph/whitening.h"
#include "ch5_backend/simulate/random.h"
#include "ch5_backend/sparse/sparse_optimizer.h"
#include "ch5_backend/sparse/sparse_solver.h"
#include "ch5_backend/sparse/steps/weighted_edge_batch.h"
#include "ch5_backend/types/bal/edge_bal.h"
#include "ch5_backend/types/visual/edge_reprojection.h"

namespace ch5::test {
namespace {

Vec3 RandomVec3(Random* random, double sigma) {
  return sigma * Vec3(random->Normal(), random->Normal(), random->Normal());
}

std::vector<std::shared_ptr<Edge>> BalEdges(int count, Random* random) {
  std::vector<std::shared_ptr<VertexCameraBAL>> cameras;
  for (int i = 0; i < 3; ++i) {
    Vec9 x;
    x << RandomVec3(random, i == 0 ? 1e-9 : 0.8), RandomVec3(random, 0.2), 500.0 + 10.0 * i, -0.05, 0.01;
    cameras.push_back(std::make_shared<VertexCameraBAL>(x));
  }
  std::vector<std::shared_ptr<Edge>> edges;
  for (int k = 0; k < count; ++k) {
    const Vec3 p_W = RandomVec3(random, 1.0) - Vec3(0, 0, 6);
    edges.push_back(std::make_shared<EdgeBAL>(cameras[static_cast<size_t>(k % 3)],
                                              std::make_shared<VertexPointXYZ>(p_W), Vec2(10.0 * k, -5.0)));
  }
  return edges;
}

std::vector<std::shared_ptr<Edge>> ReprojectionEdges(int count, Random* random) {
  std::vector<std::shared_ptr<VertexPose>> poses;
  for (int i = 0; i < 3; ++i) {
    poses.push_back(std::make_shared<VertexPose>(ExpSO3(RandomVec3(random, 0.2)), RandomVec3(random, 0.3)));
  }
  const Transform left{ExpSO3(RandomVec3(random, 0.1)), RandomVec3(random, 0.1)};
  const Transform right{ExpSO3(RandomVec3(random, 0.1)), RandomVec3(random, 0.1)};
  std::vector<std::shared_ptr<Edge>> edges;
  for (int k = 0; k < count; ++k) {
    edges.push_back(std::make_shared<EdgeReprojection>(
        std::make_shared<VertexInverseDepth>(0.1 + 0.02 * k), poses[static_cast<size_t>(k % 3)],
        poses[static_cast<size_t>((k + 1 + k / 3 % 2) % 3)], Vec2(0.1 * random->Normal(), 0.1), Vec2(0.0, 0.2),
        k % 4 == 3 ? right : left));
  }
  return edges;
}

void ExpectBatchEqualsEdges(const std::vector<std::shared_ptr<Edge>>& edges) {
  const std::unique_ptr<EdgeBatch> batch = AsFast(*edges[0])->MakeBatch();
  ASSERT_TRUE(batch);
  for (const auto& edge : edges) batch->Add(*edge);
  batch->LoadPoses();
  const int total = static_cast<int>(edges.size());
  for (int first = 1; first < total; first += kPack) {  // packs need not begin at a multiple of their size
    const int count = std::min(kPack, total - first);
    alignas(64) double r[2 * kPack], r_alone[2 * kPack], J[64 * kPack];
    batch->Linearize(first, count, r, J);
    batch->ComputeResiduals(first, count, r_alone);
    for (int k = 0; k < count; ++k) {
      Edge& edge = *edges[static_cast<size_t>(first + k)];
      edge.Linearize();
      const double* next = J + k;
      for (int i = 0; i < 2; ++i) {
        EXPECT_NEAR(r[i * kPack + k], edge.Residual()[i], 1e-12 * (1.0 + edge.Residual().norm()));
        EXPECT_NEAR(r_alone[i * kPack + k], edge.Residual()[i], 1e-12 * (1.0 + edge.Residual().norm()));
      }
      for (size_t v = 0; v < edge.Vertices().size(); ++v) {
        const auto expected = edge.Jacobian(v);
        for (int j = 0; j < expected.size(); ++j, next += kPack) {
          EXPECT_NEAR(*next, expected.data()[j], 1e-12 * (1.0 + expected.norm())) << edge.TypeInfo() << " J_" << v;
        }
      }
    }
  }
}

TEST(EdgeBatches, AreTheEdgesEightAtATime) {
  Random random(5);
  ExpectBatchEqualsEdges(BalEdges(21, &random));
  ExpectBatchEqualsEdges(ReprojectionEdges(21, &random));
}

void Fill(const std::vector<std::shared_ptr<Edge>>& edges, Graph* graph) {
  for (const auto& edge : edges) {
    for (const auto& vertex : edge->Vertices()) {
      if (vertex->Id() < 0) graph->AddVertex(vertex);
    }
    graph->AddEdge(edge);
  }
}

// r̃ and J̃ = M J of each edge alone, with all kinds of weights and losses side by side.
TEST(WeightedEdgeBatch, WhitensAsEachEdgeAlone) {
  Random random(7);
  Graph graph;
  Fill(BalEdges(21, &random), &graph);
  const std::shared_ptr<LossFunction> losses[] = {nullptr, std::make_shared<CauchyLoss>(30.0),
                                                  std::make_shared<HuberLoss>(5.0)};
  for (size_t k = 0; k < graph.Edges().size(); ++k) {
    graph.Edges()[k]->SetInformation((1.0 + 0.1 * static_cast<double>(k)) * Mat22::Identity());
    graph.Edges()[k]->SetLossFunction(losses[k % 3]);
  }
  const Structure structure = BuildStructure(MakeOrdering(graph));
  WeightedEdgeBatch batch;
  batch.Assign(structure);
  ASSERT_TRUE(batch.Active());
  ASSERT_EQ(batch.NumPositions(), 2);
  EXPECT_EQ(batch.Dimension(0), 9);
  batch.LoadPoses();
  double chi2 = 0.0;
  for (int first = 0; first < structure.num_landmark_edges; first += kPack) {
    const int count = std::min(kPack, structure.num_landmark_edges - first);
    alignas(64) double r[2 * kPack], J[64 * kPack];
    batch.Linearize(first, count, r, J);
    batch.Whiten(first, count, r, J);
    for (int k = 0; k < count; ++k) {
      Edge& edge = *structure.edges[static_cast<size_t>(first + k)].edge;
      edge.Linearize();
      chi2 += edge.Cost();
      const TwoRowWhitening white(edge.IsotropicInformation(), edge.GetLossFunction(), edge.Residual().data());
      const Eigen::Map<const Mat22> M(&white.M[0][0]);
      for (int i = 0; i < 2; ++i) EXPECT_NEAR(r[i * kPack + k], white.r[i], 1e-12 * (1.0 + std::abs(white.r[i])));
      for (int v = 0; v < 2; ++v) {
        const MatXX expected = M * edge.Jacobian(static_cast<size_t>(v));
        for (int j = 0; j < expected.size(); ++j) {
          EXPECT_NEAR(J[(batch.JacobianBegin(v) + j) * kPack + k], expected.data()[j], 1e-11 * (1.0 + expected.norm()));
        }
      }
    }
  }
  EXPECT_NEAR(batch.Cost(0, structure.num_landmark_edges), chi2, 1e-12 * chi2);
}

TEST(EdgeBatches, FollowTheStatesAndTheWeights) {
  Random random(6);
  Graph graph;
  Fill(BalEdges(40, &random), &graph);
  SparseSolver solver(&graph);
  solver.SetOrdering();
  const auto chi_by_edges = [&] { return Cost(graph); };
  EXPECT_NEAR(solver.Cost(), chi_by_edges(), 1e-12 * chi_by_edges());
  graph.Vertices()[1]->Plus(Vec3(0.1, 0.2, 0.3).data());
  EXPECT_NEAR(solver.Cost(), chi_by_edges(), 1e-12 * chi_by_edges());
  for (size_t i = 0; i < graph.Edges().size(); i += 3) {
    graph.Edges()[i]->SetInformation(0.5 * Mat22::Identity());
    graph.Edges()[i]->SetLossFunction(std::make_shared<CauchyLoss>(3.0));
  }
  solver.SetOrdering();
  EXPECT_NEAR(solver.Cost(), chi_by_edges(), 1e-12 * chi_by_edges());
  // One edge that cannot be packed, and all go one by one.
  solver.MakeHessian();
  const MatXX H = solver.DenseHessian();
  const VecX b = solver.RightHandSide();
  graph.Edges()[5]->SetInformation(Vec2(1.0, 1.0 + 1e-15).asDiagonal());
  solver.SetOrdering();
  WeightedEdgeBatch batch;
  batch.Assign(solver.GetStructure());
  EXPECT_FALSE(batch.Active());
  solver.MakeHessian();
  EXPECT_LT((solver.DenseHessian() - H).norm(), 1e-13 * H.norm());
  EXPECT_LT((solver.RightHandSide() - b).norm(), 1e-13 * b.norm());
}

}  // namespace
}  // namespace ch5::test
