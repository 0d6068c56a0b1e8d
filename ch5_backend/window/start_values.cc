#include "ch5_backend/window/start_values.h"

#include <algorithm>

#include "ch5_backend/math/so3.h"

namespace ch5 {

void SetCalibration(const EstimatorOptions& options, Window* window) {
  window->calibration = options.calibration;
  window->extrinsic->SetPose(options.calibration.T_B_C.q, options.calibration.T_B_C.p);
  window->extrinsic->SetFixed(!options.estimate_extrinsic);
  if (const auto& camera1 = options.calibration.camera1) {
    window->extrinsic1 = std::make_shared<VertexPose>(camera1->T_B_C.q, camera1->T_B_C.p);
    window->extrinsic1->SetFixed(!options.estimate_extrinsic);
  }
  window->time_offset->SetEstimate(VertexScalar::Estimate(options.time_offset));
  window->time_offset->SetFixed(!options.estimate_time_offset);
}

namespace {

// The specific force at rest,  f = R_W_Bᵀ g ẑ + b_a,  which the frame's state explains:  δf = (R_W_Bᵀ g ẑ)^ δθ + δb_a.
// Tilt and bias are known together, yaw is not.
void AddForceAtRest(const Frame& frame, double gravity, Prior* prior) {
  const Eigen::Index n = prior->J.rows();
  prior->vertices.push_back(frame.pose);
  prior->x0.push_back(frame.pose->Parameters());
  prior->J.conservativeResizeLike(MatXX::Zero(n + 3, n + 6));
  prior->J.block<3, 3>(n, 3) = Mat33::Identity() / kForceAtRestSigma;  // b_a: speed and biases come first
  prior->J.bottomRightCorner<3, 3>() = Hat(frame.pose->R().transpose() * Vec3(0, 0, gravity)) / kForceAtRestSigma;
}

}  // namespace

std::shared_ptr<EdgePrior> StartPrior(const Window& window, double speed, const EstimatorOptions& options,
                                      bool knows_gravity) {
  Prior prior;
  std::vector<double> sigmas;
  const auto add = [&](const std::shared_ptr<Vertex>& vertex, std::initializer_list<double> sigma_of_three) {
    if (vertex->IsFixed()) return;
    prior.vertices.push_back(vertex);
    prior.x0.push_back(vertex->Parameters());
    for (const double sigma : sigma_of_three) {
      for (int k = 0; k < std::min(3, vertex->LocalDimension()); ++k) sigmas.push_back(sigma);
    }
  };
  // At rest one component of the accelerometer's bias is seen, along gravity; the other two may be as large.
  const VertexSpeedBias& start = *window.frames.front().speed_bias;
  const double bias_accelerometer = std::max(options.start_bias_accelerometer, start.b_a().norm());
  add(window.frames.front().speed_bias, {speed, bias_accelerometer, options.start_bias_gyroscope});
  add(window.extrinsic, {options.start_extrinsic_position, options.start_extrinsic_rotation});
  if (window.extrinsic1) {
    add(window.extrinsic1, {options.start_extrinsic_position, options.start_extrinsic_rotation});
  }
  add(window.time_offset, {options.start_time_offset});
  prior.J = Eigen::Map<VecX>(sigmas.data(), static_cast<Eigen::Index>(sigmas.size())).cwiseInverse().asDiagonal();
  if (knows_gravity) AddForceAtRest(window.frames.front(), options.calibration.gravity, &prior);
  prior.r0 = VecX::Zero(prior.J.rows());
  return std::make_shared<EdgePrior>(std::move(prior));
}

}  // namespace ch5
