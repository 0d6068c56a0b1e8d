#include "ch5_backend/graph/whitening.h"

#include <gtest/gtest.h>

#include "ch5_backend/simulate/random.h"

namespace ch5 {
namespace {

TEST(FactorPsd, RebuildsFullAndDeficientMatrices) {
  Random random(2);
  for (const int rank : {6, 4, 1, 0}) {
    MatXX B(6, 6);
    for (int i = 0; i < 36; ++i) B.data()[i] = random.Normal();
    B.rightCols(6 - rank).setZero();
    if (rank == 1) B(0, 0) = 1e-9;  // a first pivot that is tiny, though its row is not
    const MatXX W = B * B.transpose();
    Eigen::Matrix<double, 6, 6, Eigen::RowMajor> F;
    FactorPsd(W.data(), 6, F.data());
    EXPECT_LT((F.transpose() * F - W).norm(), 1e-14 * (W.norm() + 1e-300)) << rank;
    EXPECT_EQ(F.bottomRows(6 - rank).norm(), 0.0) << rank;
  }
}

}  // namespace
}  // namespace ch5
