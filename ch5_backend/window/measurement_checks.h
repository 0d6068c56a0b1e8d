#pragma once
/// Which measurements an estimator accepts.

#include <stdexcept>
#include <vector>

#include "ch5_backend/types/measurements.h"

namespace ch5 {

/// A measurement that cannot be used: its time is not after that of the previous one, a number is not finite, a track id
/// is repeated in an image, or the tracks cannot be on the normalized plane. The estimator is unchanged.
class MeasurementError : public std::invalid_argument {
 public:
  using std::invalid_argument::invalid_argument;
};

/// @param earlier  the measurements so far;  @throws MeasurementError
void CheckMeasurement(const ImuMeasurement& measurement, const std::vector<ImuMeasurement>& earlier);

/// @param last_time  of the previous image, −∞ for the first;  @throws MeasurementError
void CheckImage(const Image& image, double last_time);

/// The longest time between two consecutive measurements around a part of [t0, t1], or between an end of it and the nearest
/// measurement; infinite if there is none [s].
double LongestImuGap(const std::vector<ImuMeasurement>& imu, double t0, double t1);

}  // namespace ch5
