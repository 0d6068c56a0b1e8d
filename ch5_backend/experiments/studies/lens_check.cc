#include "ch5_backend/experiments/studies/lens_check.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
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

// From C_i to C_j by the gyroscope at a first guess of its bias:  R(b, τ) = Exp(−τ ω_i) R Exp(J b + τ ω_j),  τ being a delay.
struct GyroscopeTurn {
  Mat33 R, J;
  Vec3 rate_i, rate_j, theta;
  double age;  // from the recording's middle [s]
};

// What all pairs share; the cause is the number of a Disagreement's.
struct SharedUnknowns {
  std::shared_ptr<VertexVector<4>> bias_delay = std::make_shared<VertexVector<4>>(VertexVector<4>::Estimate::Zero());
  std::shared_ptr<VertexScalar> number = std::make_shared<VertexScalar>(VertexScalar::Estimate(0.0));
  std::shared_ptr<VertexVector<3>> vector = std::make_shared<VertexVector<3>>(Vec3::Zero());
  std::shared_ptr<size_t> cause = std::make_shared<size_t>(0);
};

using Points = std::pair<Vec2, Vec2>;  // the places of one in both images

struct ImagePair {
  GyroscopeTurn turn;
  std::vector<Points> points;

  // f_i and R f_j
  std::pair<Vec3, Vec3> Rays(const Points& x) const {
    return {x.first.homogeneous().normalized(), turn.R * x.second.homogeneous().normalized()};
  }
};

// What is wrong, as Disagreement has it: one of these is not zero.
template <typename T>
struct Wrong {
  T k{0.0}, width{0.0}, gain{0.0}, line{0.0};
  Eigen::Matrix<T, 3, 1> drift = Eigen::Matrix<T, 3, 1>::Zero(), turned = Eigen::Matrix<T, 3, 1>::Zero();
};

// r = t·(f_i × R f_j) / ‖t × R f_j‖, the sine of the angle between f_i and its epipolar plane; the second row keeps t of
// length one.
class EdgeBentRays
    : public AutoDiffEdge<EdgeBentRays, 2, VertexVector<4>, VertexScalar, VertexVector<3>, VertexVector<3>> {
 public:
  EdgeBentRays(const SharedUnknowns& shared, std::shared_ptr<VertexVector<3>> t, const GyroscopeTurn& turn,
               const Points& points)
      : AutoDiffEdge(shared.bias_delay, shared.number, shared.vector, std::move(t)),
        cause_(shared.cause),
        turn_(turn),
        points_(points) {}

  template <typename T>
  Eigen::Matrix<T, 2, 1> Evaluate(const Eigen::Matrix<T, 4, 1>& bias_delay, const Eigen::Matrix<T, 1, 1>& number,
                                  const Eigen::Matrix<T, 3, 1>& vector, const Eigen::Matrix<T, 3, 1>& t) const {
    using Vector = Eigen::Matrix<T, 3, 1>;
    Wrong<T> wrong;
    T* const numbers[] = {&wrong.k, &wrong.width, &wrong.gain, &wrong.line};
    Vector* const vectors[] = {&wrong.drift, &wrong.turned};
    if (*cause_ < 4) {
      *numbers[*cause_] = number[0];
    } else {
      *vectors[*cause_ - 4] = vector;
    }
    const auto ray = [&](const Vec2& x) -> Vector {
      const T bend = wrong.k * x.squaredNorm() + wrong.width + 1.0;
      return Vector(bend * x.x(), bend * x.y(), T(1.0)).normalized();
    };
    const auto delay = [&](const Vec2& x) -> T { return bias_delay[3] + wrong.line * x.y(); };
    const Vector bias = bias_delay.template head<3>() + wrong.drift * turn_.age;
    const auto& [x_i, x_j] = points_;
    const Vector turned_j = turn_.J * bias + turn_.rate_j * delay(x_j) + turn_.theta * wrong.gain - wrong.turned;
    const Vector turned_i = turn_.rate_i * delay(x_i) - wrong.turned;
    // Cayley's rotation: ρ about the axis of a turn changes nothing, and to first order alone would bend the rays.
    const auto rotate = [](const Vector& theta, const Vector& f) -> Vector {
      const Vector half = 0.5 * theta, moved = half.cross(f);
      return f + (moved + half.cross(moved)) * (2.0 / (half.squaredNorm() + 1.0));
    };
    const Vector f_i = ray(x_i), f_j = ray(x_j);
    const Vector f = rotate(-turned_i, turn_.R * rotate(turned_j, f_j)), c = t.cross(f);
    using std::sqrt;
    // Narrower rays have less noise too, so that only errors relative to the width can be compared.
    return {-f_i.dot(c) / (sqrt(c.squaredNorm() + 1e-6) * (wrong.width + 1.0)), t.squaredNorm() - 1.0};
  }
  std::string TypeInfo() const override { return "EdgeBentRays"; }

 private:
  std::shared_ptr<const size_t> cause_;
  GyroscopeTurn turn_;
  Points points_;
};

