#pragma once
/// A simulated flight with few tracks, so that a picture can show each of them, through the windows of both policies.

#include "ch5_backend/experiments/studies/odometry.h"

namespace ch5 {

struct FlightOptions {
  double camera_rate = 5.0;  ///< [Hz]; at 15 Hz not every image is a keyframe
  int max_tracks = 12;       ///< per image
  double pixel_sigma = 1.0;  ///< [px]
};

constexpr size_t kFlightWindow = 8;  ///< frames of a window before it slides

/// 8 s by hand through a room.
Recording Flight(const FlightOptions& options);

/// "vins" or "okvis". Both keep seven frames: VINS-Mono the newest, OKVIS three keyframes and four newest.
std::unique_ptr<WindowPolicy> MakeFlightPolicy(const std::string& name);

/// An estimator at the true first state: roll, pitch, speed and biases are known, position and yaw are not.
std::unique_ptr<Estimator> StartFlight(const Recording& recording, std::unique_ptr<WindowPolicy> policy);

/// The first `images` images from there on.
void Fly(Recording recording, size_t images, std::unique_ptr<WindowPolicy> policy, const OdometryCallback& watch);

/// Whether the window's prior has columns for the vertex.
bool IsInPrior(const Window& window, const Vertex& vertex);

/// What the slide that has led to this window has made of a vertex: "marginalized", "in the prior" or "untouched".
/// @param is_left  whether the window still has it
const char* FateOf(const Vertex& vertex, bool is_left, const Window& window);

}  // namespace ch5
