#include "ch5_backend/marginalize/square_root.h"

#include "ch5_backend/marginalize/marginalize.h"
#include "tests/marginalize/small_graphs.h"

namespace ch5 {
namespace {

TEST(SquareRoot, PriorReproducesTheNormalEquations) {
  const SmallWindow window;
  const auto drop = window.Oldest();
  const MarginalSystem system = EliminateVertices(window.EdgesAt(drop), drop);
  for (const SquareRootForm& form :
       {FactorNormalEquations(system.H, system.b), FactorNormalEquations(system.H, system.b, EigenvalueCutoff::Okvis()),
        FactorNormalEquations(system.H, system.b, EigenvalueCutoff::Vins())}) {
    // Directions that rounding decides about, kept or cut, are as large as this.
    EXPECT_LT(RelativeError(form.J.transpose() * form.J, system.H), 1e-8);
    // b lies in the range of H up to what the cut removed.
    EXPECT_LT((form.J.transpose() * form.r0 + system.b).norm(), 1e-6 * system.b.norm());
  }
}

// H of rank 3 in states whose units differ by 1e6: as many rows, and b, which lies in H's range, is kept.
TEST(SquareRoot, BothFactorizationsFindTheRank) {
  Random random(11);
  MatXX B(3, 5);
  for (int k = 0; k < B.size(); ++k) B.data()[k] = random.Normal() * std::pow(10.0, k / 3 * 3 - 6);
  const MatXX H = B.transpose() * B;
  const VecX b = B.transpose() * Vec3(1.0, -2.0, 0.5);
  const SquareRootForm triangle = FactorNormalEquations(H, b);
  const SquareRootForm eigen = FactorNormalEquations(H, b, EigenvalueCutoff::Okvis());
  EXPECT_EQ(triangle.J.rows(), 3);
  EXPECT_EQ(eigen.J.rows(), 3);
  for (const SquareRootForm& form : {triangle, eigen}) {
    EXPECT_LT(RelativeError(form.J.transpose() * form.J, H), 1e-13);
    EXPECT_LT(RelativeError(form.J.transpose() * form.r0, -b), 1e-9);
    EXPECT_NEAR(form.r0.norm(), Vec3(1.0, -2.0, 0.5).norm(), 1e-6);
  }
  EXPECT_EQ(FactorNormalEquations(MatXX(0, 0), VecX(0)).J.size(), 0);
  EXPECT_EQ(FactorNormalEquations(MatXX::Zero(2, 2), VecX::Zero(2)).J.rows(), 0);
}

// The factor is computed panel by panel; pivots and rank take no notice.
TEST(SquareRoot, ARankOfSeveralPanelsIsFound) {
  Random random(5);
  MatXX B(30, 40);
  for (int k = 0; k < B.size(); ++k) B.data()[k] = random.Normal();
  const VecX r0 = VecX::LinSpaced(30, -1.0, 1.0);
  const SquareRootForm form = FactorNormalEquations(B.transpose() * B, -B.transpose() * r0);
  EXPECT_EQ(form.J.rows(), 30);
  EXPECT_LT(RelativeError(form.J.transpose() * form.J, B.transpose() * B), 1e-13);
  EXPECT_LT((form.J.transpose() * form.r0 - B.transpose() * r0).norm(), 1e-11);
}

// By hand: of A = diag(4, 0) only the first eigenvalue is above the cutoff.
TEST(SquareRoot, PseudoInverseRootOfASingularMatrixByHand) {
  const MatXX A = Vec2(4.0, 0.0).asDiagonal(), expected = Vec2(0.25, 0.0).asDiagonal();
  const MatXX M = PseudoInverseSquareRoot(A);
  EXPECT_LT((M * M.transpose() - expected).norm(), 1e-15);
  EXPECT_EQ(PseudoInverseSquareRoot(MatXX::Constant(1, 1, 4.0))(0, 0), 0.5);
  EXPECT_EQ(PseudoInverseSquareRoot(MatXX::Zero(1, 1))(0, 0), 0.0);
}

}  // namespace
}  // namespace ch5
