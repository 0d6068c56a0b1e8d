#pragma once
/// The uncertainty of one frame of a window.

#include <optional>

#include "ch5_backend/window/window.h"

namespace ch5 {

/// Covariance of a state, and of the calibration as far as it is estimated. Position and yaw are measured by nothing, so
/// their part needs to be compared with what it holds.
struct StateCovariance {
  enum class Reference {
    kWorld,       ///< the prior of the window contains position and yaw in W
    kOldestFrame  ///< position and yaw are held at the window's oldest frame: the covariance is relative to it
  };
  Reference reference = Reference::kOldestFrame;
  Mat1515 state = Mat1515::Zero();  ///< of [δp, δθ, δv, δb_a, δb_g], right perturbation; [m, rad, m/s, m/s², rad/s]
  std::optional<Mat66> extrinsic;              ///< of [δp, δθ] of T_B_C
  std::optional<Mat66> extrinsic1;             ///< likewise of camera 1
  std::optional<double> time_offset_variance;  ///< [s²]

  Mat66 Pose() const { return state.topLeftCorner<6, 6>(); }
};

/// From the window's last graph at the present states. A gauge prior that the policy has placed on the oldest frame counts
/// as holding it.
/// @param frame  of the window, with speed and biases
StateCovariance CovarianceOf(const Window& window, const Frame& frame);

/// Of any free vertex of that graph that is no landmark, such as one of one's own (EstimatorOptions::own_edges).
/// @throws CovarianceError naming one that is fixed, a landmark, or not there
MatXX CovarianceOf(const Window& window, const Vertex& vertex);

/// Of the pose of each frame, [δp, δθ], relative to the oldest: position and yaw are held there, whatever else holds them.
std::vector<Mat66> PoseCovariances(const Window& window);

/// The σ of the scale: of the way from the oldest frame to the one farthest from it, relative to that way. Of little meaning
/// at rest, and in a window whose gauge prior is the world's.
/// @return nullopt if no frame has moved by a millimeter
std::optional<double> ScaleSigma(const Window& window);

}  // namespace ch5
