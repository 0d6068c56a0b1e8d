// Batches of edges: eight at a time give what each edge gives alone.
#include <gtest/gtest.h>

#include "ch5_backend/simulate/random.h"
#include "ch5_backend/sparse/sparse_solver.h"
#include "ch5_backend/sparse/steps/weighted_edge_batch.h"
#include "ch5_backend/types/bal/edge_bal.h"
#include "ch5_backend/types/visual/edge_stereo.h"
#include "tests/scenes.h"

namespace ch5::test {
namespace {

std::vector<std::shared_ptr<Edge>> BalEdges(int count, Random* random) {
  std::vector<std::shared_ptr<VertexCameraBAL>> cameras;
  for (int i = 0; i < 3; ++i) {
    Vec9 x;
    x << NormalVector(random, i == 0 ? 1e-9 : 0.8), NormalVector(random, 0.2), 500.0 + 10.0 * i, -0.05, 0.01;
    cameras.push_back(std::make_shared<VertexCameraBAL>(x));
  }
  std::vector<std::shared_ptr<Edge>> edges;
  for (int k = 0; k < count; ++k) {
    const Vec3 p_W = NormalVector(random, 1.0) - Vec3(0, 0, 6);
    edges.push_back(std::make_shared<EdgeBAL>(cameras[static_cast<size_t>(k % 3)],
                                              std::make_shared<VertexPointXYZ>(p_W), Vec2(10.0 * k, -5.0)));
  }
  return edges;
}

std::vector<std::shared_ptr<Edge>> ReprojectionEdges(int count, Random* random) {
  std::vector<std::shared_ptr<VertexPose>> poses;
  for (int i = 0; i < 3; ++i) {
    poses.push_back(std::make_shared<VertexPose>(ExpSO3(NormalVector(random, 0.2)), NormalVector(random, 0.3)));
  }
  const Transform left{ExpSO3(NormalVector(random, 0.1)), NormalVector(random, 0.1)};
  const Transform right{ExpSO3(NormalVector(random, 0.1)), NormalVector(random, 0.1)};
  std::vector<std::shared_ptr<Edge>> edges;
  for (int k = 0; k < count; ++k) {
    edges.push_back(std::make_shared<EdgeReprojection>(
        std::make_shared<VertexInverseDepth>(0.1 + 0.02 * k), poses[static_cast<size_t>(k % 3)],
        poses[static_cast<size_t>((k + 1 + k / 3 % 2) % 3)], Vec2(0.1 * random->Normal(), 0.1), Vec2(0.0, 0.2),
        k % 4 == 3 ? right : left));
  }
  return edges;
}

// Two rigs of two cameras each, whose clocks are late, and moving points: edges of the three kinds that know this.
class Rigs {
 public:
  explicit Rigs(Random* random) : random_(*random) {
    for (int i = 0; i < 3; ++i) poses_.push_back(Pose(0.2, 0.3));
    for (int i = 0; i < 4; ++i) cameras_.push_back(Pose(0.1, 0.1));
    for (const double offset : {0.01, -0.02})
      clocks_.push_back(std::make_shared<VertexScalar>(VertexScalar::Estimate(offset)));
  }
  void Fix() {
    for (const auto& camera : cameras_) camera->SetFixed();
    for (const auto& clock : clocks_) clock->SetFixed();
  }
  static std::shared_ptr<VertexInverseDepth> Depth(int k) {
    return std::make_shared<VertexInverseDepth>(0.1 + 0.02 * k);
  }
  std::shared_ptr<Edge> Calibration(int k, const std::shared_ptr<VertexInverseDepth>& depth) {
    return std::make_shared<EdgeReprojectionCalibration>(depth, Host(k), Target(k), cameras_[Rig(k)], clocks_[Rig(k)],
                                                         Point(), Point());
  }
  std::shared_ptr<Edge> Stereo(int k, const std::shared_ptr<VertexInverseDepth>& depth) {
    return std::make_shared<EdgeStereo>(depth, Host(k), Target(k), cameras_[Rig(k)], cameras_[2 + Rig(k)],
                                        clocks_[Rig(k)], Point(), Point());
  }
  std::shared_ptr<Edge> StereoHost(int k, const std::shared_ptr<VertexInverseDepth>& depth) {
    return std::make_shared<EdgeStereoHost>(depth, cameras_[Rig(k)], cameras_[2 + Rig(k)], clocks_[Rig(k)], Point(),
                                            Point());
  }
  std::shared_ptr<Edge> Plain(int k, const std::shared_ptr<VertexInverseDepth>& depth) {
    return std::make_shared<EdgeReprojection>(depth, Host(k), Target(k), Point().x, Point().x);
  }

