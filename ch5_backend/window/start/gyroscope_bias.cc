#include "ch5_backend/window/start/gyroscope_bias.h"

#include <cmath>
#include <random>
#include <unordered_map>

#include "ch5_backend/graph/sized_edge.h"
#include "ch5_backend/sparse/sparse_optimizer.h"
#include "ch5_backend/types/vertices.h"

namespace ch5 {
namespace {

// A unit vector t; it moves by t ← (t + B δ)/‖·‖, the columns of B being orthogonal to it.
class VertexDirection : public SizedVertex<3, 2> {
 public:
  explicit VertexDirection(const Vec3& t) : SizedVertex(t, Role::kLandmark) {}
  Eigen::Matrix<double, 3, 2> Basis() const {
    Eigen::Matrix<double, 3, 2> B;
    B.col(0) = x_.unitOrthogonal();
    B.col(1) = x_.cross(B.col(0));
    return B;
  }
  void Plus(const double* delta) override { x_ = (x_ + Basis() * Eigen::Map<const Vec2>(delta)).normalized(); }
  std::string TypeInfo() const override { return "VertexDirection"; }
};

// The rotation between two frames by the gyroscope, and its derivative by the bias.
struct RelativeRotation {
  Qd gamma = Qd::Identity();
  Mat33 J = Mat33::Zero();
};

// The same at a bias, for all edges between the two frames: what costs sines is worked out once.
class BiasedRotation {
 public:
  // R = γ Exp(J b), and its derivative by b,  R Hat(J_r J δb),  as the two factors of J_r J.
  struct Values {
    Mat33 R, right_jacobian, J;
  };
  explicit BiasedRotation(RelativeRotation rotation) : rotation_(std::move(rotation)) { Compute(Vec3::Zero()); }
  const Values& At(const Vec3& delta_b) {
    if (delta_b != delta_b_) Compute(delta_b);
    return values_;
  }

 private:
  void Compute(const Vec3& delta_b) {
    delta_b_ = delta_b;
    const Vec3 phi = rotation_.J * delta_b;
    values_ = {(rotation_.gamma * ExpSO3(phi)).toRotationMatrix(), RightJacobianSO3(phi), rotation_.J};
  }

  RelativeRotation rotation_;
  Vec3 delta_b_;
  Values values_;
};

// γ_ij = Π γ_k,  J_ij = Σ γ_{k+1…j}ᵀ J_k.
RelativeRotation RelativeRotationBetween(const std::vector<Preintegration>& imu, size_t i, size_t j) {
  RelativeRotation rotation;
  for (size_t k = i; k < j; ++k) {
    rotation.gamma = rotation.gamma * imu[k].Gamma();
    rotation.J = imu[k].Gamma().toRotationMatrix().transpose() * rotation.J + imu[k].BiasJacobian().block<3, 3>(3, 3);
  }
  return rotation;
}

// r = nᵀ R m_j,  n = c/√(‖c‖² + ε²),  c = t × m_i: the sine of the angle between a ray and its epipolar plane. Without
// the normalization, noise would count less where t is close to the rays, and every motion would seem to go straight ahead.
class EdgeEpipolar : public SizedEdge<1, VertexVector<3>, VertexDirection> {
 public:
  EdgeEpipolar(std::shared_ptr<VertexVector<3>> bias, std::shared_ptr<VertexDirection> direction,
               std::shared_ptr<BiasedRotation> rotation, const Vec3& m_i, const Vec3& m_j)
      : SizedEdge(std::move(bias), std::move(direction)), rotation_(std::move(rotation)), m_i_(m_i), m_j_(m_j) {}
  void ComputeResidual() override {
    const Vec3 c = this->c();
    r_[0] = c.dot(Rotation().R * m_j_) / Length(c);
  }
  void ComputeJacobians() override {
    const auto& [R, right_jacobian, J_b] = Rotation();
    const Vec3 c = this->c(), Rm_j = R * m_j_;
    const double s = Length(c);
    J<0>() = -(c.transpose() / s) * R * Hat(m_j_) * right_jacobian * J_b;
    const Vec3 dr_dc = Rm_j / s - c.dot(Rm_j) / (s * s * s) * c;
    J<1>() = -dr_dc.transpose() * Hat(m_i_) * GetVertex<1>().Basis();
  }
  std::string TypeInfo() const override { return "EdgeEpipolar"; }

 private:
  Vec3 c() const { return GetVertex<1>().GetEstimate().cross(m_i_); }
  // ε = 0.01: at the epipole there is no plane.
  static double Length(const Vec3& c) { return std::sqrt(c.squaredNorm() + 1e-4); }
  const BiasedRotation::Values& Rotation() const { return rotation_->At(GetVertex<0>().GetEstimate()); }