// What the pairs of a motion do not tell, such as a delay at a constant rate or a rotation about the only axis of all turns,
// stays near its guess: r = [τ/σ_τ, ρ/σ_ρ].
class EdgeNearGuess : public AutoDiffEdge<EdgeNearGuess, 4, VertexVector<4>, VertexVector<3>> {
 public:
  explicit EdgeNearGuess(const SharedUnknowns& shared) : AutoDiffEdge(shared.bias_delay, shared.vector) {}
  template <typename T>
  Eigen::Matrix<T, 4, 1> Evaluate(const Eigen::Matrix<T, 4, 1>& bias_delay,
                                  const Eigen::Matrix<T, 3, 1>& vector) const {
    constexpr double kDelay = 0.02, kVector = 0.1;  // [s], [rad] or [rad/s²]
    Eigen::Matrix<T, 4, 1> r;
    r << bias_delay[3] * (1.0 / kDelay), vector * (1.0 / kVector);
    return r;
  }
  std::string TypeInfo() const override { return "EdgeNearGuess"; }
};

std::optional<GyroscopeTurn> TurnBetween(const Recording& recording, const Vec3& bias, double t0, double t1) {
  const std::vector<ImuSample> samples = SamplesBetween(recording.imu, t0, t1);
  if (samples.empty()) return std::nullopt;
  const Preintegration imu(samples, Vec3::Zero(), bias, recording.calibration.noise);
  const Mat33 R_C_B = recording.calibration.T_B_C.q.conjugate().toRotationMatrix();
  const Mat33 R = R_C_B * imu.Gamma() * R_C_B.transpose();
  return GyroscopeTurn{R,
                       R_C_B * imu.BiasJacobian().block<3, 3>(3, 3),
                       R_C_B * samples.front().gyroscope,
                       R_C_B * samples.back().gyroscope,
                       LogSO3(Qd(R)),
                       t0 - 0.5 * (recording.imu.front().t + recording.imu.back().t)};
}

// The first later image from which the points, rotation taken out, have moved far enough.
std::optional<ImagePair> FindPair(const Recording& recording, size_t i, const VertexVector<4>::Estimate& bias_delay) {
  constexpr double kLongest = 1.5;         // [s]
  constexpr double kLeastParallax = 0.04;  // [rad]
  constexpr size_t kFewest = 12;
  const std::vector<Image>& frames = recording.images;
  std::map<int, Vec2> first;
  for (const TrackedPoint& point : frames[i].tracks) first.emplace(point.id, point.x);
  for (size_t j = i + 1; j < frames.size() && frames[j].t - frames[i].t < kLongest; ++j) {
    const auto turn =
        TurnBetween(recording, bias_delay.head<3>(), frames[i].t + bias_delay[3], frames[j].t + bias_delay[3]);
    if (!turn) return std::nullopt;
    ImagePair pair{*turn, {}};
    std::vector<double> parallax;
    for (const TrackedPoint& point : frames[j].tracks) {
      const auto before = first.find(point.id);
      if (before == first.end()) continue;
      pair.points.emplace_back(before->second, point.x);
      const auto [f_i, f_j] = pair.Rays(pair.points.back());
      parallax.push_back(f_i.cross(f_j).norm());
    }
    if (pair.points.size() < kFewest) return std::nullopt;
    if (Median(parallax) >= kLeastParallax) return pair;
  }
  return std::nullopt;
}

// The direction that is orthogonal to most of f_i × R f_j.
Vec3 FirstDirection(const ImagePair& pair) {
  constexpr double kWide = 0.02;  // [rad], for what bias and lens spoil
  Vec3 t = Vec3::Zero();          // at first all count alike
  for (int round = 0; round < 5; ++round) {
    Mat33 A = Mat33::Zero();
    for (const Points& points : pair.points) {
      const auto [f_i, f_j] = pair.Rays(points);
      const Vec3 n = f_i.cross(f_j);
      A += n * n.transpose() / ((n.squaredNorm() + kWide * kWide) * (1.0 + std::pow(n.dot(t) / kWide, 2)));
    }
    t = Eigen::SelfAdjointEigenSolver<Mat33>(A).eigenvectors().col(0);
  }
  return t;
}

