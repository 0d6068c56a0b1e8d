#include "ch5_backend/types/pose_graph/edge_between.h"

#include <gtest/gtest.h>

#include <cmath>

#include "ch5_backend/simulate/random.h"
#include "ch5_backend/types/edge_se3_prior.h"
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

// The plane lies in space: r of SE(3) is [x, y, 0; 0, 0, sin(½θ)] of SE(2)'s [x, y, θ].
TEST(EdgeBetween, PlaneAndSpaceAgree) {
  Random random(36);
  for (int k = 0; k < 20; ++k) {
    const Vec2 p_i(random.Normal(), random.Normal()), p_j(random.Normal(), random.Normal()), p_z(random.Normal(), 1.0);
    const double theta_i = random.Uniform(-4, 4), theta_j = random.Uniform(-4, 4), theta_z = random.Uniform(-4, 4);
    EdgeSE2Between plane(std::make_shared<VertexSE2>(p_i, theta_i), std::make_shared<VertexSE2>(p_j, theta_j), p_z,
                         theta_z);
    const auto turn = [](double theta) { return Qd(Eigen::AngleAxisd(theta, Vec3::UnitZ())); };
    const auto in_space = [](const Vec2& p) { return Vec3(p.x(), p.y(), 0.0); };
    EdgeSE3Between space(std::make_shared<VertexPose>(turn(theta_i), in_space(p_i)),
                         std::make_shared<VertexPose>(turn(theta_j), in_space(p_j)), turn(theta_z), in_space(p_z));
    plane.ComputeResidual();
    space.ComputeResidual();
    const Vec3 r = plane.Residual();
    EXPECT_LE(std::abs(r.z()), M_PI);
    Vec6 expected;
    expected << r.x(), r.y(), 0, 0, 0, std::sin(0.5 * r.z());
    EXPECT_LT((space.Residual() - expected).norm(), 1e-14) << k;
  }
}

// Ceres' pose_graph_2d: r' = [R_iᵀ(p_j − p_i) − p_z; θ_j − θ_i − θ_z].
TEST(EdgeBetween, InformationOfCeresErrorGivesCeresCostInThePlane) {
  const auto i = std::make_shared<VertexSE2>(Vec2(1, 2), 0.5), j = std::make_shared<VertexSE2>(Vec2(3, 1), -0.4);
  EdgeSE2Between edge(i, j, Vec2(1.5, -1.0), 0.7);
  Mat33 W;
  W << 4, 1, 0.5, 1, 3, -0.2, 0.5, -0.2, 2;
  edge.SetInformation(InformationOfCeresError(edge, W));
  edge.ComputeResidual();
  Vec3 ceres;
  ceres << Rotation2(-0.5) * Vec2(2, -1) - Vec2(1.5, -1.0), -0.4 - 0.5 - 0.7;
  EXPECT_NEAR(edge.Chi2(), ceres.dot(W * ceres), 1e-12);
}

// By hand: the pose is turned by 90° about z against what is asked, and 1, 2, 3 m off.
TEST(EdgeSE3Prior, ResidualWorkedByHand) {
  const Qd quarter(Eigen::AngleAxisd(M_PI / 2, Vec3::UnitZ()));
  EdgeSE3Prior edge(std::make_shared<VertexPose>(quarter, Vec3(5, 5, 5)), Qd::Identity(), Vec3(4, 3, 2));
  edge.ComputeResidual();
  Vec6 expected;
  expected << 0, 0, M_PI / 2, 1, 2, 3;
  EXPECT_LT((edge.Residual() - expected).norm(), 1e-15);
}

Mat66 SomeCovariance(Random* random) {
  Mat66 A;
  for (int k = 0; k < 6; ++k) A.col(k) << NormalVector(random, 0.1), NormalVector(random, 0.02);
  return A * A.transpose();
}

// A pose that one edge determines is as uncertain as was said, in the order and units of its increment.
TEST(PoseEdges, TheCovarianceThatIsSetIsThatOfThePose) {
  Random random(38);
  const Mat66 covariance = SomeCovariance(&random);
  const auto of_vertex = [](Edge* edge, size_t k) {
    edge->Linearize();
    return Mat66((edge->Jacobian(k).transpose() * edge->Information() * edge->Jacobian(k)).inverse());
  };
  const auto i = std::make_shared<VertexPose>(ExpSO3(NormalVector(&random, 1.0)), NormalVector(&random, 1.0));
  EdgeSE3Prior prior(i, i->q(), i->p());
  prior.SetCovariance(covariance);
  EXPECT_LT((of_vertex(&prior, 0) - covariance).norm(), 1e-12);

  // From pose i, which is known, to j: δp_j = R_i δp, δθ_j = δθ.
  const Qd q_z = ExpSO3(NormalVector(&random, 1.0));
  const Vec3 p_z = NormalVector(&random, 1.0);
  EdgeSE3Between between(i, std::make_shared<VertexPose>(i->q() * q_z, i->p() + i->q() * p_z), q_z, p_z);
  between.SetCovariance(covariance);
  Mat66 turn = Mat66::Identity();
  turn.topLeftCorner<3, 3>() = i->R();
  EXPECT_LT((of_vertex(&between, 1) - turn * covariance * turn.transpose()).norm(), 1e-12);

  EXPECT_THROW(prior.SetCovariance(Mat66::Zero()), std::invalid_argument) << "singular";
  EXPECT_THROW(between.SetCovariance(-covariance), std::invalid_argument);
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
