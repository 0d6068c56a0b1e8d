#include "ch5_backend/window/start/closed_form.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <cmath>
#include <limits>

#include "ch5_backend/math/median.h"
#include "ch5_backend/math/so3.h"

namespace ch5 {
namespace {

double Square(double value) { return value * value; }

using Mat99 = Eigen::Matrix<double, 9, 9>;
using Mat39 = Eigen::Matrix<double, 3, 9>;

// A body's motion seen from B₀: p = P x + a, v = V x + u.
struct LinearMotion {
  Mat33 R = Mat33::Identity();
  Mat39 P = Mat39::Zero(), V = Mat39::Zero();
  Vec3 a = Vec3::Zero(), u = Vec3::Zero();
};

std::vector<LinearMotion> DeadReckon(const std::vector<Preintegration>& imu) {
  LinearMotion m;
  m.V.leftCols<3>().setIdentity();
  std::vector<LinearMotion> motion{m};
  for (const Preintegration& step : imu) {
    const double t = step.SumDt();
    const auto J = step.BiasJacobian();
    m.a += t * m.u + m.R * step.Alpha();
    m.u += m.R * step.Beta();
    m.P += t * m.V;
    m.P.middleCols<3>(3).diagonal().array() -= 0.5 * t * t;
    m.P.rightCols<3>() += m.R * J.block<3, 3>(0, 0);
    m.V.middleCols<3>(3).diagonal().array() -= t;
    m.V.rightCols<3>() += m.R * J.block<3, 3>(6, 0);
    m.R = m.R * step.Gamma().toRotationMatrix();
    motion.push_back(m);
  }
  return motion;
}

// The point of a track in the camera of one of its views, [y_d Y y_0] with  y = y_d d + Y x + y_0.
struct ViewEquation {
  Vec2 x_image;
  Eigen::Matrix<double, 3, 11> y;
  double weight;

