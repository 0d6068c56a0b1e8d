/// A window that slides: a hundred poses, never more than five in the graph. What leaves is kept as a prior, and the newest
/// pose is as well known as with all of them.
#include <cmath>
#include <cstdio>
#include <deque>

#include "ch5_backend/marginalize/marginalize.h"
#include "ch5_backend/math/transform.h"
#include "ch5_backend/sparse/sparse_optimizer.h"
#include "ch5_backend/types/edge_se3_prior.h"
#include "ch5_backend/types/pose_graph/edge_between.h"

namespace {

constexpr int kPoses = 100;
constexpr size_t kWindow = 5;

// Appends a pose and its odometry to the one before, and to the one before that.
void Append(int k, std::deque<std::shared_ptr<ch5::VertexPose>>* poses, ch5::Graph* graph) {
  const ch5::Transform step{ch5::ExpSO3({0, 0.01, 0.05}), {1, 0, 0}};
  const ch5::Vec3 noise = 0.001 * ch5::Vec3(std::sin(7 * k), std::cos(5 * k), std::sin(3 * k));
  const ch5::Transform T_W_B = k > 0 ? ch5::Transform{poses->back()->q(), poses->back()->p()} * step : ch5::Transform();
  poses->push_back(std::make_shared<ch5::VertexPose>(T_W_B.q, T_W_B.p));
  graph->AddVertex(poses->back());
  if (k == 0) graph->AddEdge(std::make_shared<ch5::EdgeSE3Prior>(poses->back(), T_W_B.q, T_W_B.p));
  ch5::Transform T_i_j;
  for (size_t back = 1; back <= 2 && back < poses->size(); ++back) {
    T_i_j = step * T_i_j;
    const auto& i = (*poses)[poses->size() - 1 - back];
    graph->AddEdge(std::make_shared<ch5::EdgeSE3Between>(i, poses->back(), T_i_j.q, T_i_j.p + noise));
  }
  for (const auto& edge : graph->EdgesOf(*poses->back())) edge->SetInformation(1e6 * ch5::Mat66::Identity());  // 1 mm
}

// Position of the newest pose, and its standard deviation.
std::pair<ch5::Vec3, double> Newest(ch5::Graph* graph, const ch5::VertexPose& pose) {
  return {pose.p(), std::sqrt(ch5::Covariance(graph).Block(pose, pose).topLeftCorner<3, 3>().trace())};
}

}  // namespace

int main() {
  ch5::Graph window, batch;
  std::deque<std::shared_ptr<ch5::VertexPose>> in_window, all;
  for (int k = 0; k < kPoses; ++k) {
    Append(k, &in_window, &window);
    ch5::SparseOptimizer(&window).Solve();
    if (in_window.size() > kWindow) {
      ch5::MarginalizeInto(&window, {in_window.front()});
      in_window.pop_front();
    }
    Append(k, &all, &batch);
  }
  ch5::SparseOptimizer(&batch).Solve();
  const auto [p_window, sigma_window] = Newest(&window, *in_window.back());
  const auto [p_batch, sigma_batch] = Newest(&batch, *all.back());
  std::printf("window: %zu poses, sigma %.4f m\nbatch: %zu poses, sigma %.4f m\n", in_window.size(), sigma_window,
              all.size(), sigma_batch);
  std::printf("their newest poses are %.2g m apart\n", (p_window - p_batch).norm());
}
