#include "ch5_backend/initialize/chordal.h"

#include <Eigen/SVD>
#include <array>

#include "ch5_backend/initialize/spanning_tree.h"
#include "ch5_backend/sparse/sparse_optimizer.h"
#include "ch5_backend/types/pose_graph/as_transform.h"

namespace ch5 {
namespace {

// Solves a linear problem, in one step. So little damping that it only keeps in place what no edge determines: the
// weakest direction of a chain of n poses has about 1/n² of the diagonal.
void SolveLinear(Graph* graph, int threads) {
  SparseOptimizer optimizer(graph, threads);
  optimizer.SetDamping(Damping::kDiagonal);
  SolveOptions options;
  options.max_iterations = 1;
  options.tau = 1e-13;
  optimizer.Solve(options);
}

// ---- rotations

using Row = VertexVector<3>;                       // x_ik, row k of R_i as a column
using Rows = std::array<std::shared_ptr<Row>, 3>;  // R_i

// r = x_jk − R_ijᵀ x_ik
class EdgeRow : public SizedEdge<3, Row, Row> {
 public:
  EdgeRow(std::shared_ptr<Row> i, std::shared_ptr<Row> j, const Mat33& R_i_j)
      : SizedEdge(std::move(i), std::move(j)), R_i_j_(R_i_j) {}
  void ComputeResidual() override {
    r_ = GetVertex<1>().GetEstimate() - R_i_j_.transpose() * GetVertex<0>().GetEstimate();
  }
  void ComputeJacobians() override {
    J<0>() = -R_i_j_.transpose();
    J<1>().setIdentity();
  }
  std::string TypeInfo() const override { return "EdgeRow"; }

 private:
  Mat33 R_i_j_;
};

// The nearest rotation by Frobenius' norm.
Mat33 ProjectToSO3(const Mat33& A) {
  const Eigen::JacobiSVD<Mat33> svd(A, Eigen::ComputeFullU | Eigen::ComputeFullV);
  const Mat33 UVt = svd.matrixU() * svd.matrixV().transpose();
  return svd.matrixU() * Vec3(1.0, 1.0, UVt.determinant()).asDiagonal() * svd.matrixV().transpose();
}

void PlaceRotations(const std::vector<bool>& is_held, Graph* graph, int threads) {
  Graph relaxed;
  std::vector<Rows> rows(is_held.size());
  for (const auto& vertex : graph->Vertices()) {
    const std::optional<Transform> pose = PoseOf(*vertex);
    if (!pose) continue;
    for (int k = 0; k < 3; ++k) {
      rows[vertex->Id()][k] = std::make_shared<Row>(pose->q.toRotationMatrix().row(k).transpose());
      rows[vertex->Id()][k]->SetFixed(is_held[vertex->Id()]);
      relaxed.AddVertex(rows[vertex->Id()][k]);
    }
  }
  for (const auto& edge : graph->Edges()) {
    const std::optional<Transform> T_i_j = MeasurementOf(*edge);
    if (!T_i_j) continue;
    const auto W = edge->Information();
    const double kappa = W.rows() == 6 ? W.diagonal().tail<3>().mean() : W(2, 2);
    for (int k = 0; k < 3; ++k) {
      const auto row = std::make_shared<EdgeRow>(rows[edge->Vertices()[0]->Id()][k], rows[edge->Vertices()[1]->Id()][k],
                                                 T_i_j->q.toRotationMatrix());
      row->SetIsotropicInformation(kappa);
      relaxed.AddEdge(row);
    }
  }
  SolveLinear(&relaxed, threads);
  for (const auto& vertex : graph->Vertices()) {
    const Rows& row = rows[vertex->Id()];
    if (!row[0] || is_held[vertex->Id()]) continue;
    Mat33 A;
    A << row[0]->GetEstimate().transpose(), row[1]->GetEstimate().transpose(), row[2]->GetEstimate().transpose();
    MoveTo({Qd(ProjectToSO3(A)), PoseOf(*vertex)->p}, vertex.get());
  }
}

// ---- positions

// How a measurement's residual changes as its poses are shifted by d_i and d_j:  r = r_0 + J_i d_i + J_j d_j, exactly.
// @tparam R  size of the residual, 6 in space and 3 in the plane;  D  of a position, 3 and 2
template <int R, int D>
class EdgeShift : public SizedEdge<R, VertexVector<D>, VertexVector<D>> {
 public:
  EdgeShift(std::shared_ptr<VertexVector<D>> i, std::shared_ptr<VertexVector<D>> j, Edge* edge)
      : SizedEdge<R, VertexVector<D>, VertexVector<D>>(std::move(i), std::move(j)) {
    edge->Linearize();
    r_0_ = edge->Residual();
    J_i_ = edge->Jacobian(0).template leftCols<D>();
    J_j_ = edge->Jacobian(1).template leftCols<D>();
    this->SetInformation(edge->Information());
  }
  void ComputeResidual() override {
    this->r_ =
        r_0_ + J_i_ * this->template GetVertex<0>().GetEstimate() + J_j_ * this->template GetVertex<1>().GetEstimate();
  }
  void ComputeJacobians() override {
    this->template J<0>() = J_i_;
    this->template J<1>() = J_j_;
  }
  std::string TypeInfo() const override { return "EdgeShift"; }

 private:
  Eigen::Matrix<double, R, 1> r_0_;
  Eigen::Matrix<double, R, D> J_i_, J_j_;
};

// Of the poses in space (R = 6, D = 3) or in the plane (3, 2).
template <int R, int D>
void PlacePositions(const std::vector<bool>& is_held, Graph* graph, int threads) {
  Graph linear;
  std::vector<std::shared_ptr<VertexVector<D>>> shifts(is_held.size());
  const auto shift_of = [&](const Vertex& vertex) {
    auto& shift = shifts[vertex.Id()];
    if (!shift) {
      shift = std::make_shared<VertexVector<D>>(Eigen::Matrix<double, D, 1>::Zero());
      shift->SetFixed(is_held[vertex.Id()]);
      linear.AddVertex(shift);
    }
    return shift;
  };
  for (const auto& edge : graph->Edges()) {
    if (!MeasurementOf(*edge) || edge->ResidualDimension() != R) continue;
    const auto i = shift_of(*edge->Vertices()[0]), j = shift_of(*edge->Vertices()[1]);
    linear.AddEdge(std::make_shared<EdgeShift<R, D>>(i, j, edge.get()));
  }
  SolveLinear(&linear, threads);
  for (const auto& vertex : graph->Vertices()) {  // both types of pose store their position first
    if (shifts[vertex->Id()]) vertex->Parameters().template head<D>() += shifts[vertex->Id()]->GetEstimate();
  }
}

}  // namespace

void PlaceByChordalRelaxation(Graph* graph, int threads) {
  if (graph->Vertices().empty()) return;
  PlaceAlongTree(TreeOrder::kBreadthFirst, graph);
  std::vector<bool> is_held(graph->Vertices().back()->Id() + 1, false);
  for (const auto& root : FindRoots(*graph)) is_held[root->Id()] = true;
  PlaceRotations(is_held, graph, threads);
  PlacePositions<6, 3>(is_held, graph, threads);
  PlacePositions<3, 2>(is_held, graph, threads);
}

}  // namespace ch5
