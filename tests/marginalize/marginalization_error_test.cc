#include "ch5_backend/marginalize/marginalization_error.h"
#include "ch5_backend/marginalize/marginalize.h"
#include "tests/marginalize/small_graphs.h"

namespace ch5 {
namespace {

MarginalizationError Accumulate(const SmallWindow& window, bool reversed = false) {
  auto edges = window.EdgesAt(window.Oldest());
  if (reversed) std::reverse(edges.begin(), edges.end());
  MarginalizationError error;
  for (const auto& edge : edges) error.AddResidualBlock(edge);
  return error;
}

// H and b in the order of ids, so that two accumulations can be compared.
MatXX InOrderOfIds(const MarginalizationError& error, const SmallWindow& window, VecX* b) {
  std::vector<int> rows;
  for (const auto& v : window.graph.Vertices()) {
    for (int k = 0; error.OrderingId(*v) >= 0 && k < v->LocalDimension(); ++k) rows.push_back(error.OrderingId(*v) + k);
  }
  *b = error.b0()(rows);
  return error.H()(rows, rows);
}

// OK1 and OK4:  JᵀJ = H,  Jᵀ(e₀ + JΔχ) = −(b₀ − HΔχ).
TEST(MarginalizationError, SquareRootFormReproducesHAndB) {
  const SmallWindow window;
  MarginalizationError error = Accumulate(window);
  error.MarginalizeOut(window.Oldest());
  error.UpdateErrorComputation();
  EXPECT_LT(RelativeError(error.J().transpose() * error.J(), error.H()), 1e-9);
  const VecX delta_chi = 0.01 * VecX::Random(error.H().rows());
  const VecX lhs = error.J().transpose() * error.Residual(delta_chi);
  const VecX rhs = -(error.b0() - error.H() * delta_chi);
  EXPECT_LT((lhs - rhs).norm(), 1e-9 * rhs.norm());
}

// OK2: states in awkward units (1 mm … 1 km) lose nothing, since H is scaled before every pseudo-inverse.
TEST(MarginalizationError, BadlyScaledStatesAreMarginalizedAsWell) {
  Random random(3);
  const double units[] = {1e-6, 1.0, 1e6};
  std::vector<std::shared_ptr<Vertex>> x;
  for (int k = 0; k < 3; ++k) x.push_back(std::make_shared<VertexScalar>(Eigen::Matrix<double, 1, 1>(0.0)));
  MarginalizationError error;
  const auto A = [&](int k) -> MatXX { return MatXX::Constant(1, 1, units[k]); };
  error.AddResidualBlock(std::make_shared<LinearEdge>(std::vector{x[0]}, std::vector{A(0)}, VecX::Ones(1)));
  error.AddResidualBlock(
      std::make_shared<LinearEdge>(std::vector{x[0], x[1]}, std::vector<MatXX>{A(0), -A(1)}, VecX::Constant(1, 0.5)));
  error.AddResidualBlock(
      std::make_shared<LinearEdge>(std::vector{x[1], x[2]}, std::vector<MatXX>{A(1), -A(2)}, VecX::Constant(1, 0.25)));
  error.MarginalizeOut({x[0], x[1]});
  // Chain of three unit differences: information 1/3 in units of x₂², at u₂x₂ = 1 − 0.5 − 0.25.
  ASSERT_EQ(error.H().rows(), 1);
  EXPECT_NEAR(error.H()(0, 0) / (units[2] * units[2]), 1.0 / 3.0, 1e-9);
  EXPECT_NEAR(error.b0()[0] / error.H()(0, 0) * units[2], 0.25, 1e-9);
}

// OK5: landmarks at the tail, everything else before them, whatever the order in which edges come.
TEST(MarginalizationError, KeepsLandmarksAtTheTail) {
  const SmallWindow window;
  for (const bool reversed : {false, true}) {
    const MarginalizationError error = Accumulate(window, reversed);
    int last_other = -1, first_landmark = static_cast<int>(error.H().rows());
    for (const auto& v : window.graph.Vertices()) {
      const int row = error.OrderingId(*v);
      if (v->GetRole() == Role::kLandmark && row >= 0) first_landmark = std::min(first_landmark, row);
      if (v->GetRole() != Role::kLandmark) last_other = std::max(last_other, row);
    }
    EXPECT_LT(last_other, first_landmark);
  }
}

// OK6: a block is linearized where it was first connected, also by residuals that come after it has moved.
TEST(MarginalizationError, FreezesTheLinearizationPointAtTheFirstConnection) {
  const SmallWindow window;
  const auto edges = window.EdgesAt(window.Oldest());
  MarginalizationError still, moved;
  for (const auto& edge : edges) still.AddResidualBlock(edge);
  for (size_t k = 0; k < edges.size(); ++k) {
    moved.AddResidualBlock(edges[k]);
    if (k == edges.size() / 2) {
      for (const auto& v : window.graph.Vertices()) {
        if (moved.OrderingId(*v) < 0) continue;
        const VecX delta = VecX::Constant(v->LocalDimension(), 1e-2);
        v->Plus(delta.data());
      }
    }
  }
  // Blocks that were connected only after the move differ; those before it do not: all poses are among them.
  const auto pose = window.poses[0];
  const int a = still.OrderingId(*pose), b = moved.OrderingId(*pose);
  EXPECT_LT(RelativeError(moved.H().block(b, b, 6, 6), still.H().block(a, a, 6, 6)), 1e-12);
  EXPECT_GT(moved.ComputeDeltaChi().norm(), 1e-2);
}

// OK8: landmarks one by one and then one dense block give the one-shot Schur complement, whatever the order of edges.
TEST(MarginalizationError, EqualsTheFunction) {
  for (const uint64_t seed : {1u, 5u}) {
    const SmallWindow window(seed);
    const MarginalSystem system = EliminateVertices(window.EdgesAt(window.Oldest()), window.Oldest());
    for (const bool reversed : {false, true}) {
      MarginalizationError error = Accumulate(window, reversed);
      error.MarginalizeOut(window.Oldest());
      VecX b;
      const MatXX H = InOrderOfIds(error, window, &b);
      EXPECT_LT(RelativeError(H, system.H), 1e-9) << seed << reversed;
      EXPECT_LT(RelativeError(b, system.b), 1e-9) << seed << reversed;
    }
  }
}

// OK10: a fixed vertex has no columns.
TEST(MarginalizationError, FixedVerticesHaveNoColumns) {
  const SmallWindow window;
  window.extrinsic->SetFixed();
  const MarginalizationError error = Accumulate(window);
  EXPECT_EQ(error.OrderingId(*window.extrinsic), -1);
  MarginalizationError free_error;
  window.extrinsic->SetFixed(false);
  free_error = Accumulate(window);
  EXPECT_EQ(free_error.H().rows(), error.H().rows() + 6);
}

TEST(MarginalizationError, PriorIsAnEdgeWithTheSameNormalEquations) {
  const SmallWindow window;
  MarginalizationError error = Accumulate(window);
  error.MarginalizeOut(window.Oldest());
  error.UpdateErrorComputation();
  EdgePrior edge(error.GetPrior());
  edge.ComputeResidual();
  edge.ComputeJacobians();
  EXPECT_LT((edge.Residual() - error.e0()).norm(), 1e-13);
  EXPECT_LT(error.ComputeDeltaChi().norm(), 1e-15);
  for (const auto& v : window.graph.Vertices()) {
    if (error.OrderingId(*v) < 0) continue;
    const VecX delta = VecX::Constant(v->LocalDimension(), 1e-3);
    v->Plus(delta.data());
  }
  edge.ComputeResidual();
  EXPECT_LT((edge.Residual() - error.Residual(error.ComputeDeltaChi())).norm(), 1e-12 * edge.Residual().norm());
}

TEST(MarginalizationError, CanBeMarginalizedAgain) {
  const SmallWindow window;
  MarginalizationError stepwise = Accumulate(window), at_once = Accumulate(window);
  const auto oldest = window.Oldest();
  for (const auto& v : oldest) stepwise.MarginalizeOut({v});
  at_once.MarginalizeOut(oldest);
  VecX b1, b2;
  const MatXX H1 = InOrderOfIds(stepwise, window, &b1), H2 = InOrderOfIds(at_once, window, &b2);
  EXPECT_LT(RelativeError(H1, H2), 1e-9);
  EXPECT_LT(RelativeError(b1, b2), 1e-9);
  EXPECT_THROW(at_once.MarginalizeOut({oldest[0]}), std::invalid_argument);
}

}  // namespace
}  // namespace ch5
