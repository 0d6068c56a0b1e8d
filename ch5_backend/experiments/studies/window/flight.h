#pragma once
/// A simulated flight with few tracks, so that a picture can show each of them, through the windows of both policies.

#include <map>
#include <string>
#include <vector>

#include "ch5_backend/experiments/studies/matrices.h"
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

/// A frame of a window, and what is claimed of it from above.
struct PlacedFrame {
  int id;
  double t;       ///< [s]
  Vec3 p;         ///< [m]
  Mat22 claimed;  ///< covariance of x and y relative to the oldest frame, whose position and yaw are held [m²]
  std::optional<Vec3> truth;  ///< where it truly was [m]
};

/// The window laid upon the truth at its oldest frame by a shift and a turn about gravity: what errs there is what the
/// covariances are about. Without any truth the frames are where they are estimated.
/// @param window  with a graph at its present states;  @return empty if the truth has a gap at the oldest frame
std::vector<PlacedFrame> PlacedFrames(const Window& window, const std::vector<StampedState>& recorded);

/// Whether the window's prior has columns for the vertex.
bool IsInPrior(const Window& window, const Vertex& vertex);

/// What the slide that has led to this window has made of a vertex: "marginalized", "in the prior" or "untouched".
/// @param is_left  whether the window still has it
const char* FateOf(const Vertex& vertex, bool is_left, const Window& window);

/// What remains known of a window after it has slid.
struct WindowBefore {
  WindowBefore(std::string policy_name, const Window& window);

  /// Whether the slide has taken the landmark's depth into the prior: VINS-Mono's those whose host was the oldest frame and has
  /// left, though what else sees them may be used again; OKVIS's those that it erases.
  bool IsTaken(int id, const WindowLandmark& landmark, const Window& after) const;
  /// The vertices of frames and landmarks that had rows in H: "pose", "speed" or "landmark", by the frame's or landmark's id.
  using TellVertex =
      std::function<void(const char* kind, int id, bool is_keyframe, const Vertex& vertex, const char* fate)>;
  void ForEachVertex(const Window& after, const TellVertex& tell) const;

  std::string policy;
  std::vector<Frame> frames;
  std::map<int, WindowLandmark> landmarks;
  FirstRows rows;
  MatXX H;
};

}  // namespace ch5
