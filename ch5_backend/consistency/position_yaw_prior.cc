#include "ch5_backend/consistency/position_yaw_prior.h"

#include <cmath>

#include "ch5_backend/marginalize/edge_prior.h"

namespace ch5 {

// The yaw's axis is gravity's, seen from the body: δθ is a right perturbation.
std::shared_ptr<Edge> MakePositionYawPrior(const std::shared_ptr<VertexPose>& pose, double information) {
  Prior prior;
  prior.vertices = {pose};
  prior.x0 = {pose->GetEstimate()};
  prior.J = MatXX::Zero(4, 6);
  prior.J.topLeftCorner<3, 3>().setIdentity();
  prior.J.bottomRightCorner<1, 3>() = pose->R().row(2);
  prior.J *= std::sqrt(information);
  prior.r0 = VecX::Zero(4);
  return std::make_shared<EdgePrior>(std::move(prior));
}

}  // namespace ch5
