#pragma once
/// IMU preintegration between two frames, midpoint rule.
///
/// α [m], γ (quaternion), β [m/s]: position, rotation and velocity change seen from the body at the first frame,
/// gravity and initial velocity left out.  Error state [δp, δθ, δv, δb_a, δb_g] (15), right perturbation of γ.
/// Source: Qin, Li, Shen, "VINS-Mono", TRO 2018, §IV-B and its technical report; Forster 2017 for the bias Jacobians.

#include <vector>

#include "ch5_backend/math/so3.h"
#include "ch5_backend/types/measurements.h"

namespace ch5 {

using Mat1515 = Eigen::Matrix<double, 15, 15>;
using Vec15 = Eigen::Matrix<double, 15, 1>;

class Preintegration {
 public:
  /// @param first  the measurement at the first frame;  @param b_a, b_g  biases at which to integrate
  Preintegration(const ImuSample& first, const Vec3& b_a, const Vec3& b_g, const ImuNoise& noise);
  /// A whole interval.  @throws std::invalid_argument if there is no sample, and as Add
  Preintegration(std::vector<ImuSample> samples, const Vec3& b_a, const Vec3& b_g, const ImuNoise& noise);

  /// Integrates from the previous sample to this one.  @throws std::invalid_argument unless dt > 0 and all is finite
  void Add(const ImuSample& sample);
  /// Integrates all samples afresh at other biases.
  void Reintegrate(const Vec3& b_a, const Vec3& b_g);
  /// After the interval the biases walk on for so long, while nothing else changes: at rest [s].
  void LetBiasesWalk(double seconds);
  /// Appends another interval that begins where this one ends (its first sample is this one's last). The greater noise of
  /// the two is that of all samples.
  void Append(const Preintegration& next);

  double SumDt() const { return sum_dt_; }
  const Vec3& Alpha() const { return alpha_; }
  const Qd& Gamma() const { return gamma_; }
  const Vec3& Beta() const { return beta_; }
  const Vec3& BiasAccelerometer() const { return b_a_; }
  const Vec3& BiasGyroscope() const { return b_g_; }

  /// Covariance of the error state; the biases' block is that of their random walk.
  Mat1515 Covariance() const { return P_.selfadjointView<Eigen::Upper>(); }
  /// d[α, γ, β] / d[b_a, b_g], the two right block columns of the error state's transition.
  const Eigen::Matrix<double, 9, 6>& BiasJacobian() const { return J_; }
  const std::vector<ImuSample>& Samples() const { return samples_; }
  /// Another number after each change.
  int Revision() const { return revision_; }

 private:
  void Reset();
  void Step(const ImuSample& s0, const ImuSample& s1);
  // The blocks of F that are neither zero nor I, except the row p; q means θ.
  struct Transition {
    double dt;
    Mat33 qq, vq, va, vg;
  };
  void MoveBiasJacobian(const Transition& F);
  void MoveCovariance(const Transition& F);
  void AddNoise(const Mat33& A1, double dt);
  void AddWalk(double seconds);

  std::vector<ImuSample> samples_;
  Vec3 b_a_, b_g_;
  ImuNoise noise_;
  double sum_dt_, walk_seconds_ = 0.0;  // the latter: of LetBiasesWalk, which is no part of the former
  Vec3 alpha_, beta_;
  Qd gamma_;
  Eigen::Matrix<double, 9, 6> J_;
  Mat1515 P_;  // its upper half
  int revision_ = 0;
};

}  // namespace ch5
