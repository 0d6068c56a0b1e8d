#pragma once
/// How late the camera's clock is, found out before a recording is followed.

#include <cmath>
#include <optional>

#include "ch5_backend/evaluate/turn_agreement.h"
#include "ch5_backend/experiments/studies/odometry.h"

namespace ch5 {

struct ClockOffset {
  double offset = 0.0;  ///< an image stamped t was taken at t + offset: VINS-Mono's td [s]
  double sigma = 0.0;   ///< [s]
};

/// Both policies estimate the offset on the first part of the recording, each beside its states. They weigh the same data in
/// two ways, so that the spread of their estimates, at three times each, is an error that holds the unknown ones too: where
/// an estimator's own σ says ±0.1 ms, the estimates of two differ by up to 3 ms if the clocks agree.
/// @param guess  where the estimates begin [s]
/// @return nullopt if one of them does not start, restarts, or hardly leaves its guess
std::optional<ClockOffset> EstimateClockOffset(const Recording& recording, EstimatorOptions options, double guess);

/// Makes the delay of the camera's clock the same all along. Of clocks that run apart, the IMU's is set to the camera's. At a
/// jump, the sensor whose stamps leave a gap moves back and closes it; if none does, stamps were lost, and the one that was
/// behind moves ahead.
void EvenOut(const DelayChange& change, Recording* recording);

/// Whether an offset clearly exceeds its error.
inline bool IsDecided(const ClockOffset& clock) { return std::abs(clock.offset) > 3.0 * clock.sigma; }

}  // namespace ch5
