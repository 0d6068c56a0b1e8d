#pragma once
/// Whether the rays of a recording are those of its camera, or bent by a lens's model that is not its own, or by another
/// focal length, and whether they turn as far as the gyroscope.

#include <optional>

#include "ch5_backend/types/recording.h"

namespace ch5 {

/// One thing that may be wrong.
struct Cause {
  double value = 0.0;  ///< with which images and gyroscope fit best; 0 if it is right
  double sigma = 0.0;  ///< its standard deviation, by the noise that is left
  double gain = 1.0;   ///< how many times less the robust cost is with it
};

/// Each as if it were the only one.
struct Disagreement {
  Cause lens;       ///< x ← x (1 + k ‖x‖²)
  Cause focal;      ///< x ← x (1 + s)
  Cause gyroscope;  ///< θ ← θ (1 + g)
  Cause shutter;    ///< a point at y is seen so much later for each 1 of y [s]
  Cause drift;      ///< the length of d in b_g ← b_g + d t [rad/s²]
  Cause rotation;   ///< the length of ρ in q_B_C ← q_B_C Exp(ρ) [rad]
};

/// Pairs of images hold the epipolar constraint tᵀ(f_i × R_ij f_j) = 0 whatever the depths; R_ij is the gyroscope's, whose
/// bias and delay are found too. (For k without a gyroscope: Fitzgibbon, "Simultaneous linear estimation of multiple
/// view geometry and lens distortion", CVPR 2001.)
/// @param delay  as far as it is known: the images are stamped so much too early [s]
/// @return nullopt where fewer than ten pairs have enough parallax
std::optional<Disagreement> FindDisagreement(const Recording& recording, double delay);

}  // namespace ch5
