/// The information matrix of an edge: what is refused, and what rᵀWr comes to.
#include <gtest/gtest.h>

#include <limits>

#include "ch5_backend/graph/whitening.h"
#include "ch5_backend/simulate/random.h"
#include "ch5_backend/types/visual/edge_reprojection.h"
#include "tests/graph_error.h"

namespace ch5 {
namespace {

EdgeReprojectionPoseOnly NewEdge() {
  return {std::make_shared<VertexPose>(), Vec3(1, 2, 1), Vec2(0.5, 0.5)};  // r = (0.5, 1.5)
}

void ExpectRefused(const MatXX& W, const std::string& words) {
  auto edge = NewEdge();
  test::ExpectError<std::invalid_argument>([&] { edge.SetInformation(W); },
                                           "EdgeReprojectionPoseOnly: the information matrix " + words);
  EXPECT_EQ(edge.Information(), MatXX::Identity(2, 2));  // as it was
}

TEST(Information, IsANumberTimesTheIdentity) {
  auto edge = NewEdge();
  edge.SetInformation((Mat22() << 2, 1, 1, 2).finished());
  edge.SetIsotropicInformation(3.0);
  EXPECT_EQ(edge.Information(), 3.0 * MatXX::Identity(2, 2));
  EXPECT_EQ(edge.IsotropicInformation(), 3.0);
  for (const double w : {-1.0, std::numeric_limits<double>::infinity(), std::numeric_limits<double>::quiet_NaN()}) {
    EXPECT_THROW(edge.SetIsotropicInformation(w), std::invalid_argument);
  }
  EXPECT_EQ(edge.IsotropicInformation(), 3.0);
}

TEST(Information, RefusesWhatIsNoInformation) {
  Mat22 W = Mat22::Identity();
  ExpectRefused(MatXX::Identity(3, 3), "must be 2x2, got 3x3");
  ExpectRefused(MatXX(0, 0), "must be 2x2, got 0x0");
  W(0, 1) = 1e-3;
  ExpectRefused(W, "is not symmetric");
  W(1, 0) = std::numeric_limits<double>::quiet_NaN();
  ExpectRefused(W, "has an entry that is not finite: (1, 0) = nan");
  W << 1, 2, 2, 1;
  ExpectRefused(W, "is not positive semi-definite: its smallest eigenvalue is -1");
  ExpectRefused(-Mat22::Identity(), "is not positive semi-definite: (0, 0) = -1");
}

TEST(Information, SemiDefiniteAndZeroAreAllowed) {
  auto edge = NewEdge();
  edge.ComputeResidual();
  edge.SetInformation(Mat22::Zero());
  EXPECT_EQ(edge.Chi2(), 0.0);
  edge.SetInformation(Mat22::Ones());  // rank 1
  EXPECT_EQ(edge.Chi2(), 4.0);         // (0.5 + 1.5)²
}

TEST(Information, ChiSquareByHand) {
  auto edge = NewEdge();
  edge.SetInformation((Mat22() << 4, 1, 1, 2).finished());
  edge.ComputeResidual();
  EXPECT_EQ(edge.Chi2(), 4 * 0.25 + 2 * 1 * 0.75 + 2 * 2.25);
  EXPECT_EQ(edge.Cost(), 0.5 * edge.Chi2());
  edge.SetLossFunction(std::make_shared<CauchyLoss>(1.0));
  EXPECT_NEAR(edge.Cost(), 0.5 * std::log(8.0), 1e-15);
}

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
