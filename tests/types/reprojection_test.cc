/// Cameras: projections worked by hand, what a camera cannot see, and the forms of one residual against each other.
#include "ch5_backend/types/visual/edge_reprojection.h"

#include <gtest/gtest.h>

#include <cmath>

#include "ch5_backend/graph/graph.h"
#include "ch5_backend/simulate/random.h"
#include "ch5_backend/types/bal/edge_bal.h"
#include "ch5_backend/types/visual/edge_stereo.h"
#include "ch5_backend/types/visual/edge_track.h"

namespace ch5 {
namespace {

// A camera that looks along the body's x axis, its x to the right (−y of the body), its y down (−z of the body).
Qd Forward() {
  Mat33 R;
  R << 0, 0, 1,  //
      -1, 0, 0,  //
      0, -1, 0;
  return Qd(R);
}

std::shared_ptr<VertexPose> Pose(const Qd& q, const Vec3& p) { return std::make_shared<VertexPose>(q, p); }

std::shared_ptr<VertexPose> RandomPose(Random* random, double sigma) {
  const Qd q = ExpSO3(NormalVector(random, sigma));
  return Pose(q, NormalVector(random, sigma));
}

Vec2 ResidualOf(Edge* edge) {
  edge->ComputeResidual();
  return edge->Residual();
}

// 4 m ahead of the host, at (0.4, −0.8, 4) in its camera. The camera is 0.1 m before the body's center: in the body the
// point is at (4.1, −0.4, 0.8), in W as well. The target stands at (1.1, 0.6, 0.8) and looks along W's y axis, so the
// point is 3 m to its right, 1 m behind it: p_Bj = R_z(−90°) (3, −1, 0) = (−1, −3, 0), p_Cj = (3, 0, −1.1).
TEST(Reprojection, InverseDepthWithAnExtrinsicByHand) {
  const Transform T_B_C{Forward(), Vec3(0.1, 0, 0)};
  const auto host = Pose(Qd::Identity(), Vec3::Zero());
  const auto target = Pose(Qd(Eigen::AngleAxisd(M_PI / 2, Vec3::UnitZ())), Vec3(1.1, 0.6, 0.8));
  const auto depth = std::make_shared<VertexInverseDepth>(0.25);
  EdgeReprojection behind(depth, host, target, Vec2(0.1, -0.2), Vec2(0.5, 0.5), T_B_C);
  EXPECT_LT((ResidualOf(&behind) - Vec2(-3 / 1.1 - 0.5, -0.5)).norm(), 1e-14);
  // Turned by half a turn it sees the point 3 m to its left, 0.9 m ahead.
  target->SetPose(Qd(Eigen::AngleAxisd(-M_PI / 2, Vec3::UnitZ())), target->p());
  EdgeReprojection ahead(depth, host, target, Vec2(0.1, -0.2), Vec2(0.5, 0.5), T_B_C);
  EXPECT_LT((ResidualOf(&ahead) - Vec2(-3 / 0.9 - 0.5, -0.5)).norm(), 1e-14);
  EdgeReprojectionExtrinsic refined(depth, host, target, Pose(T_B_C.q, T_B_C.p), Vec2(0.1, -0.2), Vec2(0.5, 0.5));
  EXPECT_LT((ResidualOf(&refined) - ResidualOf(&ahead)).norm(), 1e-14);
  EdgeReprojectionXYZ in_space(std::make_shared<VertexPointXYZ>(Vec3(4.1, -0.4, 0.8)), target, Vec2(0.5, 0.5), T_B_C);
  EXPECT_LT((ResidualOf(&in_space) - ResidualOf(&ahead)).norm(), 1e-14);
}

TEST(Reprojection, TakesAnExtrinsicOfAnyLengthAndOneOfLengthOneToTheBit) {
  const auto depth = std::make_shared<VertexInverseDepth>(0.25);
  const auto host = Pose(Qd::Identity(), Vec3::Zero()), target = Pose(Qd::Identity(), Vec3(0.3, 0.2, 0.1));
  const auto residual = [&](const Qd& q) {
    EdgeReprojection edge(depth, host, target, Vec2(0.1, -0.2), Vec2(0.5, 0.5), {q, Vec3(0.1, 0, 0)});
    return ResidualOf(&edge);
  };
  const Qd q = ExpSO3(Vec3(0.3, -0.2, 0.1));
  EXPECT_LT((residual(Qd(2.0 * q.coeffs())) - residual(q)).norm(), 1e-15);
  EXPECT_EQ(RigidMatrix(Transform{q, Vec3::Zero()}).R, q.toRotationMatrix());
}

// Whatever the inverse depth, a point projects to where its host saw it; so its depth cannot be told from there.
TEST(Reprojection, HostsOwnPlaceTellsNothingOfTheDepth) {
  Random random(41);
  const Transform T_B_C{Forward(), Vec3(0.1, 0.02, -0.05)};
  for (const double inverse_depth : {1e-6, 0.25, 3.0}) {
    const auto host = RandomPose(&random, 1.0);
    EdgeReprojection edge(std::make_shared<VertexInverseDepth>(inverse_depth), host, Pose(host->q(), host->p()),
                          Vec2(0.1, -0.2), Vec2(0.1, -0.2), T_B_C);
    edge.Linearize();
    EXPECT_LT(edge.Residual().norm(), 1e-14) << inverse_depth;
    EXPECT_LT(edge.Jacobian(0).norm() * inverse_depth, 1e-12) << inverse_depth;
    EXPECT_LT((edge.Jacobian(1) + edge.Jacobian(2)).norm(), 1e-12) << inverse_depth;  // the relative pose alone counts
  }
}

// A point without a distance: only the turn counts, whatever the way between the cameras.
TEST(Reprojection, PointFarAwayShowsTheRotationAlone) {
  Random random(42);
  const Qd q_i = ExpSO3(NormalVector(&random, 0.3)), q_j = q_i * ExpSO3(Vec3(0.1, -0.2, 0.3));
  EdgeReprojection edge(std::make_shared<VertexInverseDepth>(1e-12), Pose(q_i, Vec3(1, 2, 3)),
                        Pose(q_j, Vec3(-4, 5, 6)), Vec2(0.1, -0.2), Vec2::Zero());
  const Vec3 ray = q_j.conjugate() * (q_i * Vec3(0.1, -0.2, 1.0));
  EXPECT_LT((ResidualOf(&edge) - ray.hnormalized()).norm(), 1e-10);
}

TEST(Reprojection, PointInTheCamerasPlaneIsNotFinite) {
  EdgeReprojectionXYZ edge(std::make_shared<VertexPointXYZ>(Vec3(1, 2, 3)), Pose(Qd::Identity(), Vec3(0, 0, 3)),
                           Vec2::Zero());
  EXPECT_FALSE(ResidualOf(&edge).allFinite());
  EdgeReprojectionPoseOnly known(Pose(Qd::Identity(), Vec3(0, 0, 3)), Vec3(1, 2, 3), Vec2::Zero());
  EXPECT_FALSE(ResidualOf(&known).allFinite());
}

// Mirrored through the camera's center a point has the same picture, so its residual is zero; the model does not hold.
TEST(Reprojection, APointBehindItsCameraIsOutOfTheDomain) {
  const auto at_origin = Pose(Qd::Identity(), Vec3::Zero()), ahead = Pose(Qd::Identity(), Vec3(0, 0, 1));
  const auto extrinsic = Pose(Qd::Identity(), Vec3::Zero());
  const auto offset = std::make_shared<VertexScalar>(VertexScalar::Estimate(0.0));
  const auto beside = Pose(Qd::Identity(), Vec3(0.2, 0, 0));
  for (const double sign : {1.0, -1.0}) {
    const auto depth = std::make_shared<VertexInverseDepth>(sign / 4.0);
    const Vec2 u(0.1, -0.2), u_ahead = u * 4.0 / (4.0 - sign), none(0, 0);
    const Vec3 p = sign * 4.0 * u.homogeneous();
    const auto point = std::make_shared<VertexPointXYZ>(p);
    std::vector<std::unique_ptr<Edge>> edges;
    edges.push_back(std::make_unique<EdgeReprojection>(depth, at_origin, ahead, u, u_ahead));
    edges.push_back(std::make_unique<EdgeReprojectionExtrinsic>(depth, at_origin, ahead, extrinsic, u, u_ahead));
    edges.push_back(std::make_unique<EdgeReprojectionCalibration>(
        depth, at_origin, ahead, extrinsic, offset, MovingPoint{u, none, 0.0}, MovingPoint{u_ahead, none, 0.0}));
    edges.push_back(std::make_unique<EdgeReprojectionXYZ>(point, at_origin, u));
    edges.push_back(std::make_unique<EdgeReprojectionPoseOnly>(at_origin, p, u));
    Vec9 camera = Vec9::Zero();  // looks along −z
    camera[6] = 1.0;
    edges.push_back(
        std::make_unique<EdgeBAL>(std::make_shared<VertexCameraBAL>(camera), std::make_shared<VertexPointXYZ>(-p), -u));
    for (const auto& edge : edges) {
      EXPECT_LT(ResidualOf(edge.get()).norm(), 1e-15) << edge->TypeInfo();
      EXPECT_EQ(edge->InDomain(), sign > 0.0) << edge->TypeInfo();
    }
    const EdgeTrack track(depth, {{at_origin, u}, {beside, u}, {ahead, u_ahead}}, {}, 0.01);
    EXPECT_EQ(track.InDomain(), sign > 0.0);
  }
  // A point 0.5 m before the host lies behind a target that stands 1 m ahead.
  EXPECT_FALSE(
      EdgeReprojection(std::make_shared<VertexInverseDepth>(2.0), at_origin, ahead, {0, 0}, {0, 0}).InDomain());
}

TEST(Graph, TellsTheEdgesThatAreOutOfTheirDomain) {
  Graph graph;
  const auto camera = Pose(Qd::Identity(), Vec3::Zero());
  graph.AddVertex(camera);
  for (const double z : {2.0, -2.0, 3.0}) {
    const auto point = std::make_shared<VertexPointXYZ>(Vec3(0.1, 0.2, z));
    graph.AddVertex(point);
    graph.AddEdge(std::make_shared<EdgeReprojectionXYZ>(point, camera, Vec2::Zero()));
  }
  const auto edges = EdgesOutOfDomain(graph);
  ASSERT_EQ(edges.size(), 1u);
  EXPECT_EQ(edges[0]->Id(), 1);
}

// With the offset that was known when the frames came, a camera being calibrated is an ordinary one.
TEST(ReprojectionCalibration, IsTheOrdinaryOneAtTheKnownOffset) {
  Random random(45);
  const auto depth = std::make_shared<VertexInverseDepth>(0.3);
  const auto host = RandomPose(&random, 0.2), target = RandomPose(&random, 0.2), T_B_C = RandomPose(&random, 0.1);
  const MovingPoint from{Vec2(0.1, -0.2), Vec2(0.5, 0.3), 0.02}, to{Vec2(0.3, 0.1), Vec2(-0.4, 0.6), 0.02};
  EdgeReprojectionCalibration edge(depth, host, target, T_B_C,
                                   std::make_shared<VertexScalar>(VertexScalar::Estimate(0.02)), from, to);
  EdgeReprojectionExtrinsic plain(depth, host, target, T_B_C, from.x, to.x);
  edge.Linearize();
  plain.Linearize();
  EXPECT_LT((edge.Residual() - plain.Residual()).norm(), 1e-14);
  for (size_t i = 0; i < 4; ++i) EXPECT_LT((edge.Jacobian(i) - plain.Jacobian(i)).norm(), 1e-13) << i;
}

// Camera 1 is 0.1 m to the right of camera 0, so a point 4 m ahead is seen 0.025 further to the left.
TEST(Stereo, APointIsSeenTwiceByTheBaseLineOverItsDepth) {
  const auto depth = std::make_shared<VertexInverseDepth>(0.25);
  const auto camera0 = Pose(Qd::Identity(), Vec3(0.3, 0.2, 0.1)), camera1 = Pose(Qd::Identity(), Vec3(0.4, 0.2, 0.1));
  const auto offset = std::make_shared<VertexScalar>(VertexScalar::Estimate(0.0));
  const MovingPoint from{Vec2(0.2, -0.1)}, to{Vec2(0.0, 0.0)};
  EdgeStereoHost host(depth, camera0, camera1, offset, from, to);
  host.ComputeResidual();
  EXPECT_LT((host.GetResidual() - Vec2(0.175, -0.1)).norm(), 1e-15);
  // One meter ahead the point is at 3 m: (0.8 − 0.1)/3, −0.4/3.
  EdgeStereo ahead(depth, Pose(Qd::Identity(), Vec3(5, 6, 7)), Pose(Qd::Identity(), Vec3(5, 6, 8)), camera0, camera1,
                   offset, from, to);
  ahead.ComputeResidual();
  EXPECT_TRUE(host.InDomain() && ahead.InDomain());
  EXPECT_LT((ahead.GetResidual() - Vec2(0.7 / 3.0, -0.4 / 3.0)).norm(), 1e-15);
  EdgeStereo past(depth, Pose(Qd::Identity(), Vec3(5, 6, 7)), Pose(Qd::Identity(), Vec3(5, 6, 12)), camera0, camera1,
                  offset, from, to);
  EXPECT_FALSE(past.InDomain()) << "behind the second camera";
}

// With both cameras in one place, camera 1 is camera 0.
TEST(Stereo, OfTwoCamerasInOnePlaceIsTheOrdinaryReprojection) {
  Random random(46);
  const auto depth = std::make_shared<VertexInverseDepth>(0.3);
  const auto host = RandomPose(&random, 0.2), target = RandomPose(&random, 0.2), T_B_C = RandomPose(&random, 0.1);
  const auto offset = std::make_shared<VertexScalar>(VertexScalar::Estimate(0.03));
  const MovingPoint from{Vec2(0.1, -0.2), Vec2(0.5, 0.3), 0.02}, to{Vec2(0.3, 0.1), Vec2(-0.4, 0.6), 0.01};
  EdgeReprojectionCalibration one(depth, host, target, T_B_C, offset, from, to);
  EdgeStereo two(depth, host, target, T_B_C, Pose(T_B_C->q(), T_B_C->p()), offset, from, to);
  one.Linearize();
  two.Linearize();
  EXPECT_LT((one.Residual() - two.Residual()).norm(), 1e-14);
  for (size_t i = 0; i < 3; ++i) EXPECT_LT((one.Jacobian(i) - two.Jacobian(i)).norm(), 1e-13) << i;
  EXPECT_LT((one.Jacobian(3) - two.Jacobian(3) - two.Jacobian(4)).norm(), 1e-13);
  EXPECT_LT((one.Jacobian(4) - two.Jacobian(5)).norm(), 1e-13);
}

// Two images of a camera that moves along its x axis at 2 m/s and then at `speed`, and whose clock is 30 ms late: the poses
// are those of the stamps, the points those of 30 ms later. The point is at (1, 0.5, 4), the second camera at (2, 0, 1).
std::unique_ptr<EdgeReprojectionCalibration> LateCamera(double speed, double offset) {
  const double late = 0.03;
  const MovingPoint host{Vec2((1.0 - 2.0 * late) / 4.0, 0.5 / 4.0), Vec2(-2.0 / 4.0, 0.0), 0.0};
  const MovingPoint target{Vec2((-1.0 - speed * late) / 3.0, 0.5 / 3.0), Vec2(-speed / 3.0, 0.0), 0.0};
  const Qd straight = Qd::Identity();
  return std::make_unique<EdgeReprojectionCalibration>(
      std::make_shared<VertexInverseDepth>(0.25), Pose(straight, Vec3::Zero()), Pose(straight, Vec3(2, 0, 1)),
      Pose(straight, Vec3::Zero()), std::make_shared<VertexScalar>(VertexScalar::Estimate(offset)), host, target);
}

// Taken for punctual, the host's ray is 2·0.03 m off and the target's 5·0.03 m, at 3 m: r = (0.15 − 0.06)/3.
TEST(ReprojectionCalibration, OnlyTheTrueTimeOffsetBringsALateCamerasPointsTogether) {
  EXPECT_LT((ResidualOf(LateCamera(5.0, 0.0).get()) - Vec2(0.03, 0)).norm(), 1e-15);
  EXPECT_LT(ResidualOf(LateCamera(5.0, 0.03).get()).norm(), 1e-15);
}

// At one velocity, late is only elsewhere: the offset shifts all that is seen, and no residual tells.
TEST(ReprojectionCalibration, TimeOffsetCannotBeSeenAtAConstantVelocity) {
  for (const double offset : {0.0, 0.03, -1.0}) {
    const auto edge = LateCamera(2.0, offset);
    edge->Linearize();
    EXPECT_LT(edge->Residual().norm(), 1e-15);
    EXPECT_LT(edge->Jacobian(4).norm(), 1e-15);
  }
}

}  // namespace
}  // namespace ch5
