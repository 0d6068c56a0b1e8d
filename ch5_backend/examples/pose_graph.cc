/// A pose graph with a loss and marginals: twelve poses on a circle, one measurement between two of them false.
#include <cmath>
#include <cstdio>

#include "ch5_backend/math/transform.h"
#include "ch5_backend/sparse/joint_covariance.h"
#include "ch5_backend/sparse/sparse_optimizer.h"
#include "ch5_backend/types/pose_graph/edge_between.h"

int main() {
  constexpr int kPoses = 12;
  const ch5::Transform step{ch5::ExpSO3({0, 0, 2.0 * M_PI / kPoses}), {1, 0, 0}};  // T_i_j of neighbors, known to
  ch5::Mat66 W = ch5::Mat66::Zero();                                               // 0.1 m and half of 0.02 rad
  W.diagonal() << 1e2, 1e2, 1e2, 1e4, 1e4, 1e4;

  ch5::Graph graph;
  std::vector<std::shared_ptr<ch5::VertexPose>> poses;
  ch5::Transform T_W_B;
  for (int k = 0; k < kPoses; ++k) {
    poses.push_back(
        std::make_shared<ch5::VertexPose>(T_W_B.q, T_W_B.p + 0.1 * ch5::Vec3(std::sin(k), std::cos(3 * k), 0)));
    graph.AddVertex(poses.back());
    T_W_B = T_W_B * step;
  }
  poses[0]->SetPose(ch5::Qd::Identity(), ch5::Vec3::Zero());
  poses[0]->SetFixed();  // the gauge
  const auto loss = std::make_shared<ch5::CauchyLoss>(1.0);
  const auto measure = [&](int i, int j, const ch5::Transform& T_i_j) {
    const auto edge = std::make_shared<ch5::EdgeSE3Between>(poses[i], poses[j], T_i_j.q, T_i_j.p);
    edge->SetInformation(W);
    edge->SetLossFunction(loss);
    graph.AddEdge(edge);
  };
  for (int k = 0; k < kPoses; ++k) measure(k, (k + 1) % kPoses, step);
  measure(0, kPoses / 2, {ch5::Qd::Identity(), {0, 0, 3}});  // false

  const ch5::Summary summary = ch5::SparseOptimizer(&graph).Solve();
  std::printf("%s\n", summary.message.c_str());
  const double radius = 0.5 / std::sin(M_PI / kPoses);
  std::printf("across the circle: %.3f m, truly %.3f m\n", poses[kPoses / 2]->p().norm(), 2.0 * radius);

  ch5::Covariance covariance(&graph);
  for (int k = 1; k < kPoses; ++k) {
    const ch5::MatXX P = covariance.Block(*poses[k], *poses[k]);  // of [δp, δθ]
    std::printf("pose %2d: sigma of the position %.3f m\n", k, std::sqrt(P.topLeftCorner<3, 3>().trace()));
  }
  const ch5::MatXX joint = ch5::JointCovariance({poses[3], poses[4]}, &covariance);
  std::printf("correlation of x of neighbors: %.3f\n", joint(0, 6) / std::sqrt(joint(0, 0) * joint(6, 6)));
}
