#pragma once
/// The error of an estimated trajectory after alignment in the four unobservable directions of a visual-inertial
/// estimate: position and yaw.
///
/// Source: Zhang & Scaramuzza, "A Tutorial on Quantitative Trajectory Evaluation for Visual(-Inertial) Odometry",
/// IROS 2018, §IV.

#include <limits>
#include <optional>
#include <vector>

#include "ch5_backend/types/recording.h"

namespace ch5 {

/// x ↦ R_z(yaw) x + p.
struct YawTransform {
  double yaw = 0.0;       ///< [rad]
  Vec3 p = Vec3::Zero();  ///< [m]

  Qd Rotation() const { return ExpSO3(Vec3(0, 0, yaw)); }
  Vec3 operator*(const Vec3& x) const { return Rotation() * x + p; }
  Transform operator*(const Transform& T) const { return {Rotation() * T.q, *this * T.p}; }
};

/// argmin Σ ‖to_i − (R_z(yaw) from_i + p)‖², in closed form.
/// @param from, to  as many positions each [m]
/// @return nullopt with fewer than two points, a number that is not finite, or points above one another: the yaw is
///         then not determined
std::optional<YawTransform> AlignYaw(const std::vector<Vec3>& from, const std::vector<Vec3>& to);

/// The transform that lays one pose's position and yaw upon another's: yaw = z of Log(R_to R_fromᵀ), as Zhang, Gallego,
/// Scaramuzza, RA-L 2018, align at the first pose.
YawTransform AlignFirstPose(const Transform& from, const Transform& to);

struct TrajectoryError {
  YawTransform alignment;      ///< of the estimate to the truth
  double position_rmse = 0.0;  ///< the absolute trajectory error, ATE [m]
  double position_max = 0.0;   ///< [m]
  double rotation_rmse = 0.0;  ///< angle of R_truthᵀ R_estimate after the alignment [rad]
  double yaw_rmse = 0.0;       ///< its part about gravity: z of Log(R_estimate R_truthᵀ) [rad]
  double velocity_rmse = 0.0;  ///< [m/s]
  /// What the estimate's lengths must be multiplied by to fit best (AlignUmeyama); NaN where that is not determined.
  double scale = std::numeric_limits<double>::quiet_NaN();
  std::vector<double> position;  ///< ‖p_estimate − p_truth‖ of each compared state [m] …
  std::vector<double> time;      ///< … and its time [s]
};

/// Compares each estimate with the truth interpolated at its time; estimates before or after the truth are left out.
/// @param truth  strictly increasing in time
/// @param alignment  nullopt: AlignYaw over all compared positions
/// @return nullopt if no state can be compared, or the alignment is not determined
std::optional<TrajectoryError> CompareTrajectories(const std::vector<StampedState>& estimate,
                                                   const std::vector<StampedState>& truth,
                                                   const std::optional<YawTransform>& alignment = std::nullopt);

}  // namespace ch5