// Which of the points lie so far from their epipolar planes that they are no measurement of them, whatever is wrong.
void RemoveOutliers(const Vec3& t, ImagePair* pair) {
  constexpr double kTimes = 5.0;  // the median
  const auto error = [&](const Points& points) {
    const auto [f_i, f_j] = pair->Rays(points);
    const Vec3 n = t.cross(f_j);
    return std::abs(f_i.dot(n)) / (n.norm() + 1e-3);
  };
  std::vector<double> errors;
  for (const Points& points : pair->points) errors.push_back(error(points));
  const double most = kTimes * Median(errors);
  const auto is_far = [&](const Points& points) { return error(points) > most; };
  pair->points.erase(std::remove_if(pair->points.begin(), pair->points.end(), is_far), pair->points.end());
}

// The pairs of images all over the recording, and what is unknown of them all together.
class RayProblem {
 public:
  // @return whether there are enough of them
  bool FindPairs(const Recording& recording, double delay) {
    constexpr size_t kFewest = 10;
    constexpr int kRounds = 3;
    // A bias looks like parallax: without it, pairs are found anew.
    VertexVector<4>::Estimate bias_delay(0.0, 0.0, 0.0, delay);
    for (int round = 0; round < kRounds; ++round) {
      graph_.Clear();
      shared_.bias_delay->SetEstimate(VertexVector<4>::Estimate::Zero());
      graph_.AddVertex(shared_.bias_delay);
      graph_.AddVertex(shared_.number);
      graph_.AddVertex(shared_.vector);
      graph_.AddEdge(std::make_shared<EdgeNearGuess>(shared_));
      Hold(true, true);
      if (AddPairs(recording, bias_delay) < kFewest) return false;
      if (round + 1 == kRounds) break;
      Solve(15.0);  // so wide that a bias rejects nothing
      bias_delay += shared_.bias_delay->GetEstimate();
      bias_delay[3] = delay;
    }
    return true;
  }

  // The next cause of a Disagreement alone.
  Cause Next() {
    const bool is_number = *shared_.cause < 4;
    Hold(!is_number, is_number);
    Solve(15.0);
    const double left = Solve(3.0);
    const double value = is_number ? shared_.number->GetEstimate()[0] : shared_.vector->GetEstimate().norm();
    shared_.number->SetEstimate(VertexScalar::Estimate(0.0));
    shared_.vector->SetEstimate(Vec3::Zero());
    Hold(true, true);
    const double gain = Solve(3.0) / left;  // from there, so that both are at one minimum
    ++*shared_.cause;
    const double n = static_cast<double>(graph_.Edges().size());
    return {value, std::abs(value) / std::sqrt(n * std::max(gain - 1.0, 1e-9)), gain};
  }

 private:
  // @return  how many there are
  size_t AddPairs(const Recording& recording, const VertexVector<4>::Estimate& bias_delay) {
    constexpr size_t kPairs = 50;
    size_t pairs = 0;
    for (size_t i = 0; i < recording.images.size(); i += std::max<size_t>(1, recording.images.size() / kPairs)) {
      auto pair = FindPair(recording, i, bias_delay);
      if (!pair) continue;
      ++pairs;
      const auto t = std::make_shared<VertexVector<3>>(FirstDirection(*pair));
      RemoveOutliers(t->GetEstimate(), &*pair);
      t->SetRole(Role::kLandmark);
      graph_.AddVertex(t);
      for (const auto& points : pair->points) {
        graph_.AddEdge(std::make_shared<EdgeBentRays>(shared_, t, pair->turn, points));
        graph_.Edges().back()->SetInformation(Mat22::Identity() / (kSigma * kSigma));
      }
    }
    return pairs;
  }

  void Hold(bool number, bool vector) {
    shared_.number->SetFixed(number);
    shared_.vector->SetFixed(vector);
  }

  double Solve(double width) {
    const auto loss = std::make_shared<CauchyLoss>(width);
    for (const auto& edge : graph_.Edges()) edge->SetLossFunction(loss);
    return SparseOptimizer(&graph_).Solve().final_cost;
  }

  Graph graph_;
  SharedUnknowns shared_;
};

}  // namespace

std::optional<Disagreement> FindDisagreement(const Recording& recording, double delay) {
  RayProblem problem;
  if (!problem.FindPairs(recording, delay)) return std::nullopt;
  Disagreement result;
  for (Cause* const found :
       {&result.lens, &result.focal, &result.gyroscope, &result.shutter, &result.drift, &result.rotation})
    *found = problem.Next();
  return result;
}

}  // namespace ch5
