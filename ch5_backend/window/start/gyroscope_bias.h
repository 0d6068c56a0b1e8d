#pragma once
/// The gyroscope's bias from the epipolar constraint of image pairs, whatever the translation:
///
///   tᵀ(f_i × R_ij(b_g) f_j) = 0,   R_ij = γ_ij Exp(J_ij δb_g)
///
/// for every pair of images (i, j) and every point common to both: one bias for all pairs, one direction t per pair. It
/// needs no structure and no scale, and planes are no special case.
/// Source: Kneip & Lynen, "Direct optimization of frame-to-frame rotation", ICCV 2013; He et al., "A
/// rotation-translation-decoupled solution for robust and efficient visual-inertial initialization", CVPR 2023.

#include <vector>

#include "ch5_backend/types/inertial/preintegration.h"
#include "ch5_backend/types/measurements.h"

namespace ch5 {

/// One point in the images of a window.
struct FeatureTrack {
  /// One image of the point; x on the normalized plane.
  struct View {
    int frame = 0;  ///< 0, 1, …
    Vec2 x = Vec2::Zero();
    int camera = 0;  ///< or 1
  };
  std::vector<View> views;  ///< in order of frames, of each camera 0's before camera 1's; the first is camera 0's
};

/// @param R_B_C   the camera's rotation;  @param sigma  of an observation on the normalized plane
/// @param tracks  of camera 0 alone; outlier views are removed; a track may be left with one or none
/// @param imu     imu[k] leads from frame k to frame k + 1; on return it is integrated at the bias that is returned
/// @return b_g [rad/s]
Vec3 EstimateGyroscopeBias(const Qd& R_B_C, double sigma, std::vector<FeatureTrack>* tracks,
                           std::vector<Preintegration>* imu);

}  // namespace ch5
