/// A track as one residual: its noise is that of all its points, the host's included.
#include "ch5_backend/types/visual/edge_track.h"

#include <gtest/gtest.h>

#include "ch5_backend/simulate/random.h"
#include "tests/derivatives.h"

namespace ch5 {
namespace {

constexpr double kSigma = 0.002;

struct Track {
  explicit Track(int targets, uint64_t seed = 51) : random(seed) {
    T_B_C = {ExpSO3(NormalVector(&random, 0.2)), NormalVector(&random, 0.1)};
    for (int k = 0; k <= targets; ++k) {
      const Qd q = ExpSO3(NormalVector(&random, 0.2));
      const Vec3 p = NormalVector(&random, 0.5);
      views.push_back({std::make_shared<VertexPose>(q, p), Vec2(0.1 * random.Normal(), 0.1 * random.Normal())});
    }
  }
  EdgeTrack MakeEdge() const { return EdgeTrack(inverse_depth, views, T_B_C, kSigma); }

  /// B = ∂r/∂u_host by central differences.
  MatXX HostJacobian() const {
    MatXX B(2 * static_cast<int>(views.size() - 1), 2);
    for (int k = 0; k < 2; ++k) {
      VecX ends[2];
      for (const int side : {0, 1}) {
        std::vector<EdgeTrack::View> moved = views;
        moved[0].x[k] += side ? 1e-5 : -1e-5;
        EdgeTrack edge(inverse_depth, moved, T_B_C, kSigma);
        edge.ComputeResidual();
        ends[side] = edge.Residual();
      }
      B.col(k) = (ends[1] - ends[0]) / 2e-5;
    }
    return B;
  }

  Random random;
  std::shared_ptr<VertexInverseDepth> inverse_depth = std::make_shared<VertexInverseDepth>(0.25);
  std::vector<EdgeTrack::View> views;
  Transform T_B_C;
};

TEST(EdgeTrack, JacobiansAgreeWithCentralDifferences) {
  for (const uint64_t seed : {51, 52, 53}) {
    EdgeTrack edge = Track(4, seed).MakeEdge();
    ExpectJacobiansAreDerivatives(&edge);
    ASSERT_EQ(edge.ResidualDimension(), 8);
    ASSERT_EQ(edge.Vertices().size(), 6u);
  }
}

TEST(EdgeTrack, ResidualsAreThoseOfItsReprojections) {
  const Track track(3);
  EdgeTrack edge = track.MakeEdge();
  edge.ComputeResidual();
  for (int j = 1; j <= 3; ++j) {
    EdgeReprojection single(track.inverse_depth, track.views[0].T_W_B, track.views[static_cast<size_t>(j)].T_W_B,
                            track.views[0].x, track.views[static_cast<size_t>(j)].x, track.T_B_C);
    single.ComputeResidual();
    EXPECT_EQ(edge.Residual().segment<2>(2 * (j - 1)), single.Residual()) << j;
  }
}

// cov r = σ² (I + B Bᵀ): each target's own noise, and the host's in all.
TEST(EdgeTrack, InformationIsTheInverseOfTheCovarianceOfAllPoints) {
  for (const int targets : {1, 2, 6}) {
    const Track track(targets);
    const MatXX B = track.HostJacobian();
    const MatXX covariance = kSigma * kSigma * (MatXX::Identity(2 * targets, 2 * targets) + B * B.transpose());
    const EdgeTrack edge = track.MakeEdge();
    EXPECT_LT((edge.Information() * covariance - MatXX::Identity(2 * targets, 2 * targets)).norm(), 1e-8) << targets;
  }
}

// By hand: all targets stand where the host stands, so B = [I; I; …]. W of a shift that all n share is n/(n + 1)/σ²: it tends
// to the host's own 1/σ², where an exact host would make it n/σ².
TEST(EdgeTrack, ManyTargetsCannotBeSurerThanTheirHost) {
  for (const int targets : {1, 2, 10}) {
    Track track(targets);
    for (auto& view : track.views) view.T_W_B = std::make_shared<VertexPose>();
    const EdgeTrack edge = track.MakeEdge();
    VecX common = VecX::Zero(2 * targets);
    for (int j = 0; j < targets; ++j) common[2 * j] = 1.0;
    const double n = targets;
    EXPECT_NEAR(common.dot(edge.Information() * common) * kSigma * kSigma, n / (n + 1), 1e-12) << targets;
  }
}

TEST(EdgeTrack, RefusesASingleViewAndPointsWithoutNoise) {
  const Track track(2);
  EXPECT_THROW(EdgeTrack(track.inverse_depth, {track.views[0]}, track.T_B_C, kSigma), std::invalid_argument);
  EXPECT_THROW(EdgeTrack(track.inverse_depth, track.views, track.T_B_C, 0.0), std::invalid_argument);
  EXPECT_THROW(EdgeTrack(track.inverse_depth, track.views, track.T_B_C, std::nan("")), std::invalid_argument);
}

}  // namespace
}  // namespace ch5
