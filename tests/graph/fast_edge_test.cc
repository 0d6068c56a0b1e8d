#include "ch5_backend/graph/fast_edge.h"

#include <gtest/gtest.h>

#include "ch5_backend/graph/sized_edge.h"
#include "ch5_backend/types/vertices.h"

namespace ch5 {
namespace {

class PlainEdge : public SizedEdge<1, VertexScalar> {
 public:
  PlainEdge() : SizedEdge(std::make_shared<VertexScalar>(VertexScalar::Estimate(0.0))) {}
  void ComputeResidual() override { r_[0] = 1.0; }
  std::string TypeInfo() const override { return "PlainEdge"; }
};

// All that a fast side offers is optional.
class BareEdge : public PlainEdge, public FastEdge {};

TEST(FastEdge, EdgesWithoutAFastSideSaySo) {
  PlainEdge plain;
  EXPECT_EQ(AsFast(&plain), nullptr);
  BareEdge fast;
  ASSERT_NE(AsFast(&fast), nullptr);
  EXPECT_EQ(AsFast(&fast)->MakeBatch(), nullptr);
  EXPECT_FALSE(AsFast(&fast)->LinearizeInto(nullptr, nullptr));
  EXPECT_FALSE(AsFast(&fast)->NegativeProductsInto(nullptr));
}

}  // namespace
}  // namespace ch5
