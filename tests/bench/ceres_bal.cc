#include <algorithm>
#include <cmath>

#include "tests/bench/ceres_solve.h"

namespace ch5::peer {
namespace {

// The residual of types/bal/edge_bal.h, its rotation by Rodrigues' formula, its derivatives worked out by hand.
class Observation : public ceres::SizedCostFunction<2, 9, 3> {
 public:
  explicit Observation(const Vec2& pixel) : pixel_(pixel) {}

  bool Evaluate(double const* const* x, double* residuals, double** jacobians) const override {
    const Eigen::Map<const Vec9> camera(x[0]);
    const Eigen::Map<const Vec3> X(x[1]);
    const Vec3 omega = camera.head<3>();
    // R = I + a[ω] + b[ω]²,  J_l = I + b[ω] + c[ω]²
    const double square = omega.squaredNorm(), angle = std::sqrt(square);
    const bool tiny = angle < 1e-6;
    const double sine = std::sin(angle), a = tiny ? 1.0 : sine / angle;
    const double b = tiny ? 0.5 : (1.0 - std::cos(angle)) / square;
    const Vec3 wX = omega.cross(X), wwX = omega.cross(wX);
    const Vec3 RX = X + a * wX + b * wwX;
    const Vec3 P = RX + camera.segment<3>(3);
    const double z_inverse = -1.0 / P.z(), f = camera[6], k1 = camera[7], k2 = camera[8];
    const Vec2 p = P.head<2>() * z_inverse;
    const double n = p.squaredNorm(), d = 1.0 + n * (k1 + n * k2);
    Eigen::Map<Vec2>{residuals} = f * d * p - pixel_;
    if (!jacobians) return true;

    const double e = 2.0 * f * (k1 + 2.0 * k2 * n);
    Mat23 du_dP;
    du_dP << f * d + e * p.x() * p.x(), e * p.x() * p.y(), 0.0, e * p.x() * p.y(), f * d + e * p.y() * p.y(), 0.0;
    du_dP.col(2) = du_dP.leftCols<2>() * p;
    du_dP *= z_inverse;
    // A (I + b[ω] + c[ω]²) by cross products of A's rows.
    const auto times = [&](const Mat23& A, double b1, double b2) -> Mat23 {
      const Mat23 A_w = RowsCross(A, omega);
      return A + b1 * A_w + b2 * RowsCross(A_w, omega);
    };
    if (jacobians[0]) {
      const double c = tiny ? 1.0 / 6.0 : (1.0 - a) / square;
      Eigen::Map<RowMajor<2, 9>> J(jacobians[0]);
      J.leftCols<3>() = times(RowsCross(du_dP, -RX), b, c);
      J.middleCols<3>(3) = du_dP;
      J.col(6) = d * p;
      J.col(7) = f * n * p;
      J.col(8) = f * n * n * p;
    }
    if (jacobians[1]) Eigen::Map<RowMajor<2, 3>>{jacobians[1]} = times(du_dP, a, b);
    return true;
  }

 private:
  Vec2 pixel_;
};

// VertexPointOnRay as a manifold: a step moves the point along its ray from the anchor; ∂x/∂δ = I.
class OnRay : public ceres::Manifold {
 public:
  explicit OnRay(const Vec3& anchor) : anchor_(anchor) {}
  int AmbientSize() const override { return 3; }
  int TangentSize() const override { return 3; }
  bool Plus(const double* x, const double* delta, double* x_plus_delta) const override {
    constexpr double kFarthest = 20.0;
    const Vec3 v = Eigen::Map<const Vec3>(x) - anchor_, d = Eigen::Map<const Vec3>(delta);
    const double v2 = v.squaredNorm(), q = v2 > 0.0 ? v.dot(d) / v2 : 0.0;
    Eigen::Map<Vec3>{x_plus_delta} = anchor_ + (v + d - q * v) / std::max(1.0 - q, 1.0 / kFarthest);
    return true;
  }
  bool PlusJacobian(const double*, double* J) const override {
    Eigen::Map<RowMajor<3, 3>>{J}.setIdentity();
    return true;
  }
  bool Minus(const double*, const double*, double*) const override { return false; }
  bool MinusJacobian(const double*, double*) const override { return false; }

 private:
  Vec3 anchor_;
};

// From the farthest camera that sees it, as BuildBal does.
void PutOnRays(const BalProblem& start, BalProblem* states, ceres::Problem* problem) {
  const std::vector<Vec3> anchors = FarthestCenters(start);
  for (size_t i = 0; i < anchors.size(); ++i) {
    double* point = states->points[i].data();
    if (problem->HasParameterBlock(point)) problem->SetManifold(point, new OnRay(anchors[i]));
  }
}

}  // namespace

PeerResult SolveBalWithCeres(const BalProblem& start, const PeerOptions& options) {
  BalProblem states = start;
  ceres::Problem problem;
  for (const BalObservation& seen : start.observations) {
    problem.AddResidualBlock(new Observation(seen.pixel), nullptr,
                             states.cameras[static_cast<size_t>(seen.camera)].data(),
                             states.points[static_cast<size_t>(seen.point)].data());
  }
  if (options.points == BalPoints::kOnRay) PutOnRays(start, &states, &problem);
  auto ordering = std::make_shared<ceres::ParameterBlockOrdering>();
  for (Vec3& point : states.points) {
    if (problem.HasParameterBlock(point.data())) ordering->AddElementToGroup(point.data(), 0);
  }
  for (Vec9& camera : states.cameras) {
    if (problem.HasParameterBlock(camera.data())) ordering->AddElementToGroup(camera.data(), 1);
  }
  return SolveWithCeres(options, ordering, &problem);
}

}  // namespace ch5::peer