 private:
  static size_t Rig(int k) { return k % 5 == 3 ? 1 : 0; }
  const std::shared_ptr<VertexPose>& Host(int k) const { return poses_[static_cast<size_t>(k % 3)]; }
  const std::shared_ptr<VertexPose>& Target(int k) const {
    return poses_[static_cast<size_t>((k + 1 + k / 3 % 2) % 3)];
  }
  std::shared_ptr<VertexPose> Pose(double rotation, double position) {
    return std::make_shared<VertexPose>(ExpSO3(NormalVector(&random_, rotation)), NormalVector(&random_, position));
  }
  MovingPoint Point() { return {NormalVector(&random_, 0.1).head<2>(), NormalVector(&random_, 0.3).head<2>(), 0.005}; }

  Random& random_;
  std::vector<std::shared_ptr<VertexPose>> poses_, cameras_;
  std::vector<std::shared_ptr<VertexScalar>> clocks_;
};

class NumericEdge : public SizedEdge<2, VertexVector<10>, VertexPointXYZ> {
 public:
  NumericEdge(std::shared_ptr<VertexVector<10>> a, std::shared_ptr<VertexPointXYZ> b)
      : SizedEdge(std::move(a), std::move(b)) {}
  void ComputeResidual() override {
    r_ = GetVertex<0>().GetEstimate().head<2>() + GetVertex<1>().GetEstimate().head<2>();
  }
  std::string TypeInfo() const override { return "NumericEdge"; }
};

// J of vertex v of the edge in a lane, from what the batch has given.
MatXX JacobianInPack(const Edge& edge, const double* J, int lane, const RelativeJacobian* A, bool relative, size_t v) {
  const auto columns = [&](int begin, int dim) {
    MatXX block(2, dim);
    for (int j = 0; j < 2 * dim; ++j) block.data()[j] = J[(2 * begin + j) * kPack + lane];
    return block;
  };
  if (relative && v > 0) {
    using Rows = Eigen::Matrix<double, RelativeJacobian::kDim, kPack, Eigen::RowMajor>;
    return columns(1, RelativeJacobian::kDim) * Eigen::Map<const Rows>(A[v].row[0]).leftCols<6>();
  }
  int begin = 0;
  for (size_t k = 0; k < v; ++k) begin += edge.Vertices()[k]->LocalDimension();
  return columns(begin, edge.Vertices()[v]->LocalDimension());
}

void ExpectBatchEqualsEdges(const std::vector<std::shared_ptr<Edge>>& edges) {
  const std::unique_ptr<EdgeBatch> batch = AsFast(*edges[0])->MakeBatch();
  ASSERT_TRUE(batch);
  for (const auto& edge : edges) batch->Add(*edge);
  batch->LoadPoses();
  const int total = static_cast<int>(edges.size());
  for (int first = 1, count; first < total; first += count) {  // packs need not begin at a multiple of their size
    alignas(64) double r[2 * kPack], r_alone[2 * kPack], J[64 * kPack];
    RelativeJacobian A[6];
    count = std::min(kPack, total - first);
    batch->ComputeResiduals(first, count, r_alone);
    if (batch->IsRelative()) count = batch->RelativeJacobians(first, count, A);
    batch->Linearize(first, count, r, J);
    for (int k = 0; k < count; ++k) {
      Edge& edge = *edges[static_cast<size_t>(first + k)];
      edge.Linearize();
      for (int i = 0; i < 2; ++i) {
        EXPECT_NEAR(r[i * kPack + k], edge.Residual()[i], 1e-12 * (1.0 + edge.Residual().norm()));
        EXPECT_NEAR(r_alone[i * kPack + k], edge.Residual()[i], 1e-12 * (1.0 + edge.Residual().norm()));
      }
      for (size_t v = 0; v < edge.Vertices().size(); ++v) {
        const MatXX expected = edge.Jacobian(v);
        if (batch->IsRelative() && v > 0 && expected.cols() != RelativeJacobian::kDim) continue;  // the clock is fixed
        const MatXX found = JacobianInPack(edge, J, k, A, batch->IsRelative(), v);
        EXPECT_LT((found - expected).norm(), 1e-12 * (1.0 + expected.norm())) << edge.TypeInfo() << " J_" << v;
      }
    }
  }
}

// Sorted by the poses, so that more than a pack's have the same; and cameras differ within a pack.
std::vector<std::shared_ptr<Edge>> SortedByPoses(std::vector<std::shared_ptr<Edge>> edges) {
  std::stable_sort(edges.begin(), edges.end(), [](const auto& a, const auto& b) {
    const auto poses = [](const Edge& edge) { return std::pair(edge.Vertices()[1], edge.Vertices()[2]); };
    return poses(*a) < poses(*b);
  });
  return edges;
}

TEST(EdgeBatches, AreTheEdgesEightAtATime) {
  Random random(5);
  ExpectBatchEqualsEdges(BalEdges(21, &random));
  ExpectBatchEqualsEdges(SortedByPoses(ReprojectionEdges(90, &random)));
  Rigs rigs(&random);
  std::vector<std::shared_ptr<Edge>> calibration, stereo, host;
  for (int k = 0; k < 90; ++k) {
    calibration.push_back(rigs.Calibration(k, Rigs::Depth(k)));
    stereo.push_back(rigs.Stereo(k, Rigs::Depth(k)));
    host.push_back(rigs.StereoHost(k, Rigs::Depth(k)));
  }
  for (const auto& edges : {calibration, stereo, host}) ExpectBatchEqualsEdges(SortedByPoses(edges));
}

void Fill(const std::vector<std::shared_ptr<Edge>>& edges, Graph* graph) {
  for (const auto& edge : edges) {
    for (const auto& vertex : edge->Vertices()) {
      if (vertex->Id() < 0) graph->AddVertex(vertex);
    }
    graph->AddEdge(edge);
  }
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
  // All kinds of weights and losses side by side.
  const std::shared_ptr<LossFunction> losses[] = {std::make_shared<CauchyLoss>(300.0),
                                                  std::make_shared<HuberLoss>(5.0)};
  for (size_t i = 0; i < graph.Edges().size(); i += 3) {
    graph.Edges()[i]->SetInformation((0.5 + 0.1 * static_cast<double>(i)) * Mat22::Identity());
    graph.Edges()[i]->SetLossFunction(losses[i % 2]);
  }
  solver.SetOrdering();
  EXPECT_NEAR(solver.Cost(), chi_by_edges(), 1e-12 * chi_by_edges());
  // One edge that cannot be packed, and all go one by one.
  solver.MakeHessian();
  const MatXX H = solver.DenseHessian();
  const VecX b = solver.RightHandSide();
  graph.Edges()[5]->SetInformation(Vec2(1.0, 1.0 + 1e-15).asDiagonal());
  solver.SetOrdering();
  LandmarkEdgeBatches batches;
  batches.Assign(solver.GetStructure());
  EXPECT_FALSE(batches.Active());
  solver.MakeHessian();
  EXPECT_LT((solver.DenseHessian() - H).norm(), 1e-13 * H.norm());
  EXPECT_LT((solver.RightHandSide() - b).norm(), 1e-13 * b.norm());
}

// Edges without a batch of their own go through the same lanes: see the scenes OwnCameras… in equality_test.cc.
TEST(EdgeBatches, TakeEdgesThatHaveNone) {
  const auto are_active = [](const Graph& graph) {
    LandmarkEdgeBatches batches;
    batches.Assign(BuildStructure(MakeOrdering(graph)));
    return batches.Active();
  };
  for (const int numbers : {5, 8, 9, 10, 13, 16}) {
    Graph graph;
    SceneNamed("OwnCameras" + std::to_string(numbers)).build(&graph);
    EXPECT_TRUE(are_active(graph)) << numbers;
  }
  // But not if their Jacobians are numeric, which would move vertices that another thread reads.
  Random random(9);
  Graph graph;
  const auto camera = std::make_shared<VertexVector<10>>(VertexVector<10>::Estimate::Ones());
  std::vector<std::shared_ptr<Edge>> edges;
  for (int k = 0; k < 9; ++k)
    edges.push_back(
        std::make_shared<NumericEdge>(camera, std::make_shared<VertexPointXYZ>(NormalVector(&random, 1.0))));
  Fill(edges, &graph);
  EXPECT_FALSE(are_active(graph));
}

// Landmarks with edges of three types, 1 to 5 of them, whose cameras are free or fixed.
TEST(EdgeBatches, OfSeveralTypesGiveTheSameSystemAsEdgesOneByOne) {
  for (const bool fixed : {false, true}) {
    Random random(8);
    Graph graph;
    Rigs rigs(&random);
    std::vector<std::shared_ptr<Edge>> edges;
    for (int k = 0; k < 50; ++k) {
      const auto depth = Rigs::Depth(k % 20);
      if (k % 2 == 0) edges.push_back(rigs.StereoHost(k, depth));
      if (k % 3 != 1) edges.push_back(rigs.Plain(k, depth));
      if (k % 4 != 2) edges.push_back(rigs.Stereo(k + 1, depth));
      edges.push_back(rigs.Plain(k + 4, depth));
      edges.push_back(rigs.Stereo(k, depth));
    }
    Fill(edges, &graph);
    if (fixed) rigs.Fix();
    for (const auto& vertex : graph.Vertices()) {
      if (dynamic_cast<VertexScalar*>(vertex.get())) vertex->SetFixed();
    }
    const auto loss = std::make_shared<CauchyLoss>(0.3);
    for (const auto& edge : edges) {
      edge->SetIsotropicInformation(edge->TypeInfo() == "EdgeStereo" ? 2.0 : 5.0);
      edge->SetLossFunction(loss);
    }
    SparseSolver packed(&graph), alone(&graph), two_threads(&graph, 2);
    for (SparseSolver* solver : {&packed, &two_threads}) {
      solver->SetOrdering();
      solver->MakeHessian();
    }
    LandmarkEdgeBatches batches;
    batches.Assign(packed.GetStructure());
    ASSERT_TRUE(batches.Active());
    EXPECT_GT(packed.GetStructure().runs.size(), 10u);
    const double cost = packed.Cost();
    EXPECT_NEAR(cost, Cost(graph), 1e-12 * cost);
    EXPECT_EQ(two_threads.Cost(), cost);
    EXPECT_EQ(two_threads.DenseHessian(), packed.DenseHessian());
    EXPECT_EQ(two_threads.RightHandSide(), packed.RightHandSide());
    const double w = graph.Edges()[5]->IsotropicInformation();
    graph.Edges()[5]->SetInformation(Vec2(w, w * (1.0 + 1e-15)).asDiagonal());
    alone.SetOrdering();
    batches.Assign(alone.GetStructure());
    ASSERT_FALSE(batches.Active());
    alone.MakeHessian();
    const MatXX H = alone.DenseHessian();
    EXPECT_LT((packed.DenseHessian() - H).norm(), 1e-12 * H.norm()) << "fixed: " << fixed;
    EXPECT_LT((packed.RightHandSide() - alone.RightHandSide()).norm(), 1e-12 * alone.RightHandSide().norm());
  }
}

}  // namespace
}  // namespace ch5::test
