#pragma once
/// What distinguishes one sliding-window estimator from another: which images are keyframes, which landmarks are used,
/// how long a solve may take, and what leaves the window.

#include <memory>
#include <optional>
#include <string>

#include "ch5_backend/solve/minimizer.h"
#include "ch5_backend/window/window.h"

namespace ch5 {

class WindowPolicy {
 public:
  virtual ~WindowPolicy() = default;
  virtual std::string Name() const = 0;

  /// Called when a new frame is at the end of the window, before the solve.
  virtual void NoteNewFrame(Window* window) = 0;
  /// Whether a landmark with a depth takes part in the solve.
  virtual bool Uses(const Window& window, const WindowLandmark& landmark) const = 0;
  virtual SolveOptions Options() const = 0;
  /// Called after the solve, to restore what it left free (the gauge).
  virtual void AfterSolve(Window* /*window*/) {}
  /// Marginalizes or drops frames and landmarks, so that the window has room for another frame.
  virtual void Slide(Window* window) = 0;
  /// How many frames the window has at most after Slide, and so before the start too.
  virtual size_t MostFrames() const = 0;
  /// Discards all state of the run so far.
  virtual void Reset() {}
};

/// The window of VINS-Mono.
struct VinsOptions {
  int window_size = 10;           ///< frames beside the newest one
  int least_tracked = 20;         ///< fewer landmarks followed into the newest image make a keyframe
  double parallax_pixels = 10.0;  ///< more between the second and third newest frame makes a keyframe [px]
  /// So does a longer time between the third newest and the newest [s]: VINS-Mono leaves out the IMU between frames more
  /// than 10 s apart (WindowWeights::max_imu_seconds), and after such a pause nothing constrains velocity and biases.
  double keyframe_seconds = 5.0;
  double slow_seconds = 0.3;  ///< between images: from then on landmarks of all hosts are used, not only of older ones
  int max_iterations = 8;     ///< 5 lets no image take much longer than the others (GUIDE.md, recipes)
  double cost_tolerance = 1e-3;  ///< loose: the next image solves the window again
  int landmark_steps = 2;        ///< SolveOptions::landmark_steps
  /// Stops a solve by the clock, before the oldest frame leaves after 4/5 of it; VINS-Mono: 0.04. Without a limit, as a
  /// rule, the result is the same on every machine and under every load.
  std::optional<double> max_solve_seconds;
  /// A landmark whose host leaves keeps its other observations, though the prior contains them already. So does
  /// VINS-Mono, which uses them twice.
  bool reuse_observations = true;

  /// @throws OptionError
  void Validate() const;
};
/// VINS-Mono's window.  @throws OptionError
std::unique_ptr<WindowPolicy> MakeVinsPolicy(const VinsOptions& options = {});

/// The window of OKVIS.
struct OkvisOptions {
  int keyframes = 5;         ///< K
  int temporal_frames = 3;   ///< S, the newest
  double hull_ratio = 0.6;   ///< an image is no keyframe if both its ImageOverlap with the last keyframe …
  double match_ratio = 0.2;  ///< … in hull area and in matches is greater
  /// … and it sees the common points from directions that differ by less [rad]. OKVIS has no such limit, since from 20°
  /// aside its features no longer match; of tracks that never end, as in simulations, it would keep the first keyframes.
  double view_angle = 0.35;
  double gauge_information = 1e8;         ///< on position and yaw of the first frame [1/m², 1/rad²] …
  double later_gauge_information = 1e14;  ///< … and of the oldest frame once the first has left
  int max_iterations = 10;                ///< see VinsOptions
  double cost_tolerance = 1e-3;           ///< loose: the next image solves the window again
  int landmark_steps = 2;                 ///< SolveOptions::landmark_steps

  /// @throws OptionError
  void Validate() const;
};
/// OKVIS's window.  @throws OptionError
std::unique_ptr<WindowPolicy> MakeOkvisPolicy(const OkvisOptions& options = {});

}  // namespace ch5
