#include "ch5_backend/marginalize/edge_prior.h"

#include "ch5_backend/marginalize/marginalize.h"
#include "ch5_backend/marginalize/scoped_linearization_point.h"
#include "tests/marginalize/small_graphs.h"

namespace ch5 {
namespace {

// Bᵀ(JᵀJ)B from one product and (JB)ᵀ(JB) from the Jacobians are the same, wherever the states have gone.
TEST(EdgePrior, ProductsAreThoseOfItsJacobians) {
  SmallWindow window;
  const auto drop = window.Oldest();
  EdgePrior prior(Marginalize(window.EdgesAt(drop), drop));
  for (const double step : {0.0, 0.03, 0.3}) {
    int size = 1;
    for (const auto& vertex : prior.Vertices()) {
      vertex->Plus(VecX::LinSpaced(vertex->LocalDimension(), -step, step).eval().data());
      size += vertex->LocalDimension();
    }
    MatXX C(size, size), rows(prior.ResidualDimension(), size);
    ASSERT_TRUE(prior.NegativeProductsInto(C.data()));
    prior.Linearize();
    size = 0;
    for (size_t i = 0; i < prior.Vertices().size(); ++i) {
      const auto J = prior.Jacobian(i);
      rows.middleCols(size, J.cols()) = J;
      size += static_cast<int>(J.cols());
    }
    rows.rightCols<1>() = prior.Residual();
    const MatXX expected = -rows.transpose() * rows;
    EXPECT_LT(RelativeError(MatXX(C.selfadjointView<Eigen::Lower>()), expected), 1e-14) << step;
  }
  prior.SetLossFunction(std::make_shared<HuberLoss>(1.0));
  EXPECT_FALSE(prior.NegativeProductsInto(nullptr));
}

// By hand:  r = r₀ + J (x − x₀) on a scalar, and the Jacobian is J.
TEST(EdgePrior, IsLinearInTheDifferenceFromItsLinearizationPoint) {
  auto x = std::make_shared<VertexScalar>(VertexScalar::Estimate(5.0));
  EdgePrior edge(Prior{{x}, {VecX::Constant(1, 3.0)}, MatXX::Constant(1, 1, 10.0), VecX::Constant(1, 0.5)});
  edge.Linearize();
  EXPECT_EQ(edge.Residual()[0], 20.5);
  EXPECT_EQ(edge.Jacobian(0)(0, 0), 10.0);
}

// Away from x₀ the Jacobian of a rotation changes with ⊟; a first-estimate Jacobian does not.
TEST(EdgePrior, KeepsItsJacobianWhenAskedTo) {
  auto pose = std::make_shared<VertexPose>();
  const MatXX J = MatXX::Identity(6, 6);
  EdgePrior edge(Prior{{pose}, {pose->Parameters()}, J, VecX::Zero(6)});
  pose->SetPose(ExpSO3({0.5, -0.3, 0.2}), Vec3(1, 2, 3));
  edge.Linearize();
  EXPECT_GT((edge.Jacobian(0) - J.leftCols(6)).norm(), 0.1);
  edge.KeepJacobian(true);
  edge.Linearize();
  EXPECT_EQ(MatXX(edge.Jacobian(0)), J);
}

TEST(EdgePrior, RefusesPartsThatDoNotFitTogether) {
  auto x = std::make_shared<VertexScalar>(VertexScalar::Estimate(0.0));
  const VecX one = VecX::Zero(1);
  EXPECT_THROW(EdgePrior(Prior{{x}, {}, MatXX::Identity(1, 1), one}), std::invalid_argument);
  EXPECT_THROW(EdgePrior(Prior{{x}, {VecX::Zero(2)}, MatXX::Identity(1, 1), one}), std::invalid_argument);
  EXPECT_THROW(EdgePrior(Prior{{x}, {one}, MatXX::Identity(1, 2), one}), std::invalid_argument);
}

TEST(ScopedLinearizationPoint, VerticesReturnToTheBitAlsoWhenMovedTwice) {
  auto pose = std::make_shared<VertexPose>(ExpSO3({0.3, 0.2, 0.1}), Vec3(0.1, 0.2, 0.3));
  const VecX before = pose->Parameters(), there = VertexPose().Parameters();
  {
    ScopedLinearizationPoint scope;
    scope.Move(pose.get(), there);
    EXPECT_EQ(pose->Parameters(), there);
    scope.Move(pose.get(), before + VecX::Ones(7));
  }
  EXPECT_EQ(pose->Parameters(), before);
}

}  // namespace
}  // namespace ch5
