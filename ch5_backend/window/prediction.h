#pragma once
/// A state carried on by the IMU alone, at any time and at the IMU's rate.

#include <memory>
#include <optional>
#include <vector>

#include "ch5_backend/types/inertial/preintegration.h"
#include "ch5_backend/types/recording.h"

namespace ch5 {

/// What the IMU felt from a state to the time t1, at the state's biases. Before the first and after the last measurement,
/// that one is held constant.
/// @param imu  strictly increasing in time, at least one;  @param t1  after from.t [s]
std::shared_ptr<Preintegration> IntegrateFrom(const StampedState& from, const std::vector<ImuMeasurement>& imu,
                                              double t1, const ImuNoise& noise);

/// How fast what an IMU measures changes, as a random walk's density q: what a gap in its measurements hides. Between the
/// measurements at a gap's ends, T apart, the truth strays from the straight line as a Brownian bridge, whose integral has
/// the variance q² T³/12: as much as that of white noise of the density q T/√12.
class ImuUnsteadiness {
 public:
  void Add(const ImuMeasurement& measurement);
  /// For an interval that lies in such a gap, or has a part of it.
  ImuNoise AcrossGap(double seconds, ImuNoise noise) const;

 private:
  std::optional<ImuMeasurement> from_;
  double q2_a_ = -1.0, q2_g_ = -1.0;  // of an axis, (m/s²)²/s and (rad/s)²/s; negative: not known yet
};

/// With t = imu.SumDt() and G = [0, 0, gravity]:
///
///   q_j = q_i γ,   v_j = v_i − G t + R_i β,   p_j = p_i + v_i t − ½ G t² + R_i α;   the biases stay
///
/// @param gravity [m/s²]
StampedState Predict(const StampedState& from, const Preintegration& imu, double gravity);

/// The state at a later time t; `from` itself at its own.
/// @param imu      strictly increasing in time
/// @param max_gap  the longest time without a measurement [s];  @param max_age  the longest time after `from` [s]
/// @return nullopt before `from`, too long after it, or if there is a longer gap in the measurements from there to t
std::optional<StampedState> PredictAt(const StampedState& from, const std::vector<ImuMeasurement>& imu, double t,
                                      const Calibration& calibration, double max_gap, double max_age);

}  // namespace ch5
