#pragma once
/// Dynamic initialization: poses, speeds, biases, gravity and scale from a few images in motion and the IMU between them.
///
///   tracks, IMU ─► gyroscope bias ─► rotations ─► closed form: v, G, scale, depths ─► refinement by the solver
///
/// The images alone determine the gyroscope's bias (gyroscope_bias.h); with the rotations known, everything else is one
/// linear problem (closed_form.h). Each step can fail, and reports why. At rest, see standstill.h.
///
/// A second camera gives the depths in meters, so neither parallax nor acceleration is needed: the first images will do, at
/// rest too, once they hold the body's motion well enough for what remains of the specific force to be gravity.

#include <memory>
#include <optional>
#include <string>

#include "ch5_backend/types/inertial/preintegration.h"
#include "ch5_backend/types/recording.h"

namespace ch5 {

/// One image of the initialization window.
struct InitializationImage {
  double t = 0.0;                             ///< by the IMU's clock [s]
  std::vector<TrackedPoint> tracks;           ///< each id at most once
  std::shared_ptr<const Preintegration> imu;  ///< from the previous image to this one; null for the first
  std::vector<TrackedPoint> tracks1 = {};     ///< of camera 1; used where camera 0 sees the point too
};

/// The sensors' parameters for the start in motion, and what it must reach.
struct DynamicInitializationOptions {
  Transform T_B_C;
  double focal_length = 460.0;          ///< [px]
  double pixel_sigma = 1.5;             ///< of an observation [px]
  double gravity = 9.81;                ///< [m/s²]
  double b_a_sigma = 0.1;               ///< [m/s²]
  int least_tracks = 12;                ///< seen in three images or more
  double least_parallax = 15.0;         ///< median of the tracks, rotation taken out [px]
  double largest_scale_sigma = 0.1;     ///< relative
  double largest_gravity_sigma = 0.05;  ///< [rad]
  double least_inliers = 0.6;           ///< fraction of the observations within 3 σ
  /// The second camera, if there is one: where both see `least_tracks`, neither parallax nor scale is required.
  std::optional<Camera> camera1 = {};
  bool wants_shape = false;  ///< DynamicInitialization::shape, if all else fails

  /// @throws OptionError
  void Validate() const;
};

/// Why there is no start.
enum class InitializationFailure {
  kNone,
  kTooFewFrames,
  kTooFewTracks,
  kTooLittleParallax,    ///< at rest, or pure rotation
  kTooLittleExcitation,  ///< no acceleration: scale or gravity is not observable
  kInconsistent          ///< images and IMU contradict each other
};

/// "too little parallax", …
std::string ToString(InitializationFailure failure);

struct DynamicInitialization {
  InitializationFailure failure = InitializationFailure::kNone;
  std::string message;  ///< one sentence with the numbers
  /// One per frame, gravity along −z of W, the first at the origin; empty on failure.
  std::vector<StampedState> states;
  /// On a failure where gravity is known, as at steady speed: the states but for their scale, with points 5 m away on average.
  std::vector<StampedState> shape;
  double parallax = 0.0;       ///< [px]
  double scale_sigma = 0.0;    ///< relative; of little meaning at rest
  double gravity_sigma = 0.0;  ///< [rad]
  double inliers = 0.0;        ///< fraction of the observations
};

/// @param frames  in order of time. The preintegrations do not change; their biases are the initial guess.
/// @throws OptionError if an option is out of its range
/// @throws std::invalid_argument if an image but the first has no preintegration
DynamicInitialization InitializeDynamically(const std::vector<InitializationImage>& frames,
                                            const DynamicInitializationOptions& options);

}  // namespace ch5
