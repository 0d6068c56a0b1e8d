#pragma once
/// Recordings in EuRoC's own layout, as published: a folder `mav0` with cam0, perhaps cam1, imu0 and, where the truth is known,
/// state_groundtruth_estimate0, vicon0 or mocap0, each with sensor.yaml and data.csv. TUM-VI's is the same, but for its
/// calibrations, which are Kalibr's, dso/camchain.yaml and dso/imu_config.yaml.
///
/// The body frame B of a Recording is the IMU's, so T_B_C = T_BI⁻¹ T_BC of the files.
///
/// Source: Burri et al., "The EuRoC micro aerial vehicle datasets", IJRR 2016.

#include <filesystem>
#include <string>
#include <vector>

#include "ch5_backend/files/text_reader.h"
#include "ch5_backend/track/lens.h"
#include "ch5_backend/types/recording.h"

namespace ch5 {

struct ImageFile {
  double t = 0.0;  ///< [s] since Recording::origin_ns
  std::filesystem::path path;
  std::filesystem::path path1 = {};  ///< cam1's image of the same time; empty if there is none
};

struct EurocFolder {
  Recording recording;  ///< without images
  Lens lens;
  Lens lens1;                      ///< of cam1, if the calibration has camera1
  std::vector<ImageFile> images;   ///< of cam0, while the IMU measured
  std::vector<std::string> notes;  ///< what is left out, and other things that a user should know
};

/// @param folder  mav0, or the folder that holds it
/// @param mono    leaves cam1 out; it is also left out, with a note, if it has no image at the time of one of cam0's
/// @param left_out  if not null, rows that cannot be read are left out and counted here, unless they are many
/// @throws FileError naming file, line and value for whatever is missing or cannot be: a file, a column, a key, a number,
///         a T_BS that is no rigid transform, an unknown camera model, a camera and an IMU that have no time in common, an
///         IMU that does not feel gravity
EurocFolder ReadEurocFolder(const std::filesystem::path& folder, bool mono = false,
                            std::vector<LeftOut>* left_out = nullptr);

}  // namespace ch5
