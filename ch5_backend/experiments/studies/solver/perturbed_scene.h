#pragma once
/// The course's scene in other sizes, with a start away from the truth.

#include <cmath>

#include "ch5_backend/simulate/mono_ba.h"

namespace ch5 {

/// @param position_sigma  of the start [m];  @param rotation_sigma  likewise [rad]
/// @param ba  a weak prior, of the observations' own information, holds the gauge
inline void BuildPerturbed(int frames, int points, double position_sigma, double rotation_sigma, MonoBa* ba) {
  MonoBaOptions options;
  options.frames = frames;
  options.points = points;
  options.position_sigma = position_sigma;
  options.rotation_sigma = rotation_sigma;
  const double information = 1.0 / std::pow(options.pixel_sigma, 2);
  BuildMonoBa(SimulateMonoBa(options), Gauge::kPriorMinimal, information, information, ba);
}

}  // namespace ch5
