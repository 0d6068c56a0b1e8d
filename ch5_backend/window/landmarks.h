#pragma once
/// The landmarks of a window: triangulation, change of host, removal.

#include <functional>

#include "ch5_backend/window/window.h"

namespace ch5 {

/// The depth of a landmark that cannot be triangulated [m], and the least depth that is accepted (VINS-Mono).
constexpr double kInitialDepth = 5.0;
constexpr double kLeastDepth = 0.1;

/// Depth in the host's camera from all its observations, with those of camera 1 where it determines depths: the smallest
/// singular vector of the rays' equations.
/// @return meters; kInitialDepth if less than kLeastDepth comes out, or nothing finite
double TriangulateDepth(const Window& window, const WindowLandmark& landmark);

/// Appends an image to a landmark's track and updates the track's image velocities. With three images or more, the
/// velocity of an observation is not computed from that observation itself: with its noise n/Δt in ẋ, the product r·ẋ,
/// which drives the time offset, would have the mean σ²/Δt instead of zero, and the offset would drift.
///
///   inside   ẋ_k = (x_{k+1} − x_{k−1}) / (t_{k+1} − t_{k−1}),     at an end   the slope between the next two
void AppendToTrack(const RecentPoint& point, WindowLandmark* landmark);

/// Adds what camera 1 sees in the image that was appended last. A point that camera 0 does not see there is passed over
/// (as in VINS-Fusion): each landmark has its host in camera 0.
void AppendSecondView(const RecentPoint& point, WindowLandmark* landmark);

/// Sets the image velocities of landmarks with a depth to what the states of their frames say, where a frame has a speed:
///
///   p_C = z [x, 1],   ṗ_C = −ω_C × p_C − v_C,   ẋ = (ṗ_C.xy − x ṗ_C.z) / z       ω by the gyroscope less its bias
///
/// The noise of differences of pixels, σ/(√2 Δt), belongs to each observation by itself, so poses and depths cannot take it up
/// as they take up most of what an offset does; where points move slowly it is most of H's entry for the offset, which then
/// stays near its start (errors in variables). A speed's error is common to all points.
void SetVelocitiesByMotion(Window* window);

/// Appends the points of an image to their tracks, those of camera 1 if the window has one.
/// @param frame  id of the image's frame
void AppendImage(int frame, const Image& image, Window* window);

/// The newest frame sees an image in place of the one before, at the same place; landmarks that it alone has seen, and whose
/// tracks have ended, go.
void ReplaceNewestImage(const Image& image, Window* window);

/// Gives a depth to every landmark that has none and is seen at least twice, or by both cameras at once.
void TriangulateLandmarks(Window* window);

/// The landmark in the world, at its present depth.
Vec3 LandmarkInWorld(const Window& window, const WindowLandmark& landmark);

/// Depth of the point `p_W` in the camera `T_W_C` [m], negative behind it.
inline double DepthInCamera(const Transform& T_W_C, const Vec3& p_W) {
  return (T_W_C.q.conjugate() * (p_W - T_W_C.p)).z();
}

/// Removes the observations of a frame from every landmark. A landmark hosted there gets its next frame as host, with the
/// depth in that camera (kInitialDepth if it lies behind); it is erased if only one observation is left. A track without
/// a depth is kept while it has any observation.
/// @param depth_in  as DepthInCamera
void ForgetObservations(int frame, const std::function<double(const Transform& T_W_C, const Vec3& p_W)>& depth_in,
                        Window* window);
inline void ForgetObservations(int frame, Window* window) { ForgetObservations(frame, DepthInCamera, window); }

/// Erases landmarks with a negative depth, on which the solve has failed (VINS-Mono's removeFailures).
void RemoveFailures(Window* window);

/// The same, and erases landmarks whose mean reprojection error exceeds `max_error`, or twice the median of all landmarks
/// where images are noisier than that, up to 3 max_error. Before that, where at least half of the observations of a landmark
/// fit, those with an error of more than 30 max_error are removed as false matches; and a landmark that fits camera 0 alone
/// stays, without what camera 1 sees of it.
/// @param max_error  on the normalized plane
void RemoveOutliers(double max_error, Window* window);

/// How many landmarks both frames see, and by how much their points differ on average, on the normalized plane.
struct Parallax {
  int common = 0;
  double mean = 0.0;
};
/// Between two frames of the window.
Parallax ParallaxBetween(const Window& window, int frame_a, int frame_b);

}  // namespace ch5
