#pragma once
/// The Jacobians of an edge against central differences through the vertices' own ⊞.

#include <string>

#include "ch5_backend/graph/edge.h"

namespace ch5 {

struct JacobianCheck {
  double worst = 0.0;   ///< the largest |J − numeric| of all entries, relative to the largest of 1, |J| and ‖r‖
  std::string message;  ///< empty if right; else the type, which vertex, and both matrices
  explicit operator bool() const { return message.empty(); }
};

/// At the present states, which stay: call it at a random one, and where something is small or large.
/// f' ≈ (8 (f(h) − f(−h)) − (f(2h) − f(−2h))) / 12h with h = 1e-4: error O(h⁴), and ε‖r‖/h = 2e-12 ‖r‖ from rounding.
/// @param tolerance  for `worst`; NaN, a Jacobian that was not filled, is wrong
JacobianCheck CheckJacobians(Edge* edge, double tolerance = 2e-9);

}  // namespace ch5
