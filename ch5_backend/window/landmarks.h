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

/// Gives a depth to every landmark that has none and is seen at least twice.
void TriangulateLandmarks(Window* window);

/// The landmark in the world, at its present depth.
Vec3 LandmarkInWorld(const Window& window, const WindowLandmark& landmark);

/// Takes the observations of a frame out of every landmark. One that is hosted there moves to its next frame: its
/// depth is expressed in that camera (kInitialDepth if it lies behind), or it is erased if that was its last but one.
/// A track without a depth yet lives on while anything is left of it.
void ForgetObservations(int frame, Window* window);

/// Erases landmarks with a negative depth: the solve has failed on them (VINS-Mono's removeFailures).
/// @return how many
int RemoveFailures(Window* window);

/// Erases landmarks whose reprojections are off by more than `max_error` on average, all of one track.
/// @param max_error  on the normalised plane;  @return how many
int RemoveOutliers(double max_error, Window* window);

/// How many landmarks both frames see, and by how much their points differ on average, on the normalised plane.
struct Parallax {
  int common = 0;
  double mean = 0.0;
};
Parallax ParallaxBetween(const Window& window, int frame_a, int frame_b);

}  // namespace ch5
