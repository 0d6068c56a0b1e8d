#include "ch5_backend/consistency/observability.h"

#include <Eigen/LU>

#include "tests/consistency/free_windows.h"

namespace ch5 {
namespace {

constexpr double kRounding = 1e-12;

// Two pieces of code, for any states and for the present ones; they agree on a window at a random state.
TEST(Observability, DirectionsAtThePresentStatesAreThoseOfTheGauge) {
  const FreeWindow window;
  std::vector<std::shared_ptr<Vertex>> vertices(window.poses.begin(), window.poses.end());
  vertices.insert(vertices.end(), window.speed_biases.begin(), window.speed_biases.end());
  vertices.insert(vertices.end(), {window.extrinsic, window.landmarks[0]});
  std::vector<const double*> x;
  for (const auto& vertex : vertices) x.push_back(vertex->Parameters().data());
  Vec3 center = Vec3::Zero();
  for (const auto& pose : window.poses) center += pose->p() / 4.0;
  const MatXX N = PositionYawDirections(vertices, x, {window.extrinsic.get()}, center);
  const MatXX of_gauge = GaugeDirections(vertices, window.options);
  ASSERT_EQ(N.rows(), of_gauge.rows());
  EXPECT_LT((N - of_gauge).cwiseAbs().maxCoeff(), kRounding);
  EXPECT_GT(N.col(3).norm(), 1.0);
}

// A window whose states have moved since the prior was made.
struct MovedWindow : FreeWindow {
  MovedWindow() {
    const auto drop = Oldest();
    prior = Marginalize(EdgesAt(drop), drop);
    for (const auto& pose : poses) {
      const Vec6 delta = 0.05 * (Vec6() << 1, -2, 1, 2, 1, -1).finished();
      pose->Plus(delta.data());
    }
  }
  // Of the graph's IMU edge between frames 1 and 2, of which the prior holds the first.
  std::shared_ptr<Edge> ImuEdge() const { return graph.Edges()[1]; }
  // N₀: the directions at the first estimates.
  MatXX FirstDirections(const Edge& edge) const {
    ScopedLinearizationPoint at_first;
    for (size_t i = 0; i < prior.vertices.size(); ++i) at_first.Move(prior.vertices[i].get(), prior.x0[i]);
    return GaugeDirections(edge.Vertices(), options);
  }
  Prior prior;
};

MatXX JacobianOf(Edge* edge) {
  edge->Linearize();
  MatXX J(edge->ResidualDimension(), 0);
  for (size_t i = 0; i < edge->Vertices().size(); ++i) {
    MatXX wider(J.rows(), J.cols() + edge->Jacobian(i).cols());
    wider << J, edge->Jacobian(i);
    J = wider;
  }
  return J;
}

// J'N₀ = 0, while J N₀ is not: an edge linearized elsewhere has information on the prior's yaw.
TEST(Observability, ConstrainedJacobiansKeepTheFirstNullSpace) {
  const MovedWindow window;
  for (const auto& edge : {window.ImuEdge(), window.graph.Edges().back()}) {
    const auto constrained = ConstrainObservability(edge, window.prior, {window.extrinsic.get()});
    ASSERT_NE(constrained, edge);
    const MatXX N0 = window.FirstDirections(*edge), J = JacobianOf(edge.get()), J_new = JacobianOf(constrained.get());
    EXPECT_GT((J * N0).norm(), 1e-4 * J.norm()) << edge->TypeInfo();
    EXPECT_LT((J_new * N0).norm(), kRounding * J.norm()) << edge->TypeInfo();
    EXPECT_LT((J_new - J).norm(), 0.2 * J.norm()) << edge->TypeInfo();
    EXPECT_EQ(VecX(constrained->Residual()), VecX(edge->Residual()));
  }
}

// The least change: any other J + X with (J + X)N₀ = 0 differs from J by more.
TEST(Observability, TheCorrectionIsTheLeastOne) {
  const MovedWindow window;
  const auto edge = window.ImuEdge();
  const auto constrained = ConstrainObservability(edge, window.prior, {window.extrinsic.get()});
  const MatXX N0 = window.FirstDirections(*edge);
  const MatXX correction = JacobianOf(constrained.get()) - JacobianOf(edge.get());
  // Its rows lie in the span of N₀, which is orthogonal to all changes that keep J'N₀.
  const MatXX projector = N0 * (N0.transpose() * N0).inverse() * N0.transpose();
  EXPECT_LT((correction - correction * projector).norm(), 1e-6 * correction.norm());
}

TEST(Observability, AnEdgeWithoutStatesOfThePriorStaysItself) {
  const MovedWindow window;
  Prior elsewhere;
  EXPECT_EQ(ConstrainObservability(window.ImuEdge(), elsewhere, {}), window.ImuEdge());
}

// The loss belongs to the other edge, which lives as long as the constrained one.
TEST(Observability, ConstrainedEdgesKeepResidualInformationAndLossOfTheOther) {
  const MovedWindow window;
  std::shared_ptr<Edge> edge = window.graph.Edges().back();
  ASSERT_TRUE(edge->GetLossFunction());
  const auto constrained = ConstrainObservability(edge, window.prior, {window.extrinsic.get()});
  edge->ComputeResidual();
  constrained->ComputeResidual();
  EXPECT_EQ(VecX(constrained->Residual()), VecX(edge->Residual()));
  EXPECT_EQ(MatXX(constrained->Information()), MatXX(edge->Information()));
  EXPECT_EQ(constrained->TypeInfo(), edge->TypeInfo());
  EXPECT_EQ(constrained->Cost(), edge->Cost());
  auto speed_bias = std::make_shared<VertexSpeedBias>();
  auto own = std::make_shared<LinearEdge>(std::vector<std::shared_ptr<Vertex>>{speed_bias},
                                          std::vector<MatXX>{MatXX::Ones(1, 9)}, VecX::Constant(1, 3.0));
  own->SetLossFunction(std::make_shared<HuberLoss>(1.0));
  const Prior prior{{speed_bias}, {VecX::Zero(9)}, MatXX::Identity(9, 9), VecX::Zero(9)};
  const auto last = ConstrainObservability(std::move(own), prior, {});
  last->ComputeResidual();
  EXPECT_NEAR(last->Cost(), 0.5 * (2.0 * 3.0 - 1.0), 1e-12);  // 2δ√s − δ²
}

}  // namespace
}  // namespace ch5