  std::shared_ptr<BiasedRotation> rotation_;
  Vec3 m_i_, m_j_;
};

// A point common to two images, as unit rays in their body frames.
struct Match {
  const FeatureTrack::View *i, *j;
  Vec3 m_i, m_j;
};

std::vector<Match> MatchesOf(const std::vector<FeatureTrack>& tracks, const Qd& R_B_C, int i, int j) {
  std::vector<Match> matches;
  for (const FeatureTrack& track : tracks) {
    const FeatureTrack::View *a = nullptr, *b = nullptr;
    for (const auto& view : track.views) {
      if (view.frame == i) a = &view;
      if (view.frame == j) b = &view;
    }
    if (!a || !b) continue;
    matches.push_back({a, b, R_B_C * a->x.homogeneous().normalized(), R_B_C * b->x.homogeneous().normalized()});
  }
  return matches;
}

// The direction that is orthogonal to most of n = m_i × R m_j, by RANSAC: two of them give a candidate. The draws repeat
// from call to call.
Vec3 FindDirection(const std::vector<Match>& matches, const Qd& R, double tolerance) {
  constexpr int kDraws = 30;  // with 60 % outliers, one of them is very likely without any
  std::vector<Vec3> n;
  for (const Match& match : matches) n.push_back(match.m_i.cross(R * match.m_j));
  std::minstd_rand random;
  Vec3 best = Vec3::UnitX();
  double best_score = -1.0;
  for (int draw = 0; draw < kDraws; ++draw) {
    const Vec3 t = n[random() % n.size()].cross(n[random() % n.size()]).normalized();
    if (!(t.norm() > 0.5)) continue;  // the same match twice
    double score = 0.0;
    for (const Vec3& n_k : n) score += 1.0 / (1.0 + std::pow(t.dot(n_k) / tolerance, 2));
    if (score > best_score) {
      best = t;
      best_score = score;
    }
  }
  return best;
}

// The bias' graph: one vertex for it, one for the direction of each pair of images.
struct EpipolarGraph {
  Graph graph;
  std::shared_ptr<VertexVector<3>> delta_b = std::make_shared<VertexVector<3>>(Vec3::Zero());
  std::vector<std::pair<Match, std::shared_ptr<EdgeEpipolar>>> edges;
};

EpipolarGraph MakeGraph(const std::vector<FeatureTrack>& tracks, const std::vector<Preintegration>& imu,
                        const Qd& R_B_C, double sigma, double width) {
  constexpr size_t kLeastMatches = 6;  // a direction has two degrees of freedom; the other matches determine the bias
  const size_t frames = imu.size() + 1;
  const auto loss = std::make_shared<CauchyLoss>(width);
  EpipolarGraph g;
  g.graph.AddVertex(g.delta_b);
  for (size_t i = 0; i < frames; ++i) {
    for (size_t step = 1; i + step < frames; step *= 2) {  // short and long base lines; all pairs would be many more
      const auto matches = MatchesOf(tracks, R_B_C, static_cast<int>(i), static_cast<int>(i + step));
      if (matches.size() < kLeastMatches) continue;
      const RelativeRotation rotation = RelativeRotationBetween(imu, i, i + step);
      auto direction = std::make_shared<VertexDirection>(FindDirection(matches, rotation.gamma, width * sigma));
      const auto biased = std::make_shared<BiasedRotation>(rotation);
      g.graph.AddVertex(direction);
      for (const Match& match : matches) {
        auto edge = std::make_shared<EdgeEpipolar>(g.delta_b, direction, biased, match.m_i, match.m_j);
        edge->SetIsotropicInformation(1.0 / (sigma * sigma));
        edge->SetLossFunction(loss);
        g.graph.AddEdge(edge);
        g.edges.emplace_back(match, edge);
      }
    }
  }
  return g;
}

// Drops the views that are outliers (off the epipolar plane by more than 3 σ) in at least half of their pairs.
void RemoveOutliers(const EpipolarGraph& g, std::vector<FeatureTrack>* tracks) {
  std::unordered_map<const FeatureTrack::View*, int> votes;
  for (const auto& [match, edge] : g.edges) {
    edge->ComputeResidual();
    const int vote = edge->Chi2() < 9.0 ? 1 : -1;
    votes[match.i] += vote;
    votes[match.j] += vote;
  }
  for (FeatureTrack& track : *tracks) {
    std::vector<FeatureTrack::View> kept;
    for (const auto& view : track.views) {
      if (votes[&view] > 0) kept.push_back(view);
    }
    track.views = std::move(kept);
  }
}

}  // namespace

Vec3 EstimateGyroscopeBias(const Qd& R_B_C, double sigma, std::vector<FeatureTrack>* tracks,
                           std::vector<Preintegration>* imu) {
  Vec3 b_g = imu->front().BiasGyroscope();
  EpipolarGraph g;
  SolveOptions options;
  options.max_iterations = 6;  // the bias stands after three; the directions, which nobody asks for, go on creeping
  // First with a loss wide enough for a bias of 0.1 rad/s, then with one that suppresses outliers.
  for (const double width : {15.0, 3.0, 3.0}) {
    g = MakeGraph(*tracks, *imu, R_B_C, sigma, width);
    SparseOptimizer(&g.graph).Solve(options);  // with one thread: edges share their rotations
    b_g += g.delta_b->GetEstimate();
    for (Preintegration& interval : *imu) interval.Reintegrate(interval.BiasAccelerometer(), b_g);
  }
  RemoveOutliers(g, tracks);
  return b_g;
}

}  // namespace ch5
