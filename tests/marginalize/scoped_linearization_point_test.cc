#include "ch5_backend/marginalize/scoped_linearization_point.h"

#include "tests/marginalize/small_graphs.h"

namespace ch5 {
namespace {

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

TEST(ScopedLinearizationPoint, APriorMovesItsVerticesToItsOwnPoint) {
  auto x = std::make_shared<VertexScalar>(VertexScalar::Estimate(5.0));
  const Prior prior{{x}, {VecX::Constant(1, 3.0)}, MatXX::Identity(1, 1), VecX::Zero(1)};
  {
    const ScopedLinearizationPoint scope(&prior);
    EXPECT_EQ(x->GetEstimate()[0], 3.0);
  }
  EXPECT_EQ(x->GetEstimate()[0], 5.0);
  const ScopedLinearizationPoint nothing(nullptr);
  EXPECT_EQ(x->GetEstimate()[0], 5.0);
}

}  // namespace
}  // namespace ch5
