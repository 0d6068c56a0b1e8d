#include "ch5_backend/initialize/chordal.h"

#include <Eigen/SVD>

#include "ch5_backend/initialize/linear_shift.h"
#include "ch5_backend/initialize/planar.h"
#include "ch5_backend/initialize/spanning_tree.h"
#include "ch5_backend/types/pose_graph/as_transform.h"

namespace ch5 {
namespace {

// The nearest rotation by Frobenius' norm.
Mat33 ProjectToSO3(const Mat33& A) {
  const Eigen::JacobiSVD<Mat33> svd(A, Eigen::ComputeFullU | Eigen::ComputeFullV);
  const Mat33 UVt = svd.matrixU() * svd.matrixV().transpose();
  return svd.matrixU() * Vec3(1.0, 1.0, UVt.determinant()).asDiagonal() * svd.matrixV().transpose();
}

// R_j − R_i R_ij, transposed, is one linear problem with three right-hand sides:  R_jᵀ − R_ijᵀ R_iᵀ.
void PlaceRotations(const std::vector<Edge*>& edges, const std::vector<bool>& is_held, Graph* graph, int threads) {
  LinearShift<3, 3> relaxed(*graph, edges, is_held);
  const auto R_T = [](const Edge& edge, size_t end) {
    return Mat33(PoseOf(*edge.Vertices()[end])->q.conjugate().toRotationMatrix());
  };
  for (const Edge* edge : edges) {
    const Mat33 R_i_j_T = MeasurementOf(*edge)->q.conjugate().toRotationMatrix();
    const double kappa = edge->Information().diagonal().tail(edge->ResidualDimension() == 6 ? 3 : 1).mean();
    relaxed.Add<3>(*edge, R_T(*edge, 1) - R_i_j_T * R_T(*edge, 0), -R_i_j_T, Mat33::Identity(),
                   kappa * Mat33::Identity());
  }
  relaxed.Solve(threads);
  for (const auto& vertex : graph->Vertices()) {
    const Mat33 shift = relaxed.Of(*vertex);
    if (shift.isZero(0.0)) continue;
    const Transform pose = *PoseOf(*vertex);
    const Mat33 R = ProjectToSO3(pose.q.toRotationMatrix() + shift.transpose());
    MoveTo({Qd(R), pose.p}, vertex.get());
  }
}

// The residual is linear in positions:  r + J_i δ_i + J_j δ_j,  exactly.
void PlacePositions(const std::vector<Edge*>& edges, const std::vector<bool>& is_held, Graph* graph, int threads) {
  LinearShift<3> linear(*graph, edges, is_held);
  for (Edge* edge : edges) {
    edge->Linearize();
    linear.Add<6>(*edge, edge->Residual(), edge->Jacobian(0).leftCols<3>(), edge->Jacobian(1).leftCols<3>(),
                  edge->Information());
  }
  linear.Solve(threads);
  for (const auto& vertex : graph->Vertices()) {
    if (const Vec3 shift = linear.Of(*vertex); !shift.isZero(0.0)) vertex->Parameters().head<3>() += shift;
  }
}

// The edges with a measured transform whose poses are in space (size 6) or in the plane (3).
std::vector<Edge*> EdgesOfSize(int size, const Graph& graph) {
  std::vector<Edge*> edges;
  for (const auto& edge : graph.Edges()) {
    const bool in_space = MeasurementOf(*edge) && edge->ResidualDimension() == 6;
    const bool in_plane = dynamic_cast<const EdgeSE2Between*>(edge.get());
    if (size == 6 ? in_space : in_plane) edges.push_back(edge.get());
  }
  return edges;
}

}  // namespace

void PlaceByChordalRelaxation(Graph* graph, int threads) {
  if (graph->Vertices().empty()) return;
  PlaceAlongTree(TreeOrder::kBreadthFirst, graph);
  std::vector<bool> is_held(graph->Vertices().size(), false);
  for (const auto& root : FindRoots(*graph)) is_held[graph->PositionOf(*root)] = true;
  if (const std::vector<Edge*> edges = EdgesOfSize(6, *graph); !edges.empty()) {
    PlaceRotations(edges, is_held, graph, threads);
    PlacePositions(edges, is_held, graph, threads);
  }
  if (const std::vector<Edge*> edges = EdgesOfSize(3, *graph); !edges.empty()) {
    PlaceRotations(edges, is_held, graph, threads);
    PlaceInPlane(edges, is_held, graph, threads);
  }
}

}  // namespace ch5
