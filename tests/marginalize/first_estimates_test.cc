#include "ch5_backend/marginalize/first_estimates.h"

#include <gtest/gtest.h>

#include <cmath>
#include <deque>
#include <map>

#include "ch5_backend/marginalize/marginalize.h"
#include "ch5_backend/simulate/random.h"
#include "ch5_backend/sparse/sparse_optimizer.h"
#include "ch5_backend/types/pose_graph/edge_between.h"
#include "ch5_backend/types/pose_graph/edge_sensor.h"

namespace ch5 {
namespace {

constexpr double kStepSigma = 0.05, kTurnSigma = 0.03, kPointSigma = 0.2;  // [m, rad, m]

enum class Keeps { kAll, kLag, kLagHeld };

// A robot on a winding circle that sees points within 8 m. What it has not seen for ten poses leaves, unless it keeps all.
class Drive {
 public:
  explicit Drive(Keeps keeps) : keeps_(keeps) {
    Random random(1);
    for (int k = 0; k < 400; ++k) points_.emplace_back(NormalVector<2>(&random, 15.0));
    poses_.push_back(std::make_shared<VertexSE2>(Vec2(15, 0), M_PI / 2));
    graph_.AddVertex(poses_.back());
    AddEdge(std::make_shared<EdgePrior>(
        Prior{{poses_.back()}, {poses_.back()->Parameters()}, 100.0 * Mat33::Identity(), Vec3::Zero()}));
    See();
  }

  // @return where the robot is estimated
  Vec2 Step() {
    ++step_;
    const double turn = 1.0 / 15.0 + 0.15 * std::sin(0.1 * step_);
    p_ += Vec2(std::cos(theta_), std::sin(theta_));
    theta_ += turn;
    const Vec3 z = Vec3(1, 0, turn) + Vec3(kStepSigma, kStepSigma, kTurnSigma).cwiseProduct(NormalVector(&random_, 1));
    const auto& before = poses_.back();
    const auto pose = std::make_shared<VertexSE2>(before->p() + Eigen::Rotation2Dd(before->Theta()) * z.head<2>(),
                                                  before->Theta() + z[2]);
    graph_.AddVertex(pose);
    const auto between = std::make_shared<EdgeSE2Between>(before, pose, Vec2(z.head<2>()), z[2]);
    between->SetInformation(MatXX(Vec3(kStepSigma, kStepSigma, kTurnSigma).cwiseAbs2().cwiseInverse().asDiagonal()));
    AddEdge(between);
    poses_.push_back(pose);
    See();
    SolveOptions options;
    options.algorithm = Algorithm::kGaussNewton;
    options.cost_tolerance = 1e-10;
    SparseOptimizer(&graph_).Solve(options);
    Leave();
    return poses_.back()->p();
  }

 private:
  void AddEdge(std::shared_ptr<Edge> edge) { graph_.AddEdge(keeps_ == Keeps::kLagHeld ? first_.Hold(edge) : edge); }

  void See() {
    for (size_t k = 0; k < points_.size(); ++k) {
      const Vec2 p_B = Eigen::Rotation2Dd(-theta_) * (points_[k] - p_);
      if (p_B.norm() > 8.0) continue;
      const Vec2 z = p_B + NormalVector<2>(&random_, kPointSigma);
      const VertexSE2& pose = *poses_.back();
      auto& [point, last] = seen_[k];
      last = step_;
      if (!point) {
        point = std::make_shared<VertexPointXY>(pose.p() + Eigen::Rotation2Dd(pose.Theta()) * z);
        if (keeps_ != Keeps::kAll) point->SetRole(Role::kPose);
        graph_.AddVertex(point);
      }
      const auto edge = std::make_shared<EdgePointXY>(poses_.back(), point, z);
      edge->SetIsotropicInformation(1.0 / (kPointSigma * kPointSigma));
      AddEdge(edge);
    }
  }

  void Leave() {
    std::vector<std::shared_ptr<Vertex>> drop;
    if (poses_.size() > 10) {
      drop.push_back(poses_.front());
      poses_.pop_front();
    }
    for (auto it = seen_.begin(); it != seen_.end();) {
      const bool leaves = it->second.second <= step_ - 10;
      if (leaves) drop.push_back(it->second.first);
      it = leaves ? seen_.erase(it) : std::next(it);
    }
    if (keeps_ == Keeps::kAll || drop.empty()) return;
    keeps_ == Keeps::kLag ? MarginalizeInto(&graph_, drop) : first_.MarginalizeInto(&graph_, drop);
  }

  Keeps keeps_;
  std::vector<Vec2> points_;
  Random random_{2};
  Graph graph_;
  FirstEstimates first_;
  std::deque<std::shared_ptr<VertexSE2>> poses_;
  std::map<size_t, std::pair<std::shared_ptr<VertexPointXY>, int>> seen_;  // and in which step last
  Vec2 p_{15, 0};
  double theta_ = M_PI / 2;
  int step_ = 0;
};

// Without them yaw is learned that nothing has measured, and the window drifts off by decimeters.
TEST(FirstEstimates, KeepTheNewestPoseWhereTheBatchHasIt) {
  Drive batch(Keeps::kAll), lag(Keeps::kLag), held(Keeps::kLagHeld);
  double lag_off = 0.0, held_off = 0.0;
  for (int k = 0; k < 150; ++k) {
    const Vec2 p = batch.Step();
    lag_off = std::max(lag_off, (lag.Step() - p).norm());
    held_off = std::max(held_off, (held.Step() - p).norm());
  }
  RecordProperty("lag", std::to_string(lag_off));
  RecordProperty("held", std::to_string(held_off));
  EXPECT_LT(held_off, 0.05);
  EXPECT_GT(lag_off, 10.0 * held_off);
}

TEST(FirstEstimates, AreThePresentStatesBeforeAnythingHasLeft) {
  FirstEstimates first;
  Graph plain, held;
  for (Graph* graph : {&plain, &held}) {
    const auto a = std::make_shared<VertexSE2>(Vec2(1, 2), 0.3), b = std::make_shared<VertexSE2>(Vec2(2, 2), 0.5);
    graph->AddVertex(a);
    graph->AddVertex(b);
    const std::shared_ptr<Edge> edge = std::make_shared<EdgeSE2Between>(a, b, Vec2(1, 0), 0.1);
    graph->AddEdge(graph == &held ? first.Hold(edge) : edge);
    graph->Edges()[0]->Linearize();
  }
  EXPECT_EQ(held.Edges()[0]->Residual(), plain.Edges()[0]->Residual());
  for (size_t i = 0; i < 2; ++i) EXPECT_EQ(held.Edges()[0]->Jacobian(i), plain.Edges()[0]->Jacobian(i));
}

}  // namespace
}  // namespace ch5
