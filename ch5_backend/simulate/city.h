#pragma once
/// A city to be adjusted: a car drives through all streets, and its camera, ahead, sees points of the façades.
///
///   ┌─┬─┬─┐   n + 1 streets each way, 60 m apart, first those from west to east, to and fro, then those from south to
///   ├─┼─┼─┤   north: each crossing is passed twice, which closes loops. A picture every 2 m; a camera has 1.5 m of height,
///   ├─┼─┼─┤   90° of view and its own f, k1, k2. Points at 8 m on both sides of a street, up to 10 m high, are seen from 3
///   └─┴─┴─┘   to 30 m, from their façade's front; buildings hide nothing else, but one view in five fails.
///
/// A camera sees neighbors only, a few hundred points, and a point has some ten views, however large the city is.

#include "ch5_backend/types/bal/bal_problem.h"

namespace ch5 {

/// How large the city is, and how far measurements and start are from the truth.
struct CityOptions {
  int cameras = 100;
  double points_per_meter = 30.0;  ///< of street, both sides
  double pixel_sigma = 0.5;        ///< noise of each observation [px]
  double position_sigma = 0.1;     ///< of the starting cameras [m]
  double rotation_sigma = 2e-3;    ///< likewise [rad]
  double point_sigma = 0.3;        ///< of the starting points [m]
  uint64_t seed = 1;
};

/// A problem, and its truth.
struct City {
  BalProblem start;           ///< to be solved
  std::vector<Vec9> cameras;  ///< the truth
  std::vector<Vec3> points;
};

/// Points with fewer than three views are left out.
/// @throws OptionError if there are fewer than 2 cameras, no points, or if a σ is negative or not finite
City SimulateCity(const CityOptions& options);

}  // namespace ch5
