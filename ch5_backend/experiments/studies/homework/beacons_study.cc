#include "ch5_backend/experiments/studies/homework/homework_study.h"

#include <Eigen/LU>
#include <cmath>
#include <vector>

#include "ch5_backend/files/tables/csv.h"
#include "ch5_backend/open_tasks/open_tasks.h"
#include "ch5_backend/simulate/random.h"
#include "ch5_backend/sparse/sparse_solver.h"
#include "ch5_backend/types/edge_se3_prior.h"

namespace ch5 {
namespace {

constexpr int kKeyframes = 12, kStepsBetween = 100;
constexpr double kDt = 0.005;                      // [s]
constexpr double kSigmaA = 0.05, kSigmaG = 0.005;  // [m/s²/√Hz], [rad/s/√Hz]: a poor IMU
constexpr double kSigmaPixel = 0.005, kSigmaRange = 0.05;
const Vec3 kGravity(0, 0, -9.81), kAntenna(0.2, 0, 0.1);
const Transform kCamera{Qd(0.5, -0.5, 0.5, -0.5), Vec3(0.1, 0, 0)};  // looks along the body's x

// A circle of 3 m in 8 s; the body's x points outward.
constexpr double kRadius = 3.0, kRate = 2.0 * M_PI / 8.0;
Transform PoseAt(double t) {
  const double turn = kRate * t;
  return {ExpSO3(Vec3(0, 0, turn)),
          Vec3(kRadius * std::cos(turn), kRadius * std::sin(turn), 0.3 * std::sin(2.0 * turn))};
}
Vec3 VelocityAt(double t) {
  const double turn = kRate * t;
  return kRate * Vec3(-kRadius * std::sin(turn), kRadius * std::cos(turn), 0.6 * std::cos(2.0 * turn));
}
Vec3 AccelerationAt(double t) {
  const double turn = kRate * t;
  return -kRate * kRate * Vec3(kRadius * std::cos(turn), kRadius * std::sin(turn), 1.2 * std::sin(2.0 * turn));
}

// A point seen by the camera, with the Jacobians of 8b.
class EdgeView : public SizedEdge<2, VertexPointXYZ, VertexPose> {
 public:
  EdgeView(std::shared_ptr<VertexPointXYZ> p_W, std::shared_ptr<VertexPose> T_W_B, const Vec2& u)
      : SizedEdge(std::move(p_W), std::move(T_W_B)), u_(u) {
    SetInformation(Mat22::Identity() / (kSigmaPixel * kSigmaPixel));
  }
  void ComputeResidual() override {
    const VertexPose& pose = GetVertex<1>();
    const Vec3 p_B = pose.q().conjugate() * (GetVertex<0>().GetEstimate() - pose.p());
    r_ = (kCamera.q.conjugate() * (p_B - kCamera.p)).hnormalized() - u_;
  }
  void ComputeJacobians() override {
    const VertexPose& pose = GetVertex<1>();
    const ProjectionJacobians linear = LinearizeProjection({pose.q(), pose.p()}, kCamera, GetVertex<0>().GetEstimate());
    J<0>() = linear.point;
    J<1>() = linear.pose;
  }
  std::string TypeInfo() const override { return "EdgeView"; }

