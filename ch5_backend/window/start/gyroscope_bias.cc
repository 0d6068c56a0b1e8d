#include "ch5_backend/window/start/gyroscope_bias.h"

#include <Eigen/Cholesky>
#include <cmath>
#include <limits>
#include <random>
#include <tuple>
#include <unordered_map>

#include "ch5_backend/math/so3.h"

namespace ch5 {
namespace {

// The rotation between two frames by the gyroscope, and its derivative by the bias.
struct RelativeRotation {
  Qd gamma = Qd::Identity();
  Mat33 J = Mat33::Zero();
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

// Two images: the gyroscope's rotation between them, what both see, and the direction of the translation.
struct ImagePair {
  RelativeRotation rotation;
  std::vector<Match> matches;
  Vec3 t = Vec3::UnitX();
};

// So that about `most` matches of the pair are used.
size_t StrideFor(const ImagePair& pair, size_t most) { return (pair.matches.size() + most - 1) / most; }

// Geman and McClure's ρ = ½ r²/σ² · w²/(w² + r²/σ²): beyond the width w, unlike Cauchy's, outliers gain next to nothing by
// coming nearer, and many inliers of small residuals are not outweighed by a few.
struct Loss {
  double sigma, width;

  double Width2() const { return sigma * sigma * width * width; }
  double Cost(double r) const { return 0.5 * width * width * r * r / (Width2() + r * r); }
  double Weight(double r) const { return std::pow(Width2() / (Width2() + r * r) / sigma, 2); }
};

// R = γ Exp(J δb), and δφ = J_r J δδb, by which its right increment follows the bias.
struct BiasedRotation {
  Mat33 R, dphi_db;
};

BiasedRotation RotationAt(const RelativeRotation& rotation, const Vec3& delta_b) {
  const Vec3 phi = rotation.J * delta_b;
  return {(rotation.gamma * ExpSO3(phi)).toRotationMatrix(), RightJacobianSO3(phi) * rotation.J};
}

// r = nᵀ R m_j,  n = c/√(‖c‖² + ε²),  c = t × m_i: the sine of the angle between a ray and its epipolar plane. Without
// the normalization, noise would count less where t is close to the rays, and every motion would seem to go straight ahead.
struct EpipolarResidual {
  double r, length;
  Vec3 c, Rm_j;

