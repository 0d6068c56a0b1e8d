#pragma once
/// Velocity, gravity and scale at once, once the rotations are known: a linear problem with one constraint.
///
/// Seen from the first body frame B₀, with the IMU integrated at b_a = 0 and x = [v₀, G, b_a]:
///
///   p_k = t_k v₀ − ½t_k² G + B_k b_a + a_k,   v_k = v₀ − t_k G + U_k b_a + u_k
///
/// and a point at depth d on the ray f of its first image i is seen in image j where
///
///   [1 0 −u; 0 1 −v] R_Cjᵀ (p_Ci + d R_Ci f − p_Cj) = 0,   linear in d and x.
///
/// With a second camera, C_j is either of the two: its image of the same time (p_j = p_i) gives d in meters.
///
/// The depths are eliminated by Schur complements. The remaining 9×9 system is minimized under ‖G‖ = g: with the reduced
/// S and c of G, (S + μI)G = c has one solution μ > −λ_min(S) with ‖G‖ = g, the global minimum. The weights, 1/depth² and
/// Cauchy's, are found iteratively.
/// Source: Martinelli, "Closed-form solution of visual-inertial structure from motion", IJCV 2014; Gander, Golub, von
/// Matt, "A constrained eigenvalue problem", 1989, for μ.

#include "ch5_backend/types/inertial/preintegration.h"
#include "ch5_backend/window/start/gyroscope_bias.h"

namespace ch5 {

/// The sensors' parameters for the closed form.
struct ClosedFormOptions {
  Transform T_B_C;
  double sigma = 1.5 / 460.0;  ///< of an observation on the normalized plane
  double gravity = 9.81;       ///< [m/s²]
  double b_a_sigma = 0.1;      ///< of the accelerometer's bias about zero [m/s²]
  Transform T_B_C1 = {};       ///< of views of camera 1
  double mean_depth = 0.0;     ///< if positive, that of the points, which decides the scale where nothing else does [m]
};

struct ClosedForm {
  std::vector<StampedState> states;  ///< in a frame whose z axis is up and whose origin is the first body; t unset
  std::vector<double> depths;        ///< of the tracks, in the camera of their first view [m]; not usable if negative
  double scale_sigma = 0.0;          ///< relative σ of the largest displacement
  double gravity_sigma = 0.0;        ///< of its direction [rad]
};

/// @param imu  imu[k] leads from frame k to frame k + 1, integrated at b_a = 0 and at the gyroscope's true bias
ClosedForm SolveClosedForm(const std::vector<FeatureTrack>& tracks, const std::vector<Preintegration>& imu,
                           const ClosedFormOptions& options);

/// argmin ½xᵀHx − bᵀx under ‖x_G‖ = g, where x_G are the entries 3, 4, 5 of nine.
Vec9 SolveWithGravityNorm(const Eigen::Matrix<double, 9, 9>& H, const Vec9& b, double g);

}  // namespace ch5
