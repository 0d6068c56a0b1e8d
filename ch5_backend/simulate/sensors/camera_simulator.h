#pragma once
/// A camera on an analytic trajectory, with a front end that follows points from image to image: its tracks are what
/// a recording holds.
///
/// An image stamped t is taken at t + time_offset: the camera's clock is late by so much (VINS-Mono's td).
/// A point keeps its id while it is followed. It is lost when it leaves the image or the range of depths, at random,
/// or when its track is as long as allowed; found again, it is a new track with a new id, as in a real front end.
/// Camera 1, if the calibration has one, sees what it can of camera 0's points; camera 0's tracks are the same without it.

#include <limits>

#include "ch5_backend/simulate/sensors/trajectory.h"
#include "ch5_backend/types/recording.h"

namespace ch5 {

struct CameraOptions {
  double pixel_sigma = 1.0;                                ///< noise per axis [px]
  double near = 0.3, far = 30.0;                           ///< depths at which a point is seen [m]
  int max_tracks = 150;                                    ///< per image
  int max_track_length = std::numeric_limits<int>::max();  ///< in images
  double drop_probability = 0.0;                           ///< of a track, at every image after its first
  double outlier_fraction = 0.0;                           ///< of the observations: placed anywhere in the image
  double time_offset = 0.0;                                ///< [s]
  uint64_t seed = 2;
};

/// @param points_W     landmarks in W [m]
/// @param calibration  camera_rate, and of each camera T_B_C, intrinsics and image size
/// @return  the images stamped n/camera_rate whose time n/camera_rate + time_offset lies within the trajectory
/// @throws OptionError unless rates, sizes and depths are positive and fractions lie in [0, 1]
std::vector<Image> SimulateCamera(const Trajectory& trajectory, const std::vector<Vec3>& points_W,
                                  const Calibration& calibration, const CameraOptions& options);

}  // namespace ch5
