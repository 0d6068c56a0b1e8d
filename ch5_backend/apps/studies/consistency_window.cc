#include "ch5_backend/apps/studies/consistency_window.h"

#include <Eigen/Cholesky>
#include <algorithm>

#include "ch5_backend/marginalize/marginalize.h"
#include "ch5_backend/solve/sparse_optimizer.h"

namespace ch5 {

ConsistencyWindow::ConsistencyWindow(const Calibration& calibration, double pixel_sigma, size_t size,
                                     const ConsistencyPolicy& policy, const StampedState& first, const MatXX& J_start)
    : calibration_(calibration), pixel_sigma_(pixel_sigma), size_(size), policy_(policy) {
  Vec9 v_ba_bg;
  v_ba_bg << first.v_W, first.b_a, first.b_g;
  frames_.push_back({0, first.t, std::make_shared<VertexPose>(first.T_W_B.q, first.T_W_B.p),
                     std::make_shared<VertexSpeedBias>(v_ba_bg), nullptr});
  const Frame& f = frames_.front();
  prior_ = std::make_shared<EdgePrior>(
      Prior{{f.pose, f.speed_bias}, {f.pose->Parameters(), f.speed_bias->Parameters()}, J_start, VecX::Zero(15)});
}

WindowAnswer ConsistencyWindow::AddFrame(const CameraFrame& image, const std::vector<ImuSample>& samples) {
  if (!samples.empty()) Predict(image, samples);
  for (const TrackedPoint& point : image.tracks) landmarks_[point.id].views.emplace_back(frames_.back().id, point.x);
  for (auto& [id, landmark] : landmarks_) {
    if (!landmark.point && landmark.views.size() >= 3) Triangulate(&landmark);
  }
  const auto edges = Linearised(MakeEdges());
  Solve(edges);
  const WindowAnswer answer = Answer(edges);
  if (frames_.size() > size_) Slide();
  return answer;
}

// q_j = q_i γ,  v_j = v_i − G t + R_i β,  p_j = p_i + v_i t − ½ G t² + R_i α
void ConsistencyWindow::Predict(const CameraFrame& image, const std::vector<ImuSample>& samples) {
  const Frame& last = frames_.back();
  const VertexSpeedBias& sb = *last.speed_bias;
  auto imu = std::make_shared<Preintegration>(samples.at(0), sb.b_a(), sb.b_g(), calibration_.noise);
  for (size_t k = 1; k < samples.size(); ++k) imu->Add(samples[k]);
  const double t = imu->SumDt();
  const Vec3 G = -calibration_.GravityInWorld();
  const Qd q = last.pose->q();
  Vec9 v_ba_bg = sb.GetEstimate();
  v_ba_bg.head<3>() += q * imu->Beta() - t * G;
  Frame next{
      last.id + 1, image.t,
      std::make_shared<VertexPose>(q * imu->Gamma(), last.pose->p() + t * sb.v() - 0.5 * t * t * G + q * imu->Alpha()),
      std::make_shared<VertexSpeedBias>(v_ba_bg), nullptr};
  next.imu = std::make_shared<EdgeImu>(last.pose, last.speed_bias, next.pose, next.speed_bias, imu, G);
  frames_.push_back(std::move(next));
}

// The depth d on the host's ray for which Σ ‖[1 0 −u; 0 1 −v](d y_d + y_0)‖² is least.
bool ConsistencyWindow::Triangulate(Landmark* landmark) const {
  const Transform& T_B_C = calibration_.T_B_C;
  const auto camera = [&](int id) {
    const VertexPose& pose = *At(id).pose;
    return Transform{pose.q() * T_B_C.q, pose.p() + pose.q() * T_B_C.p};
  };
  const Transform host = camera(landmark->views.front().first);
  const Vec3 f = landmark->views.front().second.homogeneous();
  double H = 0.0, b = 0.0, parallax = 0.0;
  for (size_t v = 1; v < landmark->views.size(); ++v) {
    const Transform T = camera(landmark->views[v].first);
    const Vec2 x = landmark->views[v].second;
    const Vec3 y_d = T.q.conjugate() * (host.q * f), y_0 = T.q.conjugate() * (host.p - T.p);
    const Vec2 A = y_d.head<2>() - x * y_d.z(), c = y_0.head<2>() - x * y_0.z();
    H += A.squaredNorm();
    b -= A.dot(c);
    parallax = std::max(parallax, y_d.normalized().cross(x.homogeneous().normalized()).norm());
  }
  const double depth = b / H;
  constexpr double kLeastParallax = 0.05;  // [rad]; below, a point is not yet Gaussian
  if (!(parallax > kLeastParallax && depth > 0.3 && depth < 50.0)) return false;
  landmark->point = std::make_shared<VertexPointXYZ>(host.p + depth * (host.q * f));
  return true;
}

std::vector<std::shared_ptr<Edge>> ConsistencyWindow::EdgesOf(const Landmark& landmark) const {
  const double w = calibration_.fx / pixel_sigma_;
  std::vector<std::shared_ptr<Edge>> edges;
  if (!landmark.point) return edges;
  for (const auto& [frame, x] : landmark.views) {
    edges.push_back(std::make_shared<EdgeReprojectionXYZ>(landmark.point, At(frame).pose, x, calibration_.T_B_C));
    edges.back()->SetInformation(w * w * Mat22::Identity());
  }
  return edges;
}

std::vector<std::shared_ptr<Edge>> ConsistencyWindow::MakeEdges() const {
  std::vector<std::shared_ptr<Edge>> edges{prior_};
  for (size_t k = 1; k < frames_.size(); ++k) edges.push_back(frames_[k].imu);
  for (const auto& [id, landmark] : landmarks_) {
    for (auto& edge : EdgesOf(landmark)) edges.push_back(std::move(edge));
  }
  return edges;
}

// As a solve sees them.
std::vector<std::shared_ptr<Edge>> ConsistencyWindow::Linearised(std::vector<std::shared_ptr<Edge>> edges) const {
  if (policy_.first_estimates != FirstEstimates::kFull) return edges;
  for (auto& edge : edges) edge = std::make_shared<EdgeFirstEstimate>(edge, &prior_->GetPrior());
  return edges;
}

void ConsistencyWindow::Solve(const std::vector<std::shared_ptr<Edge>>& edges) const {
  Graph graph;
  for (const Frame& frame : frames_) {
    graph.AddVertex(frame.pose);
    graph.AddVertex(frame.speed_bias);
  }
  for (const auto& [id, landmark] : landmarks_) {
    if (landmark.point) graph.AddVertex(landmark.point);
  }
  for (const auto& edge : edges) graph.AddEdge(edge);
  SolveOptions options;  // Jacobians of first estimates need not go downhill at each step
  options.algorithm = Algorithm::kGaussNewton;
  options.max_iterations = 6;
  SparseOptimizer(&graph).Solve(options);
}

WindowAnswer ConsistencyWindow::Answer(const std::vector<std::shared_ptr<Edge>>& edges) const {
  const Frame& newest = frames_.back();
  std::vector<std::shared_ptr<Vertex>> landmarks;
  for (const auto& [id, landmark] : landmarks_) {
    if (landmark.point) landmarks.push_back(landmark.point);
  }
  const MarginalSystem system = EliminateVertices(edges, landmarks);
  const VecX p_inverse = ScalingOf(system.H).cwiseInverse();
  const Eigen::LDLT<MatXX> ldlt(p_inverse.asDiagonal() * system.H * p_inverse.asDiagonal());
  Eigen::Index row = 0;
  for (const auto& vertex : system.kept) {
    if (vertex == newest.pose) break;
    row += vertex->LocalDimension();
  }
  MatXX columns = MatXX::Zero(system.H.rows(), 6);
  columns.middleRows<6>(row).diagonal() = p_inverse.segment<6>(row);
  WindowAnswer answer;
  answer.pose_covariance = p_inverse.segment<6>(row).asDiagonal() * ldlt.solve(columns).middleRows<6>(row);
  answer.state = {newest.t,
                  {newest.pose->q(), newest.pose->p()},
                  newest.speed_bias->v(),
                  newest.speed_bias->b_a(),
                  newest.speed_bias->b_g()};
  return answer;
}

void ConsistencyWindow::Slide() {
  const Frame oldest = frames_.front();
  std::vector<std::shared_ptr<Vertex>> drop{oldest.pose, oldest.speed_bias};
  std::vector<std::shared_ptr<Edge>> edges{prior_, frames_[1].imu};
  for (auto it = landmarks_.begin(); it != landmarks_.end();) {
    Landmark& landmark = it->second;
    if (landmark.views.front().first != oldest.id) {
      ++it;
      continue;
    }
    const bool had_depth = landmark.point != nullptr;
    for (auto& edge : EdgesOf(landmark)) edges.push_back(std::move(edge));
    if (had_depth) drop.push_back(landmark.point);
    landmark.point = nullptr;
    landmark.views.erase(landmark.views.begin());
    if (had_depth && !policy_.reuse_observations) landmark.views.clear();
    it = landmark.views.empty() ? landmarks_.erase(it) : std::next(it);
  }
  Prior next;
  {
    const bool freeze = policy_.first_estimates != FirstEstimates::kNone;
    const MovedVertices at_linearisation(freeze ? &prior_->GetPrior() : nullptr);
    next = Marginalize(edges, drop);
  }
  prior_ = std::make_shared<EdgePrior>(std::move(next));
  frames_.erase(frames_.begin());
  for (auto& [id, landmark] : landmarks_) {
    if (!landmark.point && landmark.views.size() >= 3) Triangulate(&landmark);
  }
}

}  // namespace ch5
