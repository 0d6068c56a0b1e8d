#pragma once
/// A visual-inertial recording as plain values: the measurements of one camera or two and an IMU on a body B, real or simulated.
///
/// Times `t` are seconds since `Recording::origin_ns`, each the nearest double of a whole number of nanoseconds, so
/// that NanosecondsAt returns the recorded time stamp exactly (up to kLongestRecordingNs from the origin).
///
/// `simulate/` makes recordings, `files/` reads and writes them, `evaluate/` compares estimates with their truth: see
/// simulate/sensors/simulation.h, files/recording_file.h, evaluate/trajectory_error.h.

#include <cmath>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "ch5_backend/types/measurements.h"

namespace ch5 {

/// From the IMU to a camera it is less; more is in another unit [m].
inline constexpr double kLongestLever = 20.0;

/// A pinhole without distortion, and its place on the body.
struct Camera {
  Transform T_B_C;                                    ///< camera coordinates into body coordinates
  double fx = 460.0, fy = 460.0, cx = 376, cy = 240;  ///< [px]
  int width = 752, height = 480;                      ///< [px]

  /// The mean of fx and fy [px], for what is the same in all directions.
  double FocalLength() const { return 0.5 * (fx + fy); }
  /// From the normalized plane to pixels and back.
  Vec2 Pixel(const Vec2& x) const { return {fx * x.x() + cx, fy * x.y() + cy}; }
  Vec2 Normalized(const Vec2& pixel) const { return {(pixel.x() - cx) / fx, (pixel.y() - cy) / fy}; }
  /// Whether a pixel lies in the image.
  bool Contains(const Vec2& pixel) const { return pixel.minCoeff() >= 0.0 && pixel.x() < width && pixel.y() < height; }
};

/// Camera 0, perhaps a second one that takes its images at the same times, and the IMU with its noise densities.
struct Calibration : Camera {
  std::optional<Camera> camera1;
  double camera_rate = 20.0, imu_rate = 200.0;  ///< nominal [Hz]
  ImuNoise noise{2e-3, 1.6968e-4, 3e-3, 1.9393e-5, /*continuous=*/true};
  double gravity = 9.81;  ///< along −z of W [m/s²]

  Vec3 GravityInWorld() const { return {0.0, 0.0, -gravity}; }

  /// @throws OptionError
  void Validate() const;
};

/// The recorder's clocks jumped together, when they were set or while nothing was recorded; times `t` leave the jump out, but
/// for a pause.
inline constexpr double kClockPause = 2.0;  // [s]
struct ClockStep {
  double t;           ///< within the pause that is left, which no estimator bridges
  int64_t ns;         ///< by so much more the stamps behind it are later than the times tell
  std::string where;  ///< file and line, for messages
};

struct Recording {
  int64_t origin_ns = 0;  ///< the recorder's time stamp at t = 0
  std::vector<ClockStep> clock_steps;
  Calibration calibration;
  std::vector<ImuMeasurement> imu;  ///< strictly increasing in time
  std::vector<Image> images;        ///< likewise
  std::vector<StampedState> truth;  ///< likewise; empty if unknown

  /// Of the times about t: the recorder's stamp is so many nanoseconds later.
  int64_t OriginAt(double t) const {
    int64_t origin = origin_ns;
    for (const ClockStep& step : clock_steps) origin += t > step.t ? step.ns : 0;
    return origin;
  }
};

/// Ten days: so far from the origin, doubles in seconds still resolve nanoseconds (10 d · 2⁻⁵³ < ½ ns).
inline constexpr int64_t kLongestRecordingNs = 864'000'000'000'000;

/// Between time stamps [ns] and times [s] since the origin.
inline double SecondsAt(int64_t stamp_ns, int64_t origin_ns) { return static_cast<double>(stamp_ns - origin_ns) / 1e9; }
inline int64_t NanosecondsAt(double t, int64_t origin_ns) { return origin_ns + std::llround(1e9 * t); }

/// The time rounded as a recorder with time stamps in whole nanoseconds does.
inline double RoundToNanosecond(double t) { return SecondsAt(NanosecondsAt(t, 0), 0); }

/// Why a camera's intrinsics cannot be pixels of its image; empty if they may be.
std::string WhyNotInPixels(const Camera& camera);

/// Why its IMU measurements cannot be in seconds and m/s², judging by their rate and by gravity; empty if they can be.
std::string WhyNotInUnits(const std::vector<ImuMeasurement>& imu, const Calibration& calibration);

/// What to say if no image, from the first at `first` to the last at `last` [s], lies within the IMU's time.
std::string ClocksDiffer(double first, double last, const std::vector<ImuMeasurement>& imu);

/// Sets the velocities to differences of the neighbors' positions, where a motion capture system gives none.
void DifferentiatePositions(std::vector<StampedState>* states);

/// The state at time `t`, interpolated between its neighbors: rotations along the shortest arc, the rest linearly.
/// @param states  strictly increasing in time
/// @return        nullopt before the first, after the last, and between two that are more than 1 s apart, as where a motion
///                capture system has lost sight
std::optional<StampedState> StateAt(const std::vector<StampedState>& states, double t);

}  // namespace ch5
