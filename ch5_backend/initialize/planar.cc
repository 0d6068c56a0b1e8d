#include "ch5_backend/initialize/planar.h"

#include "ch5_backend/initialize/linear_shift.h"
#include "ch5_backend/types/pose_graph/edge_between.h"

namespace ch5 {
namespace {

using Mat11 = Eigen::Matrix<double, 1, 1>;

void PlaceAngles(const std::vector<Edge*>& edges, const std::vector<bool>& is_held, Graph* graph, int threads) {
  LinearShift<1> linear(*graph, edges, is_held);
  for (Edge* edge : edges) {
    edge->ComputeResidual();
    linear.Add<1>(*edge, Mat11(edge->Residual()[2]), Mat11(-1.0), Mat11(1.0), Mat11(edge->Information()(2, 2)));
  }
  linear.Solve(threads);
  for (const auto& vertex : graph->Vertices()) {
    const double phi = linear.Of(*vertex)[0];
    if (phi != 0.0) vertex->Plus(Vec3(0.0, 0.0, phi).data());
  }
}

//   ∂r/∂θ_i = R_zᵀ [y, −x]ᵀ of [x, y]ᵀ = p_z, else as in EdgeSE2Between::ComputeJacobians
void PlacePoses(const std::vector<Edge*>& edges, const std::vector<bool>& is_held, Graph* graph, int threads) {
  LinearShift<3> linear(*graph, edges, is_held);
  for (Edge* edge : edges) {
    edge->Linearize();
    const auto& between = static_cast<const EdgeSE2Between&>(*edge);
    const Vec2 p_z = between.p_z();
    Mat33 J_i = edge->Jacobian(0);
    J_i.topRightCorner<2, 1>() = Rotation2(-between.ThetaZ()) * Vec2(p_z.y(), -p_z.x());
    linear.Add<3>(*edge, edge->Residual(), J_i, edge->Jacobian(1), edge->Information());
  }
  linear.Solve(threads);
  for (const auto& vertex : graph->Vertices()) {
    if (const Vec3 shift = linear.Of(*vertex); !shift.isZero(0.0)) vertex->Plus(shift.data());
  }
}

}  // namespace

void PlaceInPlane(const std::vector<Edge*>& edges, const std::vector<bool>& is_held, Graph* graph, int threads) {
  PlaceAngles(edges, is_held, graph, threads);
  PlacePoses(edges, is_held, graph, threads);
}

}  // namespace ch5
