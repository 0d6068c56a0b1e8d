#pragma once
/// Readings of an IMU that its sensors cannot have felt.

#include <string>
#include <vector>

#include "ch5_backend/experiments/studies/odometry_study.h"

namespace ch5 {

/// Leaves out readings of zeros, those that repeat one in a row and single spikes (what is out for longer than
/// EstimatorOptions::max_imu_gap is a gap), and interpolates values that are held for several readings each. Names these,
/// readings at a rail, and axes that say nothing while the body turns. A sensor without noise may do all this.
/// @param path    of imu.csv;  @param lines  of each measurement in it
/// @param strict  what would be left out is refused
/// @throws FileError if so
RecordingWarnings CheckReadings(const std::string& path, std::vector<int> lines, bool strict, Recording* recording);

}  // namespace ch5
