#pragma once
/// A folder of images and IMU measurements as a Recording: its tracks.

#include <functional>

#include "ch5_backend/track/euroc_folder.h"
#include "ch5_backend/track/tracker.h"

namespace ch5 {

struct TrackedRecording {
  Recording recording;
  double seconds = 0.0;      ///< of one processor, spent on reading and following the images
  double mean_length = 0.0;  ///< of a track [images]
};

/// Reads and follows the images one by one, on one core, those of cam1 too if the calibration has camera1. After a gap of five
/// images or more the tracks start afresh.
/// @param progress  called with the fraction done, 0 … 1
/// @param left_out  if not null, images that cannot be read are left out and counted here, unless they are many
/// @throws FileError for an image that cannot be read, or is of another size than the calibration's
TrackedRecording TrackImages(const EurocFolder& folder, const TrackerOptions& options = {},
                             const std::function<void(double)>& progress = nullptr,
                             std::vector<LeftOut>* left_out = nullptr);

}  // namespace ch5
