// G11: true marginal covariances of poses and landmarks, by selected inversion, against the dense inverse.
#include <gtest/gtest.h>

#include <Eigen/LU>
#include <algorithm>

#include "ch5_backend/linear/elimination_plan.h"
#include "ch5_backend/simulate/mono_ba.h"
#include "ch5_backend/sparse/joint_covariance.h"
#include "ch5_backend/sparse/sparse_optimizer.h"
#include "ch5_backend/sparse/sparse_solver.h"
#include "ch5_backend/types/edge_se3_prior.h"
#include "tests/g2o/bundle.h"
#include "tests/g2o/point_chain.h"
#include "tests/graph_error.h"

namespace ch5::test {
namespace {

constexpr CovarianceFactor kFactors[] = {CovarianceFactor::kSparse, CovarianceFactor::kDense};

// All blocks, pose with pose, pose with landmark and landmark with landmark, together against H⁻¹: the last row first, so that
// each block has to find its place.
void ExpectInverse(Graph* graph) {
  SparseSolver solver(graph);
  solver.SetOrdering();
  solver.MakeHessian();
  std::vector<std::shared_ptr<Vertex>> vertices;
  for (const auto& vertex : graph->Vertices()) {
    if (vertex->OrderingId() >= 0) vertices.push_back(vertex);
  }
  std::sort(vertices.begin(), vertices.end(),
            [](const auto& a, const auto& b) { return a->OrderingId() > b->OrderingId(); });
  std::vector<int> rows;
  for (const auto& vertex : vertices) {
    for (int k = 0; k < vertex->LocalDimension(); ++k) rows.push_back(vertex->OrderingId() + k);
  }
  const MatXX inverse = solver.DenseHessian().inverse();
  for (const CovarianceFactor factor : kFactors) {
    Covariance covariance(graph, {}, factor);
    EXPECT_LT((JointCovariance(vertices, &covariance) - inverse(rows, rows)).norm(), 1e-8 * inverse.norm());
  }
}

TEST(G2o, G11_MarginalsOfPosesAndPointsEqualTheDenseInverse) {
  Bundle bundle(10, 60);  // poses far apart share no landmark: S is sparse, and such blocks need a solve
  ExpectInverse(&bundle.graph);
}

TEST(G2o, G11_MarginalsOfInverseDepthsEqualTheDenseInverse) {
  MonoBa scene = BuildMonoBa(SimulateMonoBa({}), Gauge::kPriorTwoFrames, 1e4, 1e4);
  ExpectInverse(&scene.graph);
}

TEST(G2o, G11_MarginalsOfAChainAddUpAlongIt) {
  PointChain chain(30);
  chain.points[0]->SetFixed();
  ExpectInverse(&chain.graph);
  Covariance covariance(&chain.graph);
  for (int i = 1; i < 30; ++i) {  // a random walk with unit steps
    EXPECT_LT((covariance.Block(*chain.points[i], *chain.points[i]) - i * Mat33::Identity()).norm(), 1e-9 * i);
    EXPECT_LT((covariance.Block(*chain.points[i], *chain.points[29]) - i * Mat33::Identity()).norm(), 1e-9 * i);
  }
}

TEST(G2o, G11_MarginalsOfAGridOfManyFrontsEqualTheDenseInverse) {
  constexpr int kSide = 9;
  Graph graph;
  std::vector<std::shared_ptr<VertexPointXYZ>> points;
  Random random(24);
  for (int i = 0; i < kSide * kSide; ++i) {
    const int row = i / kSide, column = i % kSide;
    points.push_back(std::make_shared<VertexPointXYZ>(Vec3(column, row, 0)));
    points.back()->SetRole(Role::kPose);
    graph.AddVertex(points.back());
    for (const int neighbor : {column > 0 ? i - 1 : -1, i - kSide}) {
      if (neighbor < 0) continue;
      auto edge = std::make_shared<PointDifference>(points[neighbor], points[i], Vec3(1, 0, 0));
      edge->SetInformation(random.Uniform(0.5, 2.0) * MatXX::Identity(3, 3));
      graph.AddEdge(edge);
    }
  }
  points[40]->SetFixed();
  Covariance covariance(&graph);
  SparseSolver solver(&graph);
  solver.SetOrdering();
  EXPECT_GT(PlanElimination(solver.GetEliminated().S).fronts.size(), 5u) << "or it shows little";
  ExpectInverse(&graph);
}

// A x − c, linear, over blocks of 2, 3 and 1 numbers.
class LinearEdge : public SizedEdge<8, VertexVector<2>, VertexVector<3>, VertexVector<1>> {
 public:
  using SizedEdge::SizedEdge;
  LinearEdge(std::shared_ptr<VertexVector<2>> x, std::shared_ptr<VertexVector<3>> y, std::shared_ptr<VertexVector<1>> z)
      : SizedEdge(std::move(x), std::move(y), std::move(z)) {}
  void ComputeResidual() override {
    Eigen::Matrix<double, 8, 6> A = Eigen::Matrix<double, 8, 6>::Zero();
    A.topRows<6>().diagonal() << 1, 1, 2, 2, 2, 5;
    A.row(6) << -5, -6, 1, 2, 3, 0;
    A.row(7) << 3, -2, 0, 0, 0, 2;
    Vec6 x;
    x << GetVertex<0>().GetEstimate(), GetVertex<1>().GetEstimate(), GetVertex<2>().GetEstimate();
    r_ = A * x;
  }
  std::string TypeInfo() const override { return "LinearEdge"; }
};

TEST(G2o, G11_NumbersOfAPublishedExample) {
  for (const Role role : {Role::kPose, Role::kLandmark}) {
    Graph graph;
    const auto x = std::make_shared<VertexVector<2>>(Vec2::Zero());
    const auto y = std::make_shared<VertexVector<3>>(Vec3::Zero());
    const auto z = std::make_shared<VertexVector<1>>(Eigen::Matrix<double, 1, 1>::Zero());
    y->SetRole(role);
    for (const std::shared_ptr<Vertex>& vertex : std::vector<std::shared_ptr<Vertex>>{x, y, z}) graph.AddVertex(vertex);
    graph.AddEdge(std::make_shared<LinearEdge>(x, y, z));
    for (const CovarianceFactor factor : kFactors) {
      Covariance covariance(&graph, {}, factor);
      EXPECT_NEAR(covariance.Block(*x, *x)(0, 0), 7.0747e-2, 1e-5);
      EXPECT_NEAR(covariance.Block(*z, *z)(0, 0), 3.9544e-2, 1e-5);
      EXPECT_LT((covariance.Block(*x, *y) - covariance.Block(*y, *x).transpose()).norm(), 1e-14);
    }
  }
}

TEST(G2o, G11_TheMarginalIsWiderThanTheConditional) {
  Bundle bundle(6, 60);
  SparseSolver solver(&bundle.graph);
  solver.SetOrdering();
  solver.MakeHessian();
  const MatXX H_pp = solver.DenseHessian().topLeftCorner(24, 24);
  const MatXX conditional = H_pp.inverse().block(6, 6, 6, 6);  // as if the landmarks were known
  const MatXX marginal = SparseOptimizer(&bundle.graph).ComputeMarginals({{bundle.poses[3], bundle.poses[3]}})[0];
  for (int i = 0; i < 6; ++i) EXPECT_GT(marginal(i, i), 1.5 * conditional(i, i));
}

TEST(G2o, G11_ASingularSystemIsANamedError) {
  Bundle bundle(6, 40);
  const auto lonely = std::make_shared<VertexPointXYZ>(Vec3(0.3, 0.2, 5.0));
  bundle.graph.AddVertex(lonely);
  const auto sight = std::make_shared<EdgeReprojectionXYZ>(lonely, bundle.poses[3], Vec2(0.01, 0.02));
  bundle.graph.AddEdge(sight);
  for (const CovarianceFactor factor : kFactors) {
    ExpectError<CovarianceError>([&] { Covariance(&bundle.graph, {}, factor); }, "do not determine VertexPointXYZ 46");
  }
  bundle.graph.RemoveEdge(sight);
  Covariance covariance(&bundle.graph);
  ExpectError<CovarianceError>([&] { covariance.Block(*lonely, *bundle.poses[3]); }, "VertexPointXYZ 46 takes no part");
  ExpectError<CovarianceError>([&] { covariance.Block(*bundle.poses[3], *bundle.poses[0]); }, "VertexPose 0 is fixed");
  ExpectError<CovarianceError>([&] { covariance.Blocks({{bundle.poses[3], nullptr}}); }, "missing (null)");

  PointChain chain(5);  // nothing holds its place
  for (const CovarianceFactor factor : kFactors) {
    ExpectError<CovarianceError>([&] { Covariance(&chain.graph, {}, factor); }, "is a gauge free?");
  }
}

TEST(G2o, G11_LandmarksAloneNeedNoS) {
  Bundle bundle(5, 20);
  for (const auto& pose : bundle.poses) pose->SetFixed();
  ExpectInverse(&bundle.graph);
  for (const auto& point : bundle.points) point->SetFixed();
  for (const CovarianceFactor factor : kFactors) {
    Covariance nothing(&bundle.graph, {}, factor);
    ExpectError<CovarianceError>([&] { nothing.Block(*bundle.points[0], *bundle.points[0]); },
                                 "VertexPointXYZ 5 is fixed");
  }
}

TEST(G2o, G11_ThreadsGiveTheSameBits) {
  Bundle bundle(10, 60);
  Covariance one(&bundle.graph), two(&bundle.graph, {}, CovarianceFactor::kSparse, 2);
  for (const auto& point : bundle.points) {
    EXPECT_EQ(one.Block(*point, *bundle.poses[5]), two.Block(*point, *bundle.poses[5]));
  }
}

}  // namespace
}  // namespace ch5::test
