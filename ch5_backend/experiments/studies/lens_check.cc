#include "ch5_backend/experiments/studies/lens_check.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include "ch5_backend/graph/auto_diff_edge.h"
#include "ch5_backend/math/median.h"
#include "ch5_backend/sparse/sparse_optimizer.h"
#include "ch5_backend/types/inertial/preintegration.h"
#include "ch5_backend/types/vertices.h"

namespace ch5 {
namespace {

constexpr double kSigma = 3e-3;  // [rad]: a pixel and a half

// From C_i to C_j by the gyroscope at no bias:  R(b, τ) = Exp(−τ ω_i) R Exp(J b + τ ω_j),  τ being a delay.
struct GyroscopeTurn {
  Mat33 R, J;
  Vec3 rate_i, rate_j, theta;
};

struct ImagePair {
  GyroscopeTurn turn;
  std::vector<std::pair<Vec2, Vec2>> points;
};

// r = t·(f_i × R f_j) / ‖t × R f_j‖, the sine of the angle between f_i and its epipolar plane; the second row keeps t of
// length one.
class EdgeBentRays
    : public AutoDiffEdge<EdgeBentRays, 2, VertexVector<4>, VertexScalar, VertexScalar, VertexScalar, VertexVector<3>> {
 public:
  EdgeBentRays(std::shared_ptr<VertexVector<4>> bias_delay, std::shared_ptr<VertexScalar> k,
               std::shared_ptr<VertexScalar> width, std::shared_ptr<VertexScalar> turn_gain,
               std::shared_ptr<VertexVector<3>> t, const GyroscopeTurn& turn, const std::pair<Vec2, Vec2>& points)
      : AutoDiffEdge(std::move(bias_delay), std::move(k), std::move(width), std::move(turn_gain), std::move(t)),
        turn_(turn),
        points_(points) {}

  template <typename T>
  Eigen::Matrix<T, 2, 1> Evaluate(const Eigen::Matrix<T, 4, 1>& bias_delay, const Eigen::Matrix<T, 1, 1>& k,
                                  const Eigen::Matrix<T, 1, 1>& width, const Eigen::Matrix<T, 1, 1>& turn_gain,
                                  const Eigen::Matrix<T, 3, 1>& t) const {
    using Vector = Eigen::Matrix<T, 3, 1>;
    const auto ray = [&](const Vec2& x) -> Vector {
      const T bend = k[0] * x.squaredNorm() + width[0] + 1.0;
      return Vector(bend * x.x(), bend * x.y(), T(1.0)).normalized();
    };
    const Vector turned_j =
        turn_.J * bias_delay.template head<3>() + turn_.rate_j * bias_delay[3] + turn_.theta * turn_gain[0];
    const Vector turned_i = turn_.rate_i * bias_delay[3];
    const Vector f_i = ray(points_.first), f_j = ray(points_.second);
    const Vector m = turn_.R * (f_j + turned_j.cross(f_j)), f = m - turned_i.cross(m), c = t.cross(f);
    using std::sqrt;
    // Narrower rays have less noise too, so that only errors relative to the width can be compared.
    return {-f_i.dot(c) / (sqrt(c.squaredNorm() + 1e-6) * (width[0] + 1.0)), t.squaredNorm() - 1.0};
  }
  std::string TypeInfo() const override { return "EdgeBentRays"; }

 private:
  GyroscopeTurn turn_;
  std::pair<Vec2, Vec2> points_;
};

std::optional<GyroscopeTurn> TurnBetween(const Recording& recording, double t0, double t1) {
  const std::vector<ImuSample> samples = SamplesBetween(recording.imu, t0, t1);
  if (samples.empty()) return std::nullopt;
  const Preintegration imu(samples, Vec3::Zero(), Vec3::Zero(), recording.calibration.noise);
  const Mat33 R_C_B = recording.calibration.T_B_C.q.conjugate().toRotationMatrix();
  const Mat33 R = R_C_B * imu.Gamma() * R_C_B.transpose();
  return GyroscopeTurn{R, R_C_B * imu.BiasJacobian().block<3, 3>(3, 3), R_C_B * samples.front().gyroscope,
                       R_C_B * samples.back().gyroscope, LogSO3(Qd(R))};
}

// The first later image from which the points, rotation taken out, have moved far enough.
std::optional<ImagePair> FindPair(const Recording& recording, size_t i, double delay) {
  constexpr double kLongest = 1.5;         // [s]
  constexpr double kLeastParallax = 0.04;  // [rad]
  constexpr size_t kFewest = 12;
  const std::vector<Image>& frames = recording.images;
  std::map<int, Vec2> first;
  for (const TrackedPoint& point : frames[i].tracks) first.emplace(point.id, point.x);
  for (size_t j = i + 1; j < frames.size() && frames[j].t - frames[i].t < kLongest; ++j) {
    const auto turn = TurnBetween(recording, frames[i].t + delay, frames[j].t + delay);
    ImagePair pair;
    std::vector<double> parallax;
    for (const TrackedPoint& point : frames[j].tracks) {
      const auto before = first.find(point.id);
      if (before == first.end() || !turn) continue;
      pair.points.emplace_back(before->second, point.x);
      const Vec3 f_i = before->second.homogeneous().normalized(), f_j = point.x.homogeneous().normalized();
      parallax.push_back(f_i.cross(turn->R * f_j).norm());
    }
    if (pair.points.size() < kFewest) return std::nullopt;
    if (Median(parallax) < kLeastParallax) continue;
    pair.turn = *turn;
    return pair;
  }
  return std::nullopt;
}

// The direction that is orthogonal to most of f_i × R f_j.
Vec3 FirstDirection(const ImagePair& pair) {
  constexpr double kWide = 0.02;  // [rad], for what bias and lens spoil
  Vec3 t = Vec3::Zero();          // at first all count alike
  for (int round = 0; round < 5; ++round) {
    Mat33 A = Mat33::Zero();
    for (const auto& [x_i, x_j] : pair.points) {
      const Vec3 n = x_i.homogeneous().normalized().cross(pair.turn.R * x_j.homogeneous().normalized());
      A += n * n.transpose() / (1.0 + std::pow(n.dot(t) / kWide, 2));
    }
    t = Eigen::SelfAdjointEigenSolver<Mat33>(A).eigenvectors().col(0);
  }
  return t;
}

using Unknowns = std::array<std::shared_ptr<VertexScalar>, 3>;

// The edges of pairs of images all over the recording; returns how many pairs there are.
size_t AddPairs(const Recording& recording, double delay, const std::shared_ptr<VertexVector<4>>& bias_delay,
                const Unknowns& unknowns, Graph* graph) {
  constexpr size_t kPairs = 50;
  size_t pairs = 0;
  for (size_t i = 0; i < recording.images.size(); i += std::max<size_t>(1, recording.images.size() / kPairs)) {
    const auto pair = FindPair(recording, i, delay);
    if (!pair) continue;
    ++pairs;
    const auto t = std::make_shared<VertexVector<3>>(FirstDirection(*pair));
    t->SetRole(Role::kLandmark);
    graph->AddVertex(t);
    for (const auto& points : pair->points) {
      graph->AddEdge(
          std::make_shared<EdgeBentRays>(bias_delay, unknowns[0], unknowns[1], unknowns[2], t, pair->turn, points));
      graph->Edges().back()->SetInformation(Mat22::Identity() / (kSigma * kSigma));
    }
  }
  return pairs;
}

}  // namespace

std::optional<Disagreement> FindDisagreement(const Recording& recording, double delay) {
  constexpr size_t kFewest = 10;
  Graph graph;
  const auto bias_delay = std::make_shared<VertexVector<4>>(VertexVector<4>::Estimate::Zero());
  graph.AddVertex(bias_delay);
  Unknowns unknowns;
  for (auto& unknown : unknowns) {
    unknown = std::make_shared<VertexScalar>(VertexScalar::Estimate(0.0));
    unknown->SetFixed();
    graph.AddVertex(unknown);
  }
  if (AddPairs(recording, delay, bias_delay, unknowns, &graph) < kFewest) return std::nullopt;
  const auto solve = [&](double width) {
    const auto loss = std::make_shared<CauchyLoss>(width);
    for (const auto& edge : graph.Edges()) edge->SetLossFunction(loss);
    SolveOptions options;
    options.max_iterations = 20;
    return SparseOptimizer(&graph).Solve(options).final_cost;
  };
  Disagreement result;
  const double n = static_cast<double>(graph.Edges().size());
  Cause* const found[] = {&result.lens, &result.focal, &result.gyroscope};
  for (size_t i = 0; i < unknowns.size(); ++i) {
    unknowns[i]->SetFixed(false);
    solve(15.0);  // so wide that a bias rejects nothing
    const double left = solve(3.0);
    const double value = unknowns[i]->GetEstimate()[0];
    unknowns[i]->SetEstimate(VertexScalar::Estimate(0.0));
    unknowns[i]->SetFixed();
    const double gain = solve(3.0) / left;  // from there, so that both are at one minimum
    *found[i] = {value, std::abs(value) / std::sqrt(n * std::max(gain - 1.0, 1e-9)), gain};
  }
  return result;
}

}  // namespace ch5
