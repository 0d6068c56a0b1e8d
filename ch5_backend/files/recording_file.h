#pragma once
/// Recordings as folders of four text files: calibration.yaml, imu.csv, tracks.csv and, where the truth is known,
/// groundtruth.csv. Each CSV names its columns and units in its first line, by which they are found; time stamps are whole
/// nanoseconds.
///
///   imu.csv          #timestamp [ns],w_x [rad/s],w_y,w_z,a_x [m/s^2],a_y,a_z
///   tracks.csv       #timestamp [ns],track_id,x [normalized],y [normalized]        rows of an image together
///                    or one column more, camera: 0, or 1 for the calibration's camera1, under the same track_id
///   groundtruth.csv  #timestamp [ns],p_x [m],p_y,p_z,q_w,q_x,q_y,q_z,v_x [m/s],…,bg_x [rad/s],…,ba_x [m/s^2],…
///                    or groundtruth.txt in TUM's format, see ReadTum

#include <filesystem>
#include <string>
#include <vector>

#include "ch5_backend/files/csv_reader.h"
#include "ch5_backend/types/recording.h"

namespace ch5 {

/// Reads a folder; time 0 is the first IMU measurement.
/// @throws FileError "file:line: what is wrong, got value" for a missing file or column, a number that cannot be read or is not
///         finite, a timestamp that is repeated, goes backwards or is more than ten days from the first IMU measurement, a
///         track twice in an image, a point of a camera that has no calibration, a quaternion that is not of length 1, an unknown or missing key of the calibration,
///         fewer than two IMU measurements, no image, a table that ends within a line, or a truth whose quaternions agree with
///         the gyroscope in the order x, y, z, w only
/// @param left_out  if not null, rows of the tables that cannot be read are left out and counted here, unless they are many
/// @param imu_lines  if not null, the line of each IMU measurement in imu.csv
Recording ReadRecording(const std::filesystem::path& folder, std::vector<LeftOut>* left_out = nullptr,
                        std::vector<int>* imu_lines = nullptr);

/// Poses in TUM's format: `timestamp tx ty tz qx qy qz qw` in a line, in seconds; lines that begin with # are comments. IsTum
/// tells by the first pose. Velocities become differences of the positions.
/// @throws FileError likewise
bool IsTum(const std::string& path);
std::vector<StampedState> ReadTum(const std::string& path, int64_t origin_ns, std::vector<LeftOut>* left_out = nullptr);

/// What a table of poses lacks: velocities become differences of the positions.
/// @throws FileError at the csv's position if there is no pose
void CompleteTruth(const CsvReader& csv, bool has_velocity, std::vector<StampedState>* truth);

/// @param path  the file that recording.truth was read from
/// A truth in whose world gravity is not along −z is left out: whether it or the accelerometer is at fault, the images tell later.
/// @param left_out  null: that is thrown
/// @throws FileError if its quaternions agree with the gyroscope in another order only
void CheckTruth(const std::string& path, std::vector<LeftOut>* left_out, Recording* recording);

/// The calibration alone.
Calibration ReadCalibration(const std::filesystem::path& file);

/// A word of calibration.yaml that is not the calibration's.
struct EstimatorWord {
  std::string name, word;
  std::string where;  ///< its file and line, for messages
};
using EstimatorWords = std::vector<EstimatorWord>;
/// What calibration.yaml says besides the calibration.
struct CalibrationExtras {
  EstimatorWords estimator;           ///< of the section `estimator:`, for the program that uses it to judge
  std::vector<std::string> not_used;  ///< keys of cameras beyond camera1, as "file:line: key"
};
/// @throws FileError
CalibrationExtras ReadCalibrationExtras(const std::filesystem::path& file);

/// Writes a folder that ReadRecording reads back. An image without tracks has no row, so it is lost.
/// @throws WriteError and then an older recording in the folder is untouched
void WriteRecording(const Recording& recording, const std::filesystem::path& folder);

}  // namespace ch5