 private:
  Vec2 u_;
};

struct Guess {
  Transform T_W_B;
  Mat66 information;  // of [δθ, δp], as EdgeSE3Prior has them
};

// Dead reckoning by 8c, from a known start. (The guesses share their errors; here each counts as if it were independent.)
std::vector<Guess> GuessPath(Random* random) {
  const Transform start = PoseAt(0.0);
  const Vec3 v0 = VelocityAt(0.0);
  const double sigma_a = kSigmaA / std::sqrt(kDt), sigma_g = kSigmaG / std::sqrt(kDt);
  ImuIncrement sum;
  std::vector<Guess> guesses;
  for (int k = 1; k < kKeyframes * kStepsBetween; ++k) {
    const double now = k * kDt, middle = now - 0.5 * kDt;
    const Vec3 a = PoseAt(middle).q.conjugate() * (AccelerationAt(middle) - kGravity) + NormalVector(random, sigma_a);
    const Vec3 w = Vec3(0, 0, kRate) + NormalVector(random, sigma_g);
    sum = IntegrateImu(sum, a, w, kDt, kSigmaA, kSigmaG);
    if (k % kStepsBetween != 0) continue;
    // p = p₀ + v₀ t + ½ g t² + R₀ Δp,  R = R₀ ΔR
    const Transform T{start.q * sum.q, start.p + now * v0 + 0.5 * now * now * kGravity + start.q * sum.p};
    const Mat33 R0 = start.q.toRotationMatrix();
    Mat66 covariance;
    covariance << sum.covariance.block<3, 3>(3, 3), sum.covariance.block<3, 3>(3, 0) * R0.transpose(),
        R0 * sum.covariance.block<3, 3>(0, 3), R0 * sum.covariance.block<3, 3>(0, 0) * R0.transpose();
    guesses.push_back({T, covariance.inverse()});
  }
  return guesses;
}

struct Flight {
  Graph graph;
  std::vector<std::shared_ptr<VertexPose>> poses;
};

void BuildFlight(Flight* flight) {
  Random random(11);
  for (const Guess& guess : GuessPath(&random)) {
    const auto pose = std::make_shared<VertexPose>(guess.T_W_B.q, guess.T_W_B.p);
    flight->poses.push_back(pose);
    flight->graph.AddVertex(pose);
    const auto prior = std::make_shared<EdgeSE3Prior>(pose, guess.T_W_B.q, guess.T_W_B.p);
    prior->SetInformation(guess.information);
    flight->graph.AddEdge(prior);
  }
  const auto truth = [](size_t k) { return PoseAt((static_cast<double>(k) + 1.0) * kStepsBetween * kDt); };
  const std::vector<Vec3> beacons{{6, 0, 2}, {-4, 5, 0}, {-3, -5, 3}};
  for (size_t k = 0; k < flight->poses.size(); ++k) {
    const Transform T = truth(k);
    for (const Vec3& beacon : beacons) {
      const double range = (T.p + T.q * kAntenna - beacon).norm() + kSigmaRange * random.Normal();
      const auto edge = std::make_shared<EdgeRange>(flight->poses[k], kAntenna, beacon, range);
      edge->SetInformation(MatXX::Constant(1, 1, 1.0 / (kSigmaRange * kSigmaRange)));
      flight->graph.AddEdge(edge);
    }
  }
  for (int l = 0; l < 80; ++l) {  // on a wall around the circle
    const double angle = random.Uniform(0.0, 2.0 * M_PI), distance = random.Uniform(6.0, 9.0);
    const Vec3 p_W(distance * std::cos(angle), distance * std::sin(angle), random.Uniform(-2.0, 2.0));
    const auto point = std::make_shared<VertexPointXYZ>(p_W + NormalVector(&random, 0.3));
    std::vector<std::shared_ptr<Edge>> views;
    for (size_t k = 0; k < flight->poses.size(); ++k) {
      const Transform T = truth(k);
      const Vec3 p_C = kCamera.q.conjugate() * (T.q.conjugate() * (p_W - T.p) - kCamera.p);
      const Vec2 noise = kSigmaPixel * NormalVector(&random, 1.0).head<2>();
      if (p_C.z() < 1.0 || p_C.hnormalized().norm() > 1.0) continue;
      views.push_back(std::make_shared<EdgeView>(point, flight->poses[k], p_C.hnormalized() + noise));
    }
    if (views.size() < 2) continue;
    flight->graph.AddVertex(point);
    for (const auto& view : views) flight->graph.AddEdge(view);
  }
}

// Levenberg–Marquardt, in which 8a decides.
CsvTable Solve(Graph* graph) {
  SparseSolver solver(graph);
  solver.SetOrdering();
  double cost = solver.Cost(), nu = 2.0;
  solver.MakeHessian();
  double lambda = 1e-6 * solver.HessianDiagonal().maxCoeff();
  CsvTable table("iteration,cost,lambda");
  table.Row(0, cost, lambda);
  VecX delta_x = VecX::Zero(solver.Size());
  for (int trial = 1; trial <= 25 && std::isfinite(lambda); ++trial) {
    if (!solver.SolveLinearSystem(lambda, &delta_x)) break;
    const double predicted = solver.ModelCostChange(delta_x);
    solver.UpdateStates(delta_x);
    const double trial_cost = solver.Cost();
    const DampingUpdate next = UpdateDamping(cost, trial_cost, predicted, lambda, nu);
    lambda = next.lambda;
    nu = next.nu;
    if (next.accepted) {
      cost = trial_cost;
      solver.MakeHessian();
    } else {
      solver.RollbackStates();
    }
    table.Row(trial, cost, lambda);
    if (predicted < 1e-6 * cost) break;
  }
  return table;
}

}  // namespace

void RunBeacons(const std::filesystem::path& csv) {
  Flight flight;
  BuildFlight(&flight);
  std::vector<Vec3> guessed;
  for (const auto& pose : flight.poses) guessed.push_back(pose->p());
  Solve(&flight.graph).Write(csv / "convergence.csv");
  CsvTable path("t_s,true_x_m,true_y_m,guess_x_m,guess_y_m,x_m,y_m");
  for (size_t k = 0; k < flight.poses.size(); ++k) {
    const double t = (static_cast<double>(k) + 1.0) * kStepsBetween * kDt;
    const Vec3 truth = PoseAt(t).p, p = flight.poses[k]->p();
    path.Row(t, truth.x(), truth.y(), guessed[k].x(), guessed[k].y(), p.x(), p.y());
  }
  path.Write(csv / "path.csv");
}

}  // namespace ch5
