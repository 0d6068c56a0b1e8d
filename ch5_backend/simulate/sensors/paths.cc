#include "ch5_backend/simulate/sensors/paths.h"

#include <memory>
#include <stdexcept>

#include "ch5_backend/math/option_checks.h"
#include "ch5_backend/simulate/random.h"
#include "ch5_backend/simulate/sensors/spline.h"

namespace ch5 {
namespace {

// Scaled about the origin to a path of `length` meters.
Trajectory WithLength(const Trajectory::Formula& shape, double length, double duration) {
  const double scale = length / PathLength(Trajectory(shape, duration));
  const auto scaled = [shape, scale](const Jet& t) {
    Coordinates x = shape(t);
    for (Jet& coordinate : x.position) coordinate = scale * coordinate;
    return x;
  };
  return Trajectory(scaled, duration);
}

// One lap round a rectangle of 3×2: a closed spline, its corners rounded over the neighboring control points.
std::array<Spline, 2> RectangleLap(double duration) {
  const std::vector<std::array<double, 2>> corners = {{0, 0}, {1, 0}, {2, 0}, {3, 0}, {3, 1},
                                                      {3, 2}, {2, 2}, {1, 2}, {0, 2}, {0, 1}};
  std::vector<double> x, z;
  for (size_t k = 0; k < corners.size() + Spline::kDegree; ++k) {
    x.push_back(corners[k % corners.size()][0]);
    z.push_back(corners[k % corners.size()][1]);
  }
  const double spacing = duration / static_cast<double>(corners.size());
  return {Spline(x, 0.0, spacing), Spline(z, 0.0, spacing)};
}

Trajectory::Formula GaugePaperShape(GaugePath path, double duration) {
  switch (path) {
    case GaugePath::kSine:
      return [duration](const Jet& t) {
        const Jet phase = (2.0 * M_PI / duration) * t;
        const Jet sway = 0.15 * Sin(phase);
        return Coordinates{{2.0 * phase, 0.5 * Sin(2.0 * phase), Sin(phase)}, 0.5 * M_PI + sway, sway, 0.5 * sway};
      };
    case GaugePath::kArc:
      return [duration](const Jet& t) {
        const Jet angle = (2.0 * M_PI / 3.0 / duration) * t - M_PI / 3.0;  // −60° … 60°
        const Jet sway = 0.1 * Sin(3.0 * angle);
        return Coordinates{{Sin(angle), -1.0 * Cos(angle), 0.1 * Sin(3.0 * angle)}, 0.5 * M_PI + angle, sway, sway};
      };
    case GaugePath::kRectangle:
      return [duration, lap = RectangleLap(duration)](const Jet& t) {
        const Jet phase = (2.0 * M_PI / duration) * t;
        const Jet sway = 0.15 * Sin(phase);
        return Coordinates{{lap[0](t), 0.2 * Sin(phase), lap[1](t)}, 0.5 * M_PI + sway, 0.1 * Cos(phase), sway};
      };
  }
  throw std::invalid_argument("GaugePaperPath: no such path");
}

}  // namespace

Trajectory GaugePaperPath(GaugePath path) {
  constexpr double kLength = 5.0, kSpeed = 2.0;
  constexpr double kDuration = kLength / kSpeed;
  return WithLength(GaugePaperShape(path, kDuration), kLength, kDuration);
}

Trajectory Handheld(const HandheldOptions& o) {
  CheckPositive("HandheldOptions::duration", o.duration);
  CheckOption("HandheldOptions::duration", o.duration, 0, 1e6);
  CheckPositive("HandheldOptions::knot_spacing", o.knot_spacing);
  CheckNotNegative("HandheldOptions::standstill_seconds", o.standstill_seconds);
  CheckNotNegative("HandheldOptions::position_sigma", o.position_sigma);
  CheckNotNegative("HandheldOptions::yaw_step", o.yaw_step);
  CheckNotNegative("HandheldOptions::tilt_sigma", o.tilt_sigma);

  // Piece i ends at control point i + 5, so the first moving one is 5 after the last still piece. Two pieces before 0
  // and after the end leave room for a camera whose clock is off.
  constexpr int kMargin = 2;
  const double start = -kMargin * o.knot_spacing;
  const int still = static_cast<int>(std::ceil((o.standstill_seconds - start) / o.knot_spacing)) + Spline::kDegree;
  const int count = static_cast<int>(std::ceil(o.duration / o.knot_spacing)) + 2 * kMargin + Spline::kDegree;

  std::array<std::vector<double>, 6> control;  // x, y, z, yaw, pitch, roll
  Random random(o.seed);
  std::array<double, 6> c{};
  for (int k = 0; k < count; ++k) {
    if (k == 0 || k >= still || o.standstill_seconds == 0.0) {
      c[0] = o.position_sigma * random.TruncatedNormal(3.0);
      c[1] = o.position_sigma * random.TruncatedNormal(3.0);
      c[2] = 0.5 * o.position_sigma * random.TruncatedNormal(3.0);
      c[3] += o.yaw_step * random.Normal();
      c[4] = o.tilt_sigma * random.TruncatedNormal(3.0);
      c[5] = o.tilt_sigma * random.TruncatedNormal(3.0);
    }
    for (size_t i = 0; i < 6; ++i) control[i].push_back(c[i]);
  }
  auto splines = std::make_shared<std::vector<Spline>>();
  for (auto& points : control) splines->emplace_back(std::move(points), start, o.knot_spacing);
  const auto formula = [splines](const Jet& t) {
    const std::vector<Spline>& s = *splines;
    return Coordinates{{s[0](t), s[1](t), s[2](t)}, s[3](t), s[4](t), s[5](t)};
  };
  return Trajectory(formula, o.duration);
}

}  // namespace ch5
