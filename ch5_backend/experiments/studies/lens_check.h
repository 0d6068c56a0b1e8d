#pragma once
/// Whether the rays of a recording are those of its camera, or bent by a lens's model that is not its own.

#include <optional>

#include "ch5_backend/types/recording.h"

namespace ch5 {

/// What an image's coordinates lack:  x ← x (1 + k ‖x‖²).
struct LensAgreement {
  double k = 0.0;     ///< with which they fit best; 0 if the lens is right
  double gain = 1.0;  ///< how many times less the robust cost is with it
};

/// Pairs of images hold the epipolar constraint tᵀ(f_i × R_ij f_j) = 0 whatever the depths; R_ij is the gyroscope's, whose
/// bias and delay are found with k. (For k without a gyroscope: Fitzgibbon, "Simultaneous linear estimation of multiple
/// view geometry and lens distortion", CVPR 2001.)
/// @param delay  as far as it is known: the images are stamped so much too early [s]
/// @return nullopt where fewer than ten pairs have enough parallax
std::optional<LensAgreement> CheckLens(const Recording& recording, double delay);

}  // namespace ch5
