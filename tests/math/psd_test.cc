/// Positive semi-definite matrices: what is refused and in which words, and the pseudo-inverse.
#include "ch5_backend/math/psd.h"

#include <gtest/gtest.h>

#include <limits>

#include "ch5_backend/simulate/random.h"

namespace ch5 {
namespace {

MatXX NormalMatrix(int rows, int cols, Random* random) {
  return MatXX::NullaryExpr(rows, cols, [random] { return random->Normal(); });
}

TEST(Psd, AcceptsSemiDefiniteMatricesOfAnyScale) {
  Random random(1);
  EXPECT_EQ(WhyNotPositiveSemiDefinite(MatXX::Zero(3, 3)), "");
  EXPECT_EQ(WhyNotPositiveSemiDefinite(MatXX(0, 0)), "");
  for (const double scale : {1e-200, 1e-12, 1.0, 1e12, 1e200}) {
    const MatXX A = NormalMatrix(6, 4, &random);  // rank 4 of 6
    EXPECT_EQ(WhyNotPositiveSemiDefinite(scale * A * A.transpose()), "") << scale;
  }
}

TEST(Psd, NamesTheFault) {
  const auto expect = [](const MatXX& A, const std::string& words) {
    EXPECT_NE(WhyNotPositiveSemiDefinite(A).find(words), std::string::npos) << WhyNotPositiveSemiDefinite(A);
  };
  MatXX A = MatXX::Identity(3, 3);
  A(1, 2) = 0.5;
  expect(A, "is not symmetric: (2, 1) = 0 but (1, 2) = 0.5");
  A(2, 1) = std::numeric_limits<double>::quiet_NaN();
  expect(A, "not finite: (2, 1) = nan");
  A = MatXX::Identity(2, 2);
  A(0, 0) = std::numeric_limits<double>::infinity();
  expect(A, "not finite: (0, 0) = inf");
  A(0, 0) = -2.0;
  expect(A, "is not positive semi-definite: (0, 0) = -2");
  A << 1, 2, 2, 1;
  expect(A, "smallest eigenvalue is -1");
  expect(MatXX::Zero(2, 3), "is not square: 2x3");
}

TEST(Psd, PseudoInverseSatisfiesMoorePenrose) {
  Random random(2);
  for (const int rank : {0, 1, 3, 5}) {
    const MatXX B = NormalMatrix(5, rank, &random);
    const MatXX A = B * B.transpose(), P = PseudoInversePsd(A);
    const double scale = std::max(1.0, A.norm());
    EXPECT_LT((A * P * A - A).norm(), 1e-12 * scale) << rank;
    EXPECT_LT((P * A * P - P).norm(), 1e-12 * std::max(1.0, P.norm())) << rank;
    EXPECT_LT((A * P - (A * P).transpose()).norm(), 1e-12) << rank;
    EXPECT_NEAR((A * P).trace(), rank, 1e-12);  // a projection's trace is its rank
  }
  EXPECT_EQ(PseudoInversePsd(MatXX(0, 0)).size(), 0);
}

// A by hand: diag(4, 1e-20) is singular to working precision, and diag(4, 1e-10) is not.
TEST(Psd, PseudoInverseCutsAtWorkingPrecision) {
  EXPECT_EQ(PseudoInversePsd(Eigen::Vector2d(4, 1e-20).asDiagonal())(1, 1), 0.0);
  EXPECT_DOUBLE_EQ(PseudoInversePsd(Eigen::Vector2d(4, 1e-10).asDiagonal())(1, 1), 1e10);
}

}  // namespace
}  // namespace ch5
