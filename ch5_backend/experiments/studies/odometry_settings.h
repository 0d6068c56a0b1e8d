#pragma once
/// What a user may set of the odometry: by options of ch5_recording, or in the section `estimator:` of calibration.yaml.

#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "ch5_backend/experiments/studies/command_line.h"
#include "ch5_backend/experiments/studies/odometry.h"
#include "ch5_backend/files/recording_file.h"

namespace ch5 {

struct OdometrySettings {
  std::string policy;          ///< vins or okvis; empty: both
  EstimatorOptions estimator;  ///< without the calibration, which is the recording's
  bool finds_clock = true;     ///< the delay of the camera's clock is looked for; not once estimate_time_offset is set
  std::optional<double> clock_sigma;  ///< of estimator.time_offset, once the recording has decided it [s]
  bool finds_noise = true;            ///< likewise the noise of the tracks; not once pixel_sigma is set
  double track_noise = 0.0;           ///< what was found, 0 where the recording does not tell [px]
  bool corrects_focal_length = true;  ///< where images and gyroscope contradict it
  bool mono = false;                  ///< camera 1 is left out
  int window = 0;                     ///< VINS: frames beside the newest; OKVIS: keyframes; 0: as the policy has it
  int max_features = 0;               ///< tracks used of an image; 0: all
  double from = 0.0, to = std::numeric_limits<double>::infinity();  ///< since the first IMU measurement [s]

  /// Sets one by its name in calibration.yaml, such as max_features; on the command line it is --max-features.
  /// @throws std::invalid_argument with what it must be, or for an unknown name
  void Set(const std::string& name, const std::string& word);

  /// The noise of the tracks, with the limit beyond which a landmark is an outlier [px].
  void UsePixelSigma(double pixels);
  std::vector<std::unique_ptr<WindowPolicy>> Policies() const;
  /// Leaves out images and measurements outside [from, to], tracks beyond max_features (those followed longest stay), and
  /// with `mono` camera 1.
  /// @throws std::invalid_argument if less than two images or measurements are left
  void Restrict(Recording* recording) const;
};

/// Declares the options; `given` is what the command line has set, to be applied after those of the file.
void DeclareOdometryOptions(CommandLine* line, EstimatorWords* given);

/// Those of the recording's calibration.yaml, then those given.
/// @throws FileError for one of the file, or std::invalid_argument
OdometrySettings ReadOdometrySettings(const EstimatorWords& of_file, const EstimatorWords& given);

}  // namespace ch5
