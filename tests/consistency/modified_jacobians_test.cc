#include "ch5_backend/consistency/modified_jacobians.h"

#include "tests/marginalize/small_graphs.h"

namespace ch5 {
namespace {

// Twice the Jacobians of another edge.
class DoubledJacobians : public EdgeWithModifiedJacobians {
 public:
  explicit DoubledJacobians(std::shared_ptr<Edge> edge) : EdgeWithModifiedJacobians(std::move(edge)) {}
  void ComputeJacobians() override {
    CopyJacobians();
    J_ *= 2.0;
  }
};

TEST(EdgeWithModifiedJacobians, TakesResidualInformationAndLossFromTheOtherEdge) {
  const SmallWindow window;
  const std::shared_ptr<Edge> edge = window.graph.Edges().back();  // a reprojection with a loss
  DoubledJacobians doubled(edge);
  window.poses[0]->SetPose(window.poses[0]->q(), window.poses[0]->p() + Vec3(0.1, 0, 0));
  window.poses[3]->SetPose(window.poses[3]->q(), window.poses[3]->p() + Vec3(0, 0.2, 0));
  edge->Linearize();
  doubled.Linearize();
  EXPECT_EQ(VecX(doubled.Residual()), VecX(edge->Residual()));
  EXPECT_EQ(MatXX(doubled.Information()), MatXX(edge->Information()));
  EXPECT_EQ(doubled.Cost(), edge->Cost());
  EXPECT_EQ(doubled.TypeInfo(), edge->TypeInfo());
  for (size_t i = 0; i < edge->Vertices().size(); ++i) {
    EXPECT_EQ(MatXX(doubled.Jacobian(i)), MatXX(2.0 * edge->Jacobian(i)));
  }
}

// The loss belongs to the other edge, which lives as long as the modified one.
TEST(EdgeWithModifiedJacobians, KeepsTheOtherEdgeAndItsLossAlive) {
  auto x = std::make_shared<VertexScalar>(VertexScalar::Estimate(3.0));
  std::shared_ptr<Edge> edge = std::make_shared<LinearEdge>(std::vector<std::shared_ptr<Vertex>>{x},
                                                            std::vector<MatXX>{MatXX::Ones(1, 1)}, VecX::Zero(1));
  edge->SetLossFunction(std::make_shared<HuberLoss>(1.0));
  DoubledJacobians doubled(std::move(edge));
  doubled.Linearize();
  EXPECT_NEAR(doubled.Cost(), 0.5 * (2.0 * 3.0 - 1.0), 1e-12);  // 2δ√s − δ²
}

}  // namespace
}  // namespace ch5
