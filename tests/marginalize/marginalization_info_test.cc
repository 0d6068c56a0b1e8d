#include "ch5_backend/marginalize/marginalization_info.h"
#include "ch5_backend/marginalize/marginalize.h"
#include "tests/marginalize/small_graphs.h"

namespace ch5 {
namespace {

// MARGIN_OLD in miniature: each residual names the positions of frame 0, its speed-bias, and its landmarks.
MarginalizationInfo MarginOld(const SmallWindow& window) {
  const auto drop = window.Oldest();
  MarginalizationInfo info;
  for (const auto& edge : window.EdgesAt(drop)) {
    ResidualBlockInfo block{edge, {}};
    for (size_t i = 0; i < edge->Vertices().size(); ++i) {
      if (std::find(drop.begin(), drop.end(), edge->Vertices()[i]) != drop.end()) {
        block.drop_set.push_back(static_cast<int>(i));
      }
    }
    info.AddResidualBlockInfo(block);
  }
  info.PreMarginalize();
  info.Marginalize();
  return info;
}

// VN6: what is dropped is marginalized, not thrown away: m + n rows in A, n in the prior.
TEST(MarginalizationInfo, HasTheRowsOfDroppedAndKeptBlocks) {
  const SmallWindow window;
  const MarginalizationInfo info = MarginOld(window);
  EXPECT_EQ(info.m(), 6 + 9 + 6);          // pose 0, speed-bias 0, six landmarks
  EXPECT_EQ(info.n(), 6 + 9 + 6 + 6 + 6);  // pose 1, speed-bias 1, poses 2 and 3, extrinsic
  EXPECT_EQ(info.A().rows(), info.m() + info.n());
  EXPECT_EQ(info.GetParameterBlocks().J.cols(), info.n());
}

// VN8: OKVIS's form and VINS's are one: H = JᵀJ, and b = −Jᵀr₀ for either sign convention inside.
TEST(MarginalizationInfo, EqualsTheFunctionAndSoOkvis) {
  for (const uint64_t seed : {1u, 4u}) {
    const SmallWindow window(seed);
    const Prior vins = MarginOld(window).GetParameterBlocks();
    const MarginalSystem system = EliminateVertices(window.EdgesAt(window.Oldest()), window.Oldest());
    ASSERT_EQ(vins.vertices, system.kept);
    EXPECT_LT(RelativeError(vins.J.transpose() * vins.J, system.H), 1e-8);
    EXPECT_LT((vins.J.transpose() * vins.r0 + system.b).norm(), 1e-8 * system.b.norm());
  }
}

// VN7: MARGIN_SECOND_NEW takes the old prior and drops one pose from it, without any new residual: the Schur
// complement of H by that pose alone.
TEST(MarginalizationInfo, SecondNewDropsOnePoseOfThePrior) {
  const SmallWindow window;
  auto prior = std::make_shared<EdgePrior>(MarginOld(window).GetParameterBlocks());
  const auto& vertices = prior->Vertices();
  const auto it = std::find(vertices.begin(), vertices.end(), window.poses[3]);
  ASSERT_NE(it, vertices.end());
  MarginalizationInfo info;
  info.AddResidualBlockInfo({prior, {static_cast<int>(it - vertices.begin())}});
  info.PreMarginalize();
  info.Marginalize();
  const Prior vins = info.GetParameterBlocks();
  const MarginalSystem system = EliminateVertices({prior}, {window.poses[3]});
  EXPECT_EQ(info.m(), 6);
  ASSERT_EQ(vins.vertices, system.kept);
  EXPECT_LT(RelativeError(vins.J.transpose() * vins.J, system.H), 1e-8);
}

// VN16: ids and not addresses: another window built alike gives the same bits.
TEST(MarginalizationInfo, RepeatsToTheBit) {
  const SmallWindow a, b;
  EXPECT_EQ(MarginOld(a).GetParameterBlocks().J, MarginOld(b).GetParameterBlocks().J);
}

// The window slides: frame k's vertex takes over what the prior says of frame k + 1.
TEST(MarginalizationInfo, ShiftHandsTheStatesOn) {
  const SmallWindow window;
  const Prior prior = MarginOld(window).GetParameterBlocks({{window.poses[1]->Id(), window.poses[0]}});
  EXPECT_EQ(std::count(prior.vertices.begin(), prior.vertices.end(), window.poses[0]), 1);
  EXPECT_EQ(std::count(prior.vertices.begin(), prior.vertices.end(), window.poses[1]), 0);
}

TEST(MarginalizationInfo, RefusesAPositionOutsideOfTheEdge) {
  const SmallWindow window;
  MarginalizationInfo info;
  EXPECT_THROW(info.AddResidualBlockInfo({window.graph.Edges()[0], {1}}), std::invalid_argument);
}

}  // namespace
}  // namespace ch5
