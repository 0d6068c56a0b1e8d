/// A graph that grows: a robot drives five rounds, measures each step, and after each round where it began. Each Update does
/// again only what changes.
#include <cmath>
#include <cstdio>

#include "ch5_backend/sparse/incremental_smoother.h"
#include "ch5_backend/types/pose_graph/edge_between.h"

int main() {
  constexpr int kRound = 100, kRounds = 5;
  const ch5::Vec2 step(1.0, 0.0);
  const double turn = 2.0 * M_PI / kRound;
  ch5::Mat33 W = ch5::Vec3(1e4, 1e4, 1e6).asDiagonal();  // 1 cm, 1 mrad

  ch5::Graph graph;
  ch5::IncrementalSmoother smoother(&graph);
  std::vector<std::shared_ptr<ch5::VertexSE2>> poses(1, std::make_shared<ch5::VertexSE2>());
  graph.AddVertex(poses[0]);
  poses[0]->SetFixed();  // the gauge
  const auto measure = [&](int i, int j, const ch5::Vec2& p, double theta) {
    const auto edge = std::make_shared<ch5::EdgeSE2Between>(poses[i], poses[j], p, theta);
    edge->SetInformation(W);
    graph.AddEdge(edge);
  };
  for (int k = 1; k <= kRounds * kRound; ++k) {
    const ch5::VertexSE2& last = *poses.back();
    const double drift = 1e-3 * std::sin(k);
    poses.push_back(std::make_shared<ch5::VertexSE2>(  // where odometry leads to
        last.p() + ch5::Rotation2(last.Theta()) * step, last.Theta() + turn + drift));
    graph.AddVertex(poses.back());
    measure(k - 1, k, step, turn + drift);
    if (k % kRound == 0) measure(k - kRound, k, ch5::Vec2::Zero(), 0.0);
    const ch5::UpdateSummary update = smoother.Update();
    if (k % kRound > 1) continue;
    const double sigma = std::sqrt(smoother.Covariance(*poses.back()).topLeftCorner<2, 2>().trace());
    std::printf("pose %d: %d of %d variables eliminated, sigma %.3f m\n", k, update.eliminated, update.variables,
                sigma);
  }
  std::printf("the end is %.4f m from the start\n", poses.back()->p().norm());
}
