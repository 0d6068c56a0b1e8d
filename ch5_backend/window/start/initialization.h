#pragma once
/// A start while moving: from a few images and the IMU between them to poses, speeds, biases, gravity and scale.
///
///   tracks, IMU ─► gyroscope bias ─► rotations ─► closed form: v, G, scale, depths ─► refinement by the solver
///
/// The images fix the gyroscope's bias without any structure (gyroscope_bias.h); with the rotations known, everything
/// else is one linear problem (closed_form.h). Each step can say no, and says why.

#include <memory>
#include <string>

#include "ch5_backend/types/measurements.h"

namespace ch5 {

/// One image of the window to start from.
struct MovingFrame {
  double t = 0.0;                             ///< by the IMU's clock [s]
  std::vector<TrackedPoint> tracks;           ///< each id at most once
  std::shared_ptr<const Preintegration> imu;  ///< from the image before to this one; null for the first
};

struct MovingStartOptions {
  Transform T_B_C;
  double focal_length = 460.0;          ///< [px]
  double pixel_sigma = 1.5;             ///< of an observation [px]
  double gravity = 9.81;                ///< [m/s²]
  double b_a_sigma = 0.1;               ///< [m/s²]
  int least_tracks = 12;                ///< seen in three images or more
  double least_parallax = 15.0;         ///< median of the tracks, rotation taken out [px]
  double largest_scale_sigma = 0.05;    ///< relative
  double largest_gravity_sigma = 0.05;  ///< [rad]
  double least_inliers = 0.6;           ///< share of the observations within 3 σ
};

enum class StartFailure {
  kNone,
  kTooFewFrames,
  kTooFewTracks,
  kTooLittleParallax,    ///< it stands, or only turns
  kTooLittleExcitation,  ///< it moves without acceleration: scale or gravity cannot be told
  kInconsistent          ///< images and IMU contradict each other
};

/// "too little parallax", …
std::string ToString(StartFailure failure);

struct MovingStart {
  StartFailure failure = StartFailure::kNone;
  std::string message;               ///< one sentence with the numbers
  std::vector<StampedState> states;  ///< one a frame, gravity along −z of W, the first at the origin; empty on failure
  double parallax = 0.0;             ///< [px]
  double scale_sigma = 0.0;          ///< relative
  double gravity_sigma = 0.0;        ///< [rad]
  double inliers = 0.0;              ///< share of the observations
};

/// @param frames  in order of time. The preintegrations are not changed; their biases are where the search begins.
/// @throws std::invalid_argument if an image but the first has no preintegration
MovingStart StartMoving(const std::vector<MovingFrame>& frames, const MovingStartOptions& options);

}  // namespace ch5
