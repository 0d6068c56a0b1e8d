/// Another project uses the library, compiled with flags of its own: what it allocates, the library frees, and the other way
/// round; classes with matrices of fixed and of dynamic size cross the border in both directions.
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <vector>

#include "ch5_backend/marginalize/marginalize.h"
#include "ch5_backend/simulate/sensors/simulation.h"
#include "ch5_backend/sparse/covariance.h"
#include "ch5_backend/sparse/sparse_optimizer.h"
#include "ch5_backend/types/edge_se3_prior.h"
#include "ch5_backend/types/pose_graph/edge_between.h"
#include "ch5_backend/window/estimator.h"

namespace {

// How far the bodies are from one another:  r = ‖p_j − p_i‖ − d.
class EdgeRange : public ch5::SizedEdge<1, ch5::VertexPose, ch5::VertexPose> {
 public:
  EdgeRange(std::shared_ptr<ch5::VertexPose> i, std::shared_ptr<ch5::VertexPose> j, double d)
      : SizedEdge(std::move(i), std::move(j)), d_(d) {}
  void ComputeResidual() override { r_[0] = (GetVertex<1>().p() - GetVertex<0>().p()).norm() - d_; }
  std::string TypeInfo() const override { return "EdgeRange"; }

 private:
  double d_;
};

bool Report(const char* what, double value, double limit) {
  std::printf("%s: %.3e, at most %.0e\n", what, value, limit);
  return value <= limit;
}

// Four poses in a row, a prior on the first. With the first marginalized, the last one's covariance must stay.
bool MarginalizeAPose() {
  std::vector<std::shared_ptr<ch5::VertexPose>> poses;
  std::vector<std::shared_ptr<ch5::Edge>> edges;
  const ch5::Qd turn(Eigen::AngleAxisd(0.3, ch5::Vec3(1.0, 2.0, 3.0).normalized()));
  const ch5::Vec3 ahead(1.0, 0.2, -0.1);
  ch5::Graph graph;
  ch5::Qd q = ch5::Qd::Identity();
  ch5::Vec3 p = ch5::Vec3::Zero();
  for (size_t k = 0; k < 4; ++k) {
    poses.push_back(std::make_shared<ch5::VertexPose>(q, p + 0.05 * ch5::Vec3::Random()));
    graph.AddVertex(poses.back());
    if (k == 0) edges.push_back(std::make_shared<ch5::EdgeSE3Prior>(poses[0], q, p));
    if (k > 0) edges.push_back(std::make_shared<ch5::EdgeSE3Between>(poses[k - 1], poses[k], turn, ahead));
    if (k > 1) edges.push_back(std::make_shared<EdgeRange>(poses[k - 2], poses[k], (ahead + turn * ahead).norm()));
    p += q * ahead;
    q = q * turn;
  }
  for (const auto& edge : edges) graph.AddEdge(edge);
  ch5::SparseOptimizer optimizer(&graph);
  const ch5::Summary summary = optimizer.Solve();
  std::printf("%.3e -> %.3e, %s\n", summary.initial_cost, summary.final_cost, summary.message.c_str());
  const ch5::MatXX before = ch5::Covariance(&graph).Block(*poses[3], *poses[3]);

  ch5::MarginalizeInto(&graph, {poses[0]});
  const ch5::MatXX after = ch5::Covariance(&graph).Block(*poses[3], *poses[3]);
  const ch5::Vec3 last = p - q * turn.conjugate() * ahead;
  const bool is_solved = Report("final cost", summary.final_cost, 1e-12);
  const bool is_there = Report("position", (poses[3]->p() - last).norm(), 1e-5);
  return Report("covariance", (after - before).norm() / before.norm(), 1e-6) && is_solved && is_there;
}

// Six seconds of a hand-held camera, simulated and estimated.
bool FollowACamera() {
  ch5::HandheldOptions path;
  path.duration = 6.0;
  path.standstill_seconds = 1.5;
  const ch5::Recording recording = ch5::SimulateInRoom(path, 1500);
  ch5::EstimatorOptions options;
  options.calibration = recording.calibration;
  ch5::OkvisOptions okvis;
  okvis.temporal_frames = 5;
  ch5::Estimator estimator(options, ch5::MakeOkvisPolicy(okvis));
  auto measurement = recording.imu.begin();
  ch5::FrameReport report;
  for (const ch5::Image& image : recording.images) {
    while (measurement != recording.imu.end() &&
           (measurement == recording.imu.begin() || std::prev(measurement)->t < image.t)) {
      estimator.AddImu(*measurement++);
    }
    report = estimator.AddFrame(image);
  }
  if (!report.state) return std::printf("the camera is lost\n"), false;
  const ch5::StampedState truth = *ch5::StateAt(recording.truth, report.state->t);
  const bool is_one_run = Report("restarts", estimator.Restarts(), 0);
  // Their directions differ by a yaw, which nothing observes.
  return Report("speed", std::abs(report.state->v_W.norm() - truth.v_W.norm()), 0.1) && is_one_run;
}

// Also where -ffast-math has told the compiler that there is no such number.
bool RefusesNaN() {
  const auto pose = std::make_shared<ch5::VertexPose>();
  ch5::Graph graph;
  graph.AddVertex(pose);
  graph.AddEdge(
      std::make_shared<ch5::EdgeSE3Prior>(pose, ch5::Qd::Identity(), ch5::Vec3(std::strtod("nan", nullptr), 0, 0)));
  const ch5::Summary summary = ch5::SparseOptimizer(&graph).Solve();
  std::printf("a prior at NaN: %s\n", summary.message.c_str());
  return summary.termination == ch5::Termination::kNotFinite;
}

}  // namespace

int main() {
  const bool is_marginalized = MarginalizeAPose(), is_refused = RefusesNaN();
  return FollowACamera() && is_marginalized && is_refused ? 0 : 1;
}
