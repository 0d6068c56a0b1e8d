#include "ch5_backend/graph/fast_edge.h"

#include <gtest/gtest.h>

#include "ch5_backend/graph/sized_edge.h"
#include "ch5_backend/types/vertices.h"

namespace ch5 {
namespace {

// An edge that has products of its own: r and J are constants.
class EdgeOfConstants : public SizedEdge<3, VertexVector<2>, VertexVector<3>>, public FastEdge {
 public:
  EdgeOfConstants()
      : SizedEdge(std::make_shared<VertexVector<2>>(Vec2::Zero()), std::make_shared<VertexVector<3>>(Vec3::Zero())) {}
  void ComputeResidual() override { r_ = Vec3(0.5, -1.0, 2.0); }
  /// [J r], 3×6.
  MatXX Columns() const {
    MatXX columns(3, 6);
    columns << 1, 2, 3, 4, 5, 0.5, 6, 7, 8, 9, 10, -1.0, 11, 12, 14, 14, 16, 2.0;
    return columns;
  }
  bool NegativeProductsInto(double* C) override {
    ComputeResidual();
    // Only the lower half is promised.
    Eigen::Map<MatXX>(C, 6, 6).setConstant(std::nan(""));
    Eigen::Map<MatXX>(C, 6, 6).triangularView<Eigen::Lower>() = -Columns().transpose() * Columns();
    return true;
  }
  std::string TypeInfo() const override { return "EdgeOfConstants"; }
};

// Columns as an elimination asks for them: some are left out, vertices change places, runs are broken.
TEST(FastEdge, NegativeProductsAreThoseOfTheColumnsAskedFor) {
  EdgeOfConstants edge;
  for (const std::vector<int>& columns :
       {std::vector<int>{0, 1, 2, 3, 4, 5}, {2, 3, 4, 0, 1, 5}, {5, 4, 3, 2, 1, 0}, {0, 5}, {3, 1, 5}}) {
    const auto n = static_cast<Eigen::Index>(columns.size());
    MatXX C = MatXX::Zero(n, n), chosen(3, n);
    for (Eigen::Index k = 0; k < n; ++k) chosen.col(k) = edge.Columns().col(columns[static_cast<size_t>(k)]);
    ASSERT_TRUE(NegativeProducts(&edge, columns, C.data()));
    const MatXX expected = -chosen.transpose() * chosen;
    EXPECT_EQ(MatXX(C.triangularView<Eigen::Lower>()), MatXX(expected.triangularView<Eigen::Lower>())) << n;
  }
  EXPECT_EQ(edge.Residual(), Vec3(0.5, -1.0, 2.0));
}

class PlainEdge : public SizedEdge<1, VertexScalar> {
 public:
  PlainEdge() : SizedEdge(std::make_shared<VertexScalar>(VertexScalar::Estimate(0.0))) {}
  void ComputeResidual() override { r_[0] = 1.0; }
  std::string TypeInfo() const override { return "PlainEdge"; }
};

TEST(FastEdge, EdgesWithoutAFastSideSaySo) {
  PlainEdge plain;
  double C = 7.0;
  EXPECT_EQ(AsFast(&plain), nullptr);
  EXPECT_FALSE(NegativeProducts(&plain, {0}, &C));
  EXPECT_EQ(C, 7.0);
  EdgeOfConstants fast;
  ASSERT_NE(AsFast(&fast), nullptr);
  EXPECT_EQ(AsFast(&fast)->MakeBatch(), nullptr);
  EXPECT_FALSE(AsFast(&fast)->LinearizeInto(nullptr, nullptr));
}

}  // namespace
}  // namespace ch5
