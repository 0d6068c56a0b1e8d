#pragma once
/// The course's scene in other sizes, with a start away from the truth.

#include <cmath>

#include "ch5_backend/simulate/mono_ba.h"

namespace ch5 {

/// A weak prior, of the observations' own information, holds the gauge.
/// @param position_sigma  of the start [m];  @param rotation_sigma  likewise [rad]
inline MonoBa BuildPerturbed(int frames, int points, double position_sigma, double rotation_sigma) {
  MonoBaOptions options{frames, points};
  options.position_sigma = position_sigma;
  options.rotation_sigma = rotation_sigma;
  const double information = 1.0 / std::pow(options.pixel_sigma, 2);
  return BuildMonoBa(SimulateMonoBa(options), Gauge::kPriorMinimal, information, information);
}

}  // namespace ch5