  Vec3 At(double d, const Vec9& x) const { return y.col(0) * d + y.middleCols<9>(1) * x + y.col(10); }
  // The rows that are zero where the point is seen at x_image.
  Mat23 S() const {
    Mat23 S;
    S << 1, 0, -x_image.x(), 0, 1, -x_image.y();
    return S;
  }
};

using TrackEquations = std::vector<ViewEquation>;

TrackEquations MakeEquations(const FeatureTrack& track, const std::vector<LinearMotion>& motion,
                             const ClosedFormOptions& options, double weight) {
  const Transform& T_B_Ci = options.T_B_C;
  TrackEquations equations;
  const LinearMotion& i = motion[static_cast<size_t>(track.views.front().frame)];
  const Vec3 f_Bi = T_B_Ci.q * track.views.front().x.homogeneous();
  for (size_t v = 1; v < track.views.size(); ++v) {
    const LinearMotion& j = motion[static_cast<size_t>(track.views[v].frame)];
    const Transform& T_B_Cj = track.views[v].camera == 0 ? options.T_B_C : options.T_B_C1;
    const Mat33 R_Cj_B0 = (j.R * T_B_Cj.q.toRotationMatrix()).transpose();
    ViewEquation e;
    e.x_image = track.views[v].x;
    e.y << R_Cj_B0 * i.R * f_Bi, R_Cj_B0 * (i.P - j.P), R_Cj_B0 * (i.a + i.R * T_B_Ci.p - j.a - j.R * T_B_Cj.p);
    e.weight = weight;
    equations.push_back(e);
  }
  return equations;
}

// One track's part of the normal equations, in its depth d and x.
struct TrackSystem {
  double H_dd, b_d;
  Vec9 h;
  double Depth(const Vec9& x) const { return (b_d - h.dot(x)) / H_dd; }
};

// H, b of x with the track's depth eliminated:  H ← H − h hᵀ/H_dd,  b ← b − h b_d/H_dd.
//
// The noise of an observation enters its two rows times the point's depth z, the third row of y. What their squares hold of
// it, 2σ²z² on average, is least where all points are near, and would draw the scale to zero: it is taken off.
TrackSystem AddTrack(const TrackEquations& equations, double noise_variance, Mat99* H, Vec9* b) {
  Eigen::Matrix<double, 11, 11> squares = Eigen::Matrix<double, 11, 11>::Zero(), noise = squares;  // of [d x 1]
  for (const ViewEquation& e : equations) {
    const Eigen::Matrix<double, 2, 11> rows = e.S() * e.y;
    squares += e.weight * rows.transpose() * rows;
    noise += 2.0 * noise_variance * e.weight * e.y.row(2).transpose() * e.y.row(2);
  }
  const auto system = [](const Eigen::Matrix<double, 11, 11>& M) {
    return TrackSystem{std::max(M(0, 0), 1e-12), -M(0, 10), M.block<1, 9>(0, 1).transpose()};
  };
  const Eigen::Matrix<double, 11, 11> clean = squares - noise;
  if (!(clean(0, 0) > 0.1 * squares(0, 0))) return system(squares);  // a depth that is mostly noise: nothing on x
  const TrackSystem s = system(clean);
  *H += clean.block<9, 9>(1, 1) - s.h * s.h.transpose() / s.H_dd;
  *b -= clean.block<9, 1>(1, 10) + s.h * (s.b_d / s.H_dd);
  return s;
}

// σ of the largest displacement and of gravity's direction, by the inverse of the normal equations.
void ComputeUncertainty(const Mat99& H, const Vec9& x, const std::vector<LinearMotion>& motion, ClosedForm* result) {
  const Vec3 up = x.segment<3>(3).normalized();
  Mat99 H_on_sphere = H;  // ‖G‖ is known to 1 mm/s²
  H_on_sphere.block<3, 3>(3, 3) += 1e6 * up * up.transpose();
  const Eigen::LLT<MatXX> llt(H_on_sphere);
  result->scale_sigma = result->gravity_sigma = std::numeric_limits<double>::infinity();
  if (llt.info() != Eigen::Success) return;
  const MatXX covariance = llt.solve(MatXX::Identity(9, 9));
  const LinearMotion* farthest = &motion.front();
  const auto displacement = [&](const LinearMotion& m) -> Vec3 { return m.P * x + m.a; };
  for (const LinearMotion& m : motion) {
    if (displacement(m).norm() > displacement(*farthest).norm()) farthest = &m;
  }
  const double distance = displacement(*farthest).norm();
  if (!(distance > 0.0)) return;
  const Vec9 J = farthest->P.transpose() * displacement(*farthest) / distance;
  result->scale_sigma = std::sqrt(J.dot(covariance * J)) / distance;
  const Mat33 covariance_G = covariance.block<3, 3>(3, 3);
  result->gravity_sigma = std::sqrt(covariance_G.trace()) / x.segment<3>(3).norm();
}

}  // namespace

// With x_r the other six,  Y = H_rr⁻¹ H_rG,  y = H_rr⁻¹ b_r:  S = H_GG − H_Gr Y,  c = b_G − H_Gr y,  x_r = y − Y G.
Vec9 SolveWithGravityNorm(const Mat99& H, const Vec9& b, double g) {
  const std::array<int, 6> r{0, 1, 2, 6, 7, 8};
  const std::array<int, 3> G{3, 4, 5};
  const Eigen::LDLT<MatXX> H_rr(MatXX(H(r, r)));
  const MatXX H_rG = H(r, G);
  const MatXX Y = H_rr.solve(H_rG);
  const VecX y = H_rr.solve(VecX(b(r)));
  const MatXX S = H.block<3, 3>(3, 3) - H_rG.transpose() * Y;
  const Vec3 c = b.segment<3>(3) - H_rG.transpose() * y;

  const Eigen::SelfAdjointEigenSolver<MatXX> eigen(S);
  const Vec3 lambda = eigen.eigenvalues(), c_Q = eigen.eigenvectors().transpose() * c;
  const auto gravity = [&](double mu) -> Vec3 { return c_Q.array() / (lambda.array() + mu); };
  // ‖G(μ)‖ falls from ∞ at −λ_min to less than g at ‖c‖/g − λ_min.
  double low = -lambda[0], high = c.norm() / g - lambda[0];
  for (int k = 0; k < 200 && low < high; ++k) {
    const double middle = 0.5 * (low + high);
    if (middle <= low || middle >= high) break;
    (gravity(middle).norm() > g ? low : high) = middle;
  }
  const Vec3 best = eigen.eigenvectors() * gravity(high).normalized() * g;
  const Vec6 rest = y - Y * best;
  Vec9 x;
  x << rest.head<3>(), best, rest.tail<3>();
  return x;
}

namespace {

// While the scale is unknown the accelerometer's bias is held: free, it would rather explain the whole acceleration than
// let the points be as distant, and as noisy, as they are.
constexpr double kHeldBias = 0.01;

// The weights of the next iteration at the present solution: 1/(σ depth)² and Cauchy's loss of the given width. Appends the
// squared errors on the image plane.
void UpdateWeights(double sigma, double width, double track_depth, const Vec9& x, TrackEquations* equations,
                   std::vector<double>* squared_errors) {
  for (ViewEquation& e : *equations) {
    const Vec3 y = e.At(track_depth, x);
    const double depth = std::max(std::abs(y.z()), 0.1);
    const double error = (e.S() * y).norm() / depth;
    e.weight = 1.0 / (Square(sigma * depth) * (1.0 + Square(error / width)));
    squared_errors->push_back(Square(error));
  }
}

// The states in a frame whose z axis is up.
std::vector<StampedState> StatesOf(const std::vector<LinearMotion>& motion, const Vec9& x, const Vec3& b_g) {
  std::vector<StampedState> states;
  const Qd q_W_B0 = RotationBetween(x.segment<3>(3), Vec3::UnitZ());
  for (const LinearMotion& m : motion) {
    StampedState state;
    state.T_W_B = {(q_W_B0 * Qd(m.R)).normalized(), q_W_B0 * (m.P * x + m.a)};
    state.v_W = q_W_B0 * (m.V * x + m.u);
    state.b_a = x.tail<3>();
    state.b_g = b_g;
    states.push_back(state);
  }
  return states;
}

// The points' mean depth, by how well each is known, is as given:  Σ H_dd d / Σ H_dd,  d = (b_d − h·x) / H_dd.
void HoldMeanDepth(const std::vector<TrackSystem>& systems, double depth, Mat99* H, Vec9* b) {
  constexpr double kWeight = 1e4;  // [1/m²]
  Vec9 h = Vec9::Zero();
  double b_d = 0.0, H_dd = 0.0;
  for (const TrackSystem& s : systems) {
    h += s.h;
    b_d += s.b_d;
    H_dd += s.H_dd;
  }
  const Vec9 J = -h / H_dd;
  *H += kWeight * J * J.transpose();
  *b += kWeight * (depth - b_d / H_dd) * J;
}

// @param part  of the observations' variance that is taken off, see AddTrack: their own, but not more than σ²
ClosedForm Solve(const std::vector<FeatureTrack>& tracks, const std::vector<LinearMotion>& motion, const Vec3& b_g,
                 double part, const ClosedFormOptions& options) {
  constexpr int kIterations = 12;
  constexpr double kMedianOfTwo = 1.386;  // of χ² with two degrees of freedom
  double variance = Square(options.sigma);
  constexpr double kFirstDepth = 3.0;  // [m], for the weights of the first iteration only
  std::vector<TrackEquations> equations;
  for (const FeatureTrack& track : tracks) {
    equations.push_back(MakeEquations(track, motion, options, 1.0 / Square(options.sigma * kFirstDepth)));
  }

  ClosedForm result;
  result.depths.resize(tracks.size());
  Mat99 H;
  Vec9 x;
  for (int iteration = 0; iteration < kIterations; ++iteration) {
    H.setZero();
    H.bottomRightCorner<3, 3>().diagonal().setConstant(1.0 / Square(kHeldBias));
    Vec9 b = Vec9::Zero();
    std::vector<TrackSystem> systems;
    for (const TrackEquations& track : equations) systems.push_back(AddTrack(track, part * variance, &H, &b));
    if (options.mean_depth > 0.0) HoldMeanDepth(systems, options.mean_depth, &H, &b);
    x = SolveWithGravityNorm(H, b, options.gravity);
    // At first so wide that a bad start rejects no observation.
    const double width = options.sigma * std::max(2.0, 40.0 * std::pow(0.5, iteration));
    std::vector<double> squared_errors;
    for (size_t k = 0; k < tracks.size(); ++k) {
      result.depths[k] = systems[k].Depth(x);
      UpdateWeights(options.sigma, width, result.depths[k], x, &equations[k], &squared_errors);
    }
    if (!squared_errors.empty()) variance = std::min(Square(options.sigma), Median(squared_errors) / kMedianOfTwo);
  }
  H.bottomRightCorner<3, 3>().diagonal().array() += 1.0 / Square(options.b_a_sigma) - 1.0 / Square(kHeldBias);
  ComputeUncertainty(H, x, motion, &result);
  result.states = StatesOf(motion, x, b_g);
  return result;
}

}  // namespace

// Where the images are better than σ says, too much may be taken off: H is then no longer definite.
ClosedForm SolveClosedForm(const std::vector<FeatureTrack>& tracks, const std::vector<Preintegration>& imu,
                           const ClosedFormOptions& options) {
  const std::vector<LinearMotion> motion = DeadReckon(imu);
  for (double part = options.mean_depth > 0.0 ? 0.0 : 1.0;; part *= 0.5) {
    ClosedForm result = Solve(tracks, motion, imu.front().BiasGyroscope(), part, options);
    if (std::isfinite(result.scale_sigma) || part < 0.1) return result;
  }
}

}  // namespace ch5