  EpipolarResidual(const Match& match, const Vec3& t, const Mat33& R) : c(t.cross(match.m_i)), Rm_j(R * match.m_j) {
    length = std::sqrt(c.squaredNorm() + 1e-4);  // ε = 0.01: at the epipole there is no plane
    r = c.dot(Rm_j) / length;
  }
};

// The direction that is orthogonal to most of n = m_i × R m_j, by RANSAC: two of them give a candidate. The draws repeat
// from call to call.
// @param stride  of the matches that are used
Vec3 FindDirection(const std::vector<Match>& matches, size_t stride, const Mat33& R, double tolerance) {
  constexpr int kDraws = 30;  // with 60 % outliers, one of them is very likely without any
  std::vector<Vec3> n;
  for (size_t k = 0; k < matches.size(); k += stride) n.push_back(matches[k].m_i.cross(R * matches[k].m_j));
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

using Mat32 = Eigen::Matrix<double, 3, 2>;

// The columns are orthogonal to the unit vector t, which moves by t ← (t + B δt)/‖·‖.
Mat32 Basis(const Vec3& t) {
  Mat32 B;
  B.col(0) = t.unitOrthogonal();
  B.col(1) = t.cross(B.col(0));
  return B;
}

// H and b of [δb, δt] of a pair of images, and its cost.
struct PairEquations {
  Mat33 H_bb = Mat33::Zero();
  Mat32 H_bt = Mat32::Zero();
  Mat22 H_tt = Mat22::Zero();
  Vec3 b_b = Vec3::Zero();
  Vec2 b_t = Vec2::Zero();
  double cost = 0.0;

  // Held where the matches leave the direction open.
  Mat22 InverseH_tt() const { return (H_tt + Mat22::Identity()).inverse(); }
};

// Sums by [δφ, δt], since δφ = (∂φ/∂b) δb is the same for all matches.
PairEquations Linearize(const ImagePair& pair, size_t stride, const BiasedRotation& at, const Loss& loss) {
  PairEquations e;
  const Mat32 B = Basis(pair.t);
  const Mat33 R_T = at.R.transpose();
  for (size_t k = 0; k < pair.matches.size(); k += stride) {
    const Match& match = pair.matches[k];
    const EpipolarResidual residual(match, pair.t, at.R);
    const double s = residual.length, r = residual.r, weight = loss.Weight(r);
    const Vec3 dr_dphi = match.m_j.cross(R_T * residual.c) / s;
    const Vec3 dr_dc = residual.Rm_j / s - r / (s * s) * residual.c;
    const Vec2 dr_dt = B.transpose() * match.m_i.cross(dr_dc);
    e.H_bb += (weight * dr_dphi) * dr_dphi.transpose();
    e.H_bt += (weight * dr_dphi) * dr_dt.transpose();
    e.H_tt += (weight * dr_dt) * dr_dt.transpose();
    e.b_b -= weight * r * dr_dphi;
    e.b_t -= weight * r * dr_dt;
    e.cost += loss.Cost(r);
  }
  e.H_bb = at.dphi_db.transpose() * e.H_bb * at.dphi_db;
  e.H_bt = at.dphi_db.transpose() * e.H_bt;
  e.b_b = at.dphi_db.transpose() * e.b_b;
  return e;
}

// Gauss–Newton on the bias, each pair's direction eliminated:  H_bb − H_bt H_tt⁻¹ H_tb.
// @param most  matches of a pair that are used, spread over all
// @return the cost before the last step
double Solve(const Loss& loss, size_t most, std::vector<ImagePair>* pairs, Vec3* delta_b) {
  constexpr int kIterations = 4;  // the bias has converged after three; the directions go on creeping
  for (ImagePair& pair : *pairs) {
    const Mat33 R = RotationAt(pair.rotation, *delta_b).R;
    pair.t = FindDirection(pair.matches, StrideFor(pair, most), R, loss.width * loss.sigma);
  }
  double cost = 0.0;
  for (int iteration = 0; iteration < kIterations; ++iteration) {
    Mat33 H = Mat33::Zero();
    Vec3 b = Vec3::Zero();
    cost = 0.0;
    std::vector<PairEquations> equations;
    for (const ImagePair& pair : *pairs) {
      equations.push_back(Linearize(pair, StrideFor(pair, most), RotationAt(pair.rotation, *delta_b), loss));
      const PairEquations& e = equations.back();
      const Mat32 Y = e.H_bt * e.InverseH_tt();
      H += e.H_bb - Y * e.H_bt.transpose();
      b += e.b_b - Y * e.b_t;
      cost += e.cost;
    }
    const Vec3 step = (H + Mat33::Identity()).ldlt().solve(b);
    *delta_b += step;
    for (size_t k = 0; k < pairs->size(); ++k) {
      const PairEquations& e = equations[k];
      Vec3& t = (*pairs)[k].t;
      t = (t + Basis(t) * (e.InverseH_tt() * (e.b_t - e.H_bt.transpose() * step))).normalized();
    }
  }
  return cost;
}

std::vector<ImagePair> FindPairs(const std::vector<FeatureTrack>& tracks, const std::vector<Preintegration>& imu,
                                 const Qd& R_B_C) {
  constexpr size_t kLeastMatches = 6;  // a direction has two degrees of freedom; the other matches determine the bias
  const size_t frames = imu.size() + 1;
  std::vector<ImagePair> pairs;
  for (size_t i = 0; i < frames; ++i) {
    for (size_t step = 1; i + step < frames; step *= 2) {  // short and long base lines; all pairs would be many more
      auto matches = MatchesOf(tracks, R_B_C, static_cast<int>(i), static_cast<int>(i + step));
      if (matches.size() < kLeastMatches) continue;
      pairs.push_back({RelativeRotationBetween(imu, i, i + step), std::move(matches)});
    }
  }
  return pairs;
}

// A turn looks much like a shift across it: each bias has directions that nearly fit, and the cost many minima. Of seven
// starts, by a few matches, the one that ends lowest leads on, unless zero is lower by more of them. Five unknowns of a pair
// need no more than these: with all of a thousand, the bias changes by a fraction of its deviation.
Vec3 FindBias(double sigma, std::vector<ImagePair>* pairs) {
  constexpr double kApart = 0.15;                    // [rad/s]
  const Loss wide{sigma, 15.0}, narrow{sigma, 2.5};  // for a bias of 0.1 rad/s, and to suppress outliers
  constexpr size_t kFew = 60, kMost = 120;           // matches
  Vec3 best = Vec3::Zero();
  double least = std::numeric_limits<double>::infinity();
  const auto try_from = [&](Vec3 delta_b, size_t most) {
    Solve(wide, most, pairs, &delta_b);
    const double cost = Solve(narrow, most, pairs, &delta_b);
    if (cost < least) std::tie(least, best) = std::pair(cost, delta_b);
  };
  for (int axis = 0; axis < 3; ++axis) {
    for (const double side : {-kApart, kApart}) try_from(side * Vec3::Unit(axis), kFew);
  }
  try_from(Vec3::Zero(), kFew);
  least = Solve(narrow, kMost, pairs, &best);
  try_from(Vec3::Zero(), kMost);
  Solve(narrow, kMost, pairs, &best);  // leaves the directions that fit it, which reveal the outliers
  return best;
}

// Drops the views that are outliers (off the epipolar plane by more than 3 σ) in at least half of their pairs.
void RemoveOutliers(const std::vector<ImagePair>& pairs, const Vec3& delta_b, double sigma,
                    std::vector<FeatureTrack>* tracks) {
  std::unordered_map<const FeatureTrack::View*, int> votes;
  for (const ImagePair& pair : pairs) {
    const Mat33 R = RotationAt(pair.rotation, delta_b).R;
    for (const Match& match : pair.matches) {
      const int vote = std::abs(EpipolarResidual(match, pair.t, R).r) < 3.0 * sigma ? 1 : -1;
      votes[match.i] += vote;
      votes[match.j] += vote;
    }
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
  std::vector<ImagePair> pairs = FindPairs(*tracks, *imu, R_B_C);
  const Vec3 delta_b = FindBias(sigma, &pairs);
  RemoveOutliers(pairs, delta_b, sigma, tracks);
  const Vec3 b_g = imu->front().BiasGyroscope() + delta_b;
  for (Preintegration& interval : *imu) interval.Reintegrate(interval.BiasAccelerometer(), b_g);
  return b_g;
}

}  // namespace ch5
