#include "ch5_backend/types/edge_between.h"

#include <gtest/gtest.h>

#include "ch5_backend/simulate/random.h"
#include "tests/derivatives.h"

namespace ch5 {
namespace {

// Poses that differ from the measurement by about `error` [rad and m]; `scale` is the size of poses and measurement.
EdgeSE3Between MakeSE3(Random* random, double scale, double error) {
  const Qd q_i = ExpSO3(NormalVector(random, scale)), q_z = ExpSO3(NormalVector(random, scale));
  const Vec3 p_i = NormalVector(random, scale), p_z = NormalVector(random, scale);
  const Qd q_j = q_i * q_z * ExpSO3(NormalVector(random, error));
  const Vec3 p_j = p_i + q_i * (p_z + NormalVector(random, error));
  return {std::make_shared<VertexPose>(q_i, p_i), std::make_shared<VertexPose>(q_j, p_j), q_z, p_z};
}

TEST(EdgeBetween, JacobiansAgreeWithCentralDifferences) {
  Random random(31);
  for (const double scale : {0.0, 1e-9, 1.0, 5.0}) {
    for (const double error : {0.0, 1e-9, 1e-3, 0.3, 1.0}) {
      EdgeSE3Between edge = MakeSE3(&random, scale, error);
      ExpectJacobiansAreDerivatives(&edge);

      const auto i = std::make_shared<VertexSE2>(scale * Vec2(random.Normal(), 2.0), scale * random.Normal());
      const auto j = std::make_shared<VertexSE2>(i->p() + Vec2(1.0, error), i->Theta() + error * random.Normal());
      EdgeSE2Between edge_2d(i, j, Vec2(scale, 1.0), 0.3 * scale);
      ExpectJacobiansAreDerivatives(&edge_2d);
    }
  }
}

// i is turned by 90° about z and stands at (1, 2, 3); j is 5 m ahead of i with i's heading. The measurement says 4 m
// ahead, 60° to the left. By hand: p_d = R_z(−60°) (1, 0, 0) = (½, −√3/2, 0);  q_d turns by −60°: vec = (0, 0, −½).
TEST(EdgeBetween, ResidualWorkedByHand) {
  const Qd quarter(Eigen::AngleAxisd(M_PI / 2, Vec3::UnitZ())), sixth(Eigen::AngleAxisd(M_PI / 3, Vec3::UnitZ()));
  EdgeSE3Between edge(std::make_shared<VertexPose>(quarter, Vec3(1, 2, 3)),
                      std::make_shared<VertexPose>(quarter, Vec3(1, 7, 3)), sixth, Vec3(4, 0, 0));
  edge.ComputeResidual();
  Vec6 expected;
  expected << 0.5, -std::sqrt(3.0) / 2, 0, 0, 0, -0.5;
  EXPECT_LT((edge.Residual() - expected).norm(), 1e-14);

  EdgeSE2Between edge_2d(std::make_shared<VertexSE2>(Vec2(1, 2), M_PI / 2),
                         std::make_shared<VertexSE2>(Vec2(1, 7), M_PI / 2), Vec2(4, 0), M_PI / 3);
  edge_2d.ComputeResidual();
  EXPECT_LT((edge_2d.Residual() - Vec3(0.5, -std::sqrt(3.0) / 2, -M_PI / 3)).norm(), 1e-14);
}

TEST(EdgeBetween, QuaternionAndItsNegativeAreTheSameMeasurement) {
  Random random(32);
  const EdgeSE3Between edge = MakeSE3(&random, 1.0, 0.5);
  const auto i = std::static_pointer_cast<VertexPose>(edge.Vertices()[0]);
  const auto j = std::static_pointer_cast<VertexPose>(edge.Vertices()[1]);
  EdgeSE3Between plus(i, j, edge.q_z(), edge.p_z()), minus(i, j, Qd(-edge.q_z().coeffs()), edge.p_z());
  for (Edge* e : {static_cast<Edge*>(&plus), static_cast<Edge*>(&minus)}) {
    e->ComputeResidual();
    e->ComputeJacobians();
  }
  EXPECT_EQ(plus.Residual(), minus.Residual());
  EXPECT_EQ(plus.Jacobian(0), minus.Jacobian(0));
  EXPECT_EQ(plus.Jacobian(1), minus.Jacobian(1));
}

// Moving all poses alike changes no residual: each Jacobian pair cancels on the generators of that motion.
TEST(EdgeBetween, GaugeDirectionsHaveNoEffect) {
  Random random(33);
  EdgeSE3Between edge = MakeSE3(&random, 1.0, 0.7);
  edge.ComputeJacobians();
  Mat66 sum = Mat66::Zero();
  for (const size_t k : {0, 1}) {
    const auto& pose = static_cast<const VertexPose&>(*edge.Vertices()[k]);
    Mat66 N = Mat66::Identity();  // translation of the world; rotation ω of the world: δp = ω × p, δθ = Rᵀω
    N.topRightCorner<3, 3>() = -Hat(pose.p());
    N.bottomRightCorner<3, 3>() = pose.R().transpose();
    sum += edge.Jacobian(k) * N;
  }
  EXPECT_LT(sum.norm(), 1e-13);
}

// Ceres' residual, written out: [R_iᵀ(p_j − p_i) − p_z; 2 vec(q_z (q_i⁻¹q_j)⁻¹)].
TEST(EdgeBetween, InformationOfCeresErrorGivesCeresCost) {
  Random random(34);
  EdgeSE3Between edge = MakeSE3(&random, 1.0, 0.4);
  const MatXX root = MatXX::NullaryExpr(6, 6, [&] { return random.Normal(); });
  const Mat66 W = root * root.transpose();
  edge.SetInformation(InformationOfCeresError(edge, W));
  edge.ComputeResidual();

  const auto& i = static_cast<const VertexPose&>(*edge.Vertices()[0]);
  const auto& j = static_cast<const VertexPose&>(*edge.Vertices()[1]);
  Vec6 ceres;
  ceres << i.R().transpose() * (j.p() - i.p()) - edge.p_z(),
      2.0 * (edge.q_z() * (i.q().conjugate() * j.q()).conjugate()).vec();
  EXPECT_NEAR(edge.Chi2(), ceres.dot(W * ceres), 1e-12 * edge.Chi2());
}

TEST(VertexSE2, HeadingStaysWrapped) {
  VertexSE2 vertex(Vec2(1, 2), 3.0);
  const Vec3 delta(0.5, 0.5, 1.0);
  vertex.Plus(delta.data());
  EXPECT_NEAR(vertex.Theta(), 4.0 - 2 * M_PI, 1e-15);
  EXPECT_EQ(vertex.p(), Vec2(1.5, 2.5));
  EXPECT_LT((vertex.Minus(Vec3(1, 2, 3.0)) - delta).norm(), 1e-15);
}

}  // namespace
}  // namespace ch5
