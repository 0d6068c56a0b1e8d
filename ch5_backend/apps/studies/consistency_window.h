#pragma once
/// The plainest sliding window, to ask whether it is as certain as it has a right to be.
///
/// The oldest frame leaves together with the landmarks it hosts; their observations enter the prior, once. Neither
/// losses nor outliers, and points rather than inverse depths, whose first view counts as exact: so the covariance
/// ought to be that of the error.

#include <map>
#include <memory>

#include "ch5_backend/marginalize/first_estimates.h"
#include "ch5_backend/types/edge_imu.h"
#include "ch5_backend/world/recording.h"

namespace ch5 {

struct ConsistencyPolicy {
  FirstEstimates first_estimates = FirstEstimates::kNone;
  /// VINS-Mono's way with a landmark whose host leaves: its other observations are used again, though the prior holds
  /// them already.
  bool reuse_observations = false;
};

/// σ of the first state, for the prior and for whoever draws it. The speed is known so little since in W it tells yaw.
struct StartSigma {
  double position = 0.01;  ///< [m]
  double yaw = 0.01;       ///< [rad]
  double tilt = 0.01;      ///< roll and pitch [rad]
  double speed = 0.2;      ///< [m/s]
  double b_a = 0.02;       ///< [m/s²]
  double b_g = 0.002;      ///< [rad/s]
};

/// What the window says of its newest frame.
struct WindowAnswer {
  StampedState state;
  Mat66 pose_covariance = Mat66::Zero();  ///< of [δp, δθ], right perturbation
};

class ConsistencyWindow {
 public:
  /// @param first  the state at the first image, drawn around the truth;  @param J_start  square root of its information
  ConsistencyWindow(const Calibration& calibration, double pixel_sigma, size_t size, const ConsistencyPolicy& policy,
                    const StampedState& first, const MatXX& J_start);

  /// One image and the samples since the one before: predicts, solves, answers, slides.
  WindowAnswer AddFrame(const CameraFrame& image, const std::vector<ImuSample>& samples);

 private:
  struct Frame {
    int id = 0;
    double t = 0.0;
    std::shared_ptr<VertexPose> pose;
    std::shared_ptr<VertexSpeedBias> speed_bias;
    std::shared_ptr<Edge> imu;  // from the frame before
  };
  struct Landmark {
    std::vector<std::pair<int, Vec2>> views;  // frame's id; the first is the host's
    std::shared_ptr<VertexPointXYZ> point;
  };

  void Predict(const CameraFrame& image, const std::vector<ImuSample>& samples);
  bool Triangulate(Landmark* landmark) const;
  std::vector<std::shared_ptr<Edge>> MakeEdges() const;
  std::vector<std::shared_ptr<Edge>> EdgesOf(const Landmark& landmark) const;
  void Solve(const std::vector<std::shared_ptr<Edge>>& edges) const;
  WindowAnswer Answer(const std::vector<std::shared_ptr<Edge>>& edges) const;
  std::vector<std::shared_ptr<Edge>> Linearised(std::vector<std::shared_ptr<Edge>> edges) const;
  void Slide();
  const Frame& At(int id) const { return frames_[static_cast<size_t>(id - frames_.front().id)]; }

  Calibration calibration_;
  double pixel_sigma_;
  size_t size_;
  ConsistencyPolicy policy_;
  std::vector<Frame> frames_;
  std::map<int, Landmark> landmarks_;
  std::shared_ptr<EdgePrior> prior_;
};

}  // namespace ch5
