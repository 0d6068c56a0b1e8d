#pragma once
/// A uniform quintic B-spline: four continuous derivatives, and each piece depends on six control points only, so that
/// equal control points give a curve exactly at rest.
///
/// Evaluated by de Boor's algorithm in Jet arithmetic, so that derivatives come with the value.
/// Source: de Boor, "A Practical Guide to Splines", ch. X.

#include <vector>

#include "ch5_backend/simulate/sensors/jet.h"

namespace ch5 {

class Spline {
 public:
  static constexpr int kDegree = 5;

  /// Piece i, for t in start + [i, i+1)·spacing, is shaped by the control points i … i+5.
  /// @param control_points  at least 6;  @param spacing  > 0 [s]
  /// @throws std::invalid_argument
  Spline(std::vector<double> control_points, double start, double spacing);

  /// The curve at `t`. Before its start and after its end the outermost pieces go on as polynomials.
  Jet operator()(const Jet& t) const;

 private:
  std::vector<double> c_;
  double start_, spacing_;
};

}  // namespace ch5
