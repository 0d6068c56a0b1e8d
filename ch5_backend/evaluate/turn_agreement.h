#pragma once
/// Whether camera and gyroscope saw the same turns: what a delay of a clock or a wrong T_B_C spoils before any estimate.

#include <optional>
#include <string>
#include <vector>

#include "ch5_backend/types/recording.h"

namespace ch5 {

/// How the delay of the camera's clock changes while a recording lasts: evenly, or at once.
struct DelayChange {
  double rate = 0.0;   ///< how much faster the IMU's clock runs than the camera's; 0 if the delay jumps
  double step = 0.0;   ///< by how much it jumps [s]; 0 if the clocks run apart
  double t = 0.0;      ///< the stamp of an image, from which on, or about which, …
  double delay = 0.0;  ///< … it is this [s]
  double sigma = 0.0;  ///< of the rate or the step
};

/// Correlations of the turns from image to image: 1 if both sensors agree, 0 if they have nothing in common.
struct TurnAgreement {
  double as_given = 0.0;           ///< by the recording's time stamps and q_B_C
  double with_inverse = 0.0;       ///< with the inverse of q_B_C
  double with_axes = 0.0;          ///< the greatest, with `axes` times the gyroscope's rates
  Mat33 axes = Mat33::Identity();  ///< one of SignedPermutations
  double with_tracks = 0.0;        ///< the greatest, with the tracks' x and y swapped or negated, so that …
  std::string tracks;              ///< … they are read as these
  double at_delay = 0.0;           ///< the greatest, once the images are stamped `delay` later
  double delay = 0.0;              ///< within ±1 [s]; VINS-Mono's td
  double pairs = 0.0;              ///< of images that were compared, as if none overlapped
  double noise = 1.0;  ///< the variance of the images' turns over that of the gyroscope's, whatever the axes
  std::optional<DelayChange> change;  ///< if it is certain
};

/// The 48 ways of naming and directing three axes, the given one first.
std::vector<Mat33> SignedPermutations();

/// One of them in words: "-y, x, z".
std::string NameAxes(const Mat33& axes);

/// A turn is the rotation, with a translation's direction, that fits the rays of two images best, whatever their depths.
/// @return nullopt if the camera turns too little or too evenly (within 0.05 rad/s), or fewer than 50 pairs of images tell
std::optional<TurnAgreement> CompareTurns(const Recording& recording);

/// The standard deviation of the images' turns about each axis of B, without their noise: the root of the covariance of two
/// halves of the tracks [rad/s]; 0 where that is not certain.
Vec3 SpreadOfImageTurns(const Recording& recording);

/// σ of noise, and the standard deviation of this figure.
struct MeasuredNoise {
  double value, sigma;
};
/// Of an observation along an axis [px]: by the distances from the epipolar lines that are left between images 0.12 to 0.3 s
/// apart, without outliers. What grows over longer times, as a track that creeps along an edge, is not in it.
/// @return nullopt if too few images share twelve points
std::optional<MeasuredNoise> NoiseOfTracks(const Recording& recording);

/// What a correlation leaves of the variance.
inline double LeftVariance(double correlation) { return 1.0 - correlation * correlation; }

/// Whether the images' rotation disagrees with the gyroscope's. Images that hardly distinguish rotation from translation
/// do not show it.
bool TurnOtherwise(const TurnAgreement& turns);

/// The delay of the camera's clock, if it stands out from the noise of the images' turns [s].
std::optional<double> ClearDelay(const TurnAgreement& turns);

}  // namespace ch5
