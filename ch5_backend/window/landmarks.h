#pragma once
/// What happens to the landmarks of a window: triangulated, given another host, forgotten.

#include "ch5_backend/window/window.h"

namespace ch5 {

/// The depth that a landmark gets where none can be measured [m], and the least that counts as one (VINS-Mono).
constexpr double kInitialDepth = 5.0;
constexpr double kLeastDepth = 0.1;

/// Depth in the host's camera from all its observations: the smallest singular vector of the rays' equations.
/// @return metres; kInitialDepth if less than kLeastDepth comes out, or nothing finite
double TriangulateDepth(const Window& window, const WindowLandmark& landmark);

/// Appends an image to a landmark's track, and says how fast the track moves in the image. Where the track has three
/// images or more, no observation's velocity is made from the observation itself: with its own noise in it, n/Δt, the
/// product r·ẋ that moves the time offset would have the mean σ²/Δt in place of zero, and drive the offset away.
///
///   inside   ẋ_k = (x_{k+1} − x_{k−1}) / (t_{k+1} − t_{k−1}),     at an end   the slope between the next two
void AppendToTrack(const RecentPoint& point, WindowLandmark* landmark);

/// Gives a depth to every landmark that has none and is seen at least twice.
void TriangulateLandmarks(Window* window);

/// The landmark in the world, at its present depth.
Vec3 LandmarkInWorld(const Window& window, const WindowLandmark& landmark);

/// How firmly its observations hold a landmark in space, from 0 (not at all) to 1: √(λ_min/λ_max) of its 3×3
/// information, 0 if λ_min < 1e-12 (OKVIS).
/// @param sqrt_information  of an observation on the normalised plane
double LandmarkQuality(const Window& window, const WindowLandmark& landmark, double sqrt_information);

/// Takes the observations of a frame out of every landmark. One that is hosted there moves to its next frame: its
/// depth is expressed in that camera (kInitialDepth if it lies behind), or it is erased if that was its last but one.
/// A track without a depth yet lives on while anything is left of it.
void ForgetObservations(int frame, Window* window);

/// Erases landmarks with a negative depth: the solve has failed on them (VINS-Mono's removeFailures).
/// @return how many
int RemoveFailures(Window* window);

/// Erases landmarks whose reprojections are off by more than `max_error` on average, all of one track.
/// Before that, a newest observation that alone is off by 30 times as much is taken away as a false match.
/// @param max_error  on the normalised plane;  @return how many
int RemoveOutliers(double max_error, Window* window);

/// How many landmarks both frames see, and by how much their points differ on average, on the normalised plane.
struct Parallax {
  int common = 0;
  double mean = 0.0;
};
Parallax ParallaxBetween(const Window& window, int frame_a, int frame_b);

}  // namespace ch5
