#include "ch5_backend/simulate/sensors/spline.h"

#include <algorithm>
#include <array>
#include <stdexcept>
#include <string>

namespace ch5 {

Spline::Spline(std::vector<double> control_points, double start, double spacing)
    : c_(std::move(control_points)), start_(start), spacing_(spacing) {
  if (c_.size() <= kDegree) {
    throw std::invalid_argument("Spline: " + std::to_string(c_.size()) + " control points, at least 6 are needed");
  }
  if (!(spacing > 0.0)) {
    throw std::invalid_argument("Spline: spacing = " + std::to_string(spacing) + ", must be positive");
  }
}

// With u = (t − start)/spacing = i + f, and d_j = c_{i+j} for j = 0 … 5:
//   round r = 1 … 5:   d_j ← (1 − α) d_{j−1} + α d_j,   α = (f + 5 − j)/(6 − r),   j = 5 … r;   the value is d_5
Jet Spline::operator()(const Jet& t) const {
  const double pieces = static_cast<double>(c_.size() - kDegree);
  const Jet u = (t - start_) * (1.0 / spacing_);
  const double i = std::clamp(std::floor(u.value), 0.0, pieces - 1.0);
  const Jet f = u - i;

  std::array<Jet, kDegree + 1> d;
  for (int j = 0; j <= kDegree; ++j) d[j] = c_[static_cast<size_t>(i) + j];
  for (int r = 1; r <= kDegree; ++r) {
    for (int j = kDegree; j >= r; --j) {
      const Jet alpha = (f + (kDegree - j)) * (1.0 / (kDegree + 1 - r));
      d[j] = d[j - 1] + alpha * (d[j] - d[j - 1]);
    }
  }
  return d[kDegree];
}

}  // namespace ch5
