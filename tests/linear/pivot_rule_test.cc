#include "ch5_backend/linear/pivot_rule.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "ch5_backend/math/eigen_types.h"
#include "ch5_backend/simulate/random.h"

namespace ch5::test {
namespace {

// The last pivot of A = L Lᵀ, as a part of the last diagonal entry.
double LastPivot(MatXX A) {
  const Eigen::Index n = A.rows();
  const double scale = A(n - 1, n - 1);
  for (Eigen::Index k = 0; k + 1 < n; ++k) {
    for (Eigen::Index j = k + 1; j < n; ++j) {
      for (Eigen::Index i = j; i < n; ++i) A(i, j) -= A(i, k) * A(j, k) / A(k, k);
    }
  }
  return A(n - 1, n - 1) / scale;
}

// D JᵀJ D for a random J; D has units from 1e-6 to 1e6. In J's last column only `part` is new.
MatXX Gram(int n, double part, Random* random) {
  MatXX J = MatXX::NullaryExpr(2 * n, n, [&] { return random->Normal(); });
  const VecX mix = VecX::NullaryExpr(n - 1, [&] { return random->Normal(); });
  J.col(n - 1) = J.leftCols(n - 1) * mix + part * J.col(n - 1);
  const VecX units = VecX::NullaryExpr(n, [&] { return std::pow(10.0, random->Uniform(-6.0, 6.0)); });
  J *= units.asDiagonal();
  return J.transpose() * J;
}

TEST(PivotRule, TellsSingularMatricesFromDefiniteOnesInAnyUnits) {
  Random random(1);
  for (const int n : {2, 3, 6, 15, 60, 100}) {
    for (int repeat = 0; repeat < 3; ++repeat) {
      EXPECT_LE(LastPivot(Gram(n, 0.0, &random)), PivotRounding(n)) << n << ": a column is a sum of others";
      // The column's part is known to half of the digits.
      EXPECT_GT(LastPivot(Gram(n, 1e-4, &random)), PivotRounding(n)) << n << ": no column is a sum of others";
    }
  }
}

TEST(PivotRule, GrowsWithTheMatrix) {
  EXPECT_EQ(PivotRounding(0), 0.0);
  EXPECT_EQ(PivotRounding(1), 8.0 * std::numeric_limits<double>::epsilon());
  EXPECT_EQ(PivotRounding(1000), 1000.0 * PivotRounding(1));
}

}  // namespace
}  // namespace ch5::test
