#include "ch5_backend/marginalize/qr_elimination.h"

#include <Eigen/QR>
#include <limits>

#include "ch5_backend/graph/whitening.h"
#include "ch5_backend/marginalize/drop_ordering.h"

namespace ch5 {
namespace {

template <typename Scalar>
using Matrix = Eigen::Matrix<Scalar, Eigen::Dynamic, Eigen::Dynamic>;
template <typename Scalar>
using Vector = Eigen::Matrix<Scalar, Eigen::Dynamic, 1>;

// Rows [J̃ | r̃] of edges, whitened:  J̃ = M J,  J̃ᵀr̃ = ρ'JᵀWr (graph/whitening.h).
// @param columns  the residual's included;  @param column_of  the column of a vertex's first row in H
template <typename ColumnOf>
MatXX StackRows(const std::vector<Edge*>& edges, int columns, const ColumnOf& column_of) {
  int next = 0;
  for (const Edge* edge : edges) next += edge->ResidualDimension();
  MatXX rows = MatXX::Zero(next, columns);
  next = 0;
  for (Edge* edge : edges) {
    edge->Linearize();
    const int n = edge->ResidualDimension();
    Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor> M(n, n);
    VecX r(n);
    Whiten(*edge, M.data(), r.data());
    for (size_t i = 0; i < edge->Vertices().size(); ++i) {
      const Vertex& vertex = *edge->Vertices()[i];
      if (vertex.OrderingId() < 0) continue;
      rows.block(next, column_of(vertex.OrderingId()), n, vertex.LocalDimension()).noalias() = M * edge->Jacobian(i);
    }
    rows.col(columns - 1).segment(next, n) = r;
    next += n;
  }
  return rows;
}

// Householder's reflections one by one: Eigen's blocks of them cost 20 s of compilation for three types of numbers.

// A ← Qᵀ A for the Q of a decomposition of as many rows.
template <typename Scalar>
void Reflect(const Eigen::ColPivHouseholderQR<Matrix<Scalar>>& qr, Matrix<Scalar>* A) {
  const Eigen::Index rows = A->rows();
  Vector<Scalar> workspace(A->cols());
  for (Eigen::Index k = 0; k < qr.hCoeffs().size(); ++k) {
    A->bottomRows(rows - k).applyHouseholderOnTheLeft(qr.matrixQR().col(k).tail(rows - k - 1), qr.hCoeffs()[k],
                                                      workspace.data());
  }
}

// A ← R of A = Q R; what is below the diagonal is of no use.
template <typename Scalar>
void MakeTriangular(Matrix<Scalar>* A) {
  const Eigen::Index rows = A->rows(), cols = A->cols();
  Vector<Scalar> workspace(cols);
  for (Eigen::Index k = 0; k < std::min(rows, cols); ++k) {
    Scalar tau, beta;
    A->col(k).tail(rows - k).makeHouseholderInPlace(tau, beta);
    (*A)(k, k) = beta;
    A->bottomRightCorner(rows - k, cols - k - 1)
        .applyHouseholderOnTheLeft(A->col(k).tail(rows - k - 1), tau, workspace.data());
  }
}

// A ← Qᵀ A for the Q that makes the first `columns` columns upper triangular; returns the rows below them.
template <typename Scalar>
Matrix<Scalar> RowsBelow(const Matrix<Scalar>& A, int columns) {
  const Eigen::Index drop = std::min<Eigen::Index>(columns, A.rows());
  // Columns of unit norm, whatever their units: their span, and so Q, stays the same.
  const auto norms = A.leftCols(columns).colwise().norm().array().max(std::numeric_limits<Scalar>::min());
  const Matrix<Scalar> head = A.leftCols(columns).array().rowwise() / norms.eval();
  Matrix<Scalar> tail = A.rightCols(A.cols() - columns);
  // Pivoting puts unobservable columns last: they are zero, and their rows must not be dropped.
  const Eigen::ColPivHouseholderQR<Matrix<Scalar>> qr(head);
  Reflect(qr, &tail);
  const Eigen::Index rank = std::min(drop, qr.rank());
  return tail.bottomRows(A.rows() - rank);
}

template <typename Scalar>
Matrix<Scalar> StackAll(const std::vector<Matrix<Scalar>>& blocks, Eigen::Index columns) {
  Eigen::Index rows = 0;
  for (const Matrix<Scalar>& block : blocks) rows += block.rows();
  Matrix<Scalar> stack(rows, columns);
  rows = 0;
  for (const Matrix<Scalar>& block : blocks) {
    stack.middleRows(rows, block.rows()) = block;
    rows += block.rows();
  }
  return stack;
}

}  // namespace

template <typename Scalar>
Prior MarginalizeQr(const std::vector<std::shared_ptr<Edge>>& edges, const std::vector<std::shared_ptr<Vertex>>& drop) {
  CheckMarginalization(edges, drop);
  const DropOrdering order = MakeDropOrdering(edges, drop);
  const std::vector<std::shared_ptr<Vertex>>&poses = order.ordering.poses, &landmarks = order.ordering.landmarks;
  const int size = order.ordering.dim_poses, kept = order.kept_size, dropped = size - kept;
  const Array<int> landmark_of = LandmarkOfEachEdge(order.ordering);
  std::vector<std::vector<Edge*>> edges_of(landmarks.size() + 1);  // each dropped landmark; the others come last
  for (size_t e = 0; e < edges.size(); ++e) {
    edges_of[landmark_of[e] < 0 ? landmarks.size() : static_cast<size_t>(landmark_of[e])].push_back(edges[e].get());
  }
  const auto dense_column = [&](int row) { return row < kept ? dropped + row : row - kept; };
  std::vector<Matrix<Scalar>> blocks;  // rows over [dropped | kept | r]
  blocks.push_back(StackRows(edges_of.back(), size + 1, dense_column).template cast<Scalar>());
  for (size_t l = 0; l < landmarks.size(); ++l) {
    const int dim = landmarks[l]->LocalDimension();
    const auto column = [&](int row) { return row >= size ? 0 : dim + dense_column(row); };
    blocks.push_back(RowsBelow<Scalar>(StackRows(edges_of[l], dim + size + 1, column).template cast<Scalar>(), dim));
  }
  Matrix<Scalar> stack = StackAll(blocks, size + 1);
  if (dropped > 0) stack = RowsBelow<Scalar>(stack, dropped);

  // One more QR makes the remaining rows triangular; r's part below the triangle is a constant of the cost.
  MakeTriangular(&stack);
  const Eigen::Index n = std::min<Eigen::Index>(kept, stack.rows());
  const Matrix<Scalar> R = stack.topRows(n).template triangularView<Eigen::Upper>();
  Prior prior;
  prior.vertices.assign(poses.begin(), poses.begin() + order.num_kept);
  for (const auto& vertex : prior.vertices) prior.x0.emplace_back(vertex->Parameters());
  prior.J = R.leftCols(kept).template cast<double>();
  prior.r0 = R.col(kept).template cast<double>();
  return prior;
}

template Prior MarginalizeQr<double>(const std::vector<std::shared_ptr<Edge>>&,
                                     const std::vector<std::shared_ptr<Vertex>>&);
template Prior MarginalizeQr<float>(const std::vector<std::shared_ptr<Edge>>&,
                                    const std::vector<std::shared_ptr<Vertex>>&);
template Prior MarginalizeQr<long double>(const std::vector<std::shared_ptr<Edge>>&,
                                          const std::vector<std::shared_ptr<Vertex>>&);

}  // namespace ch5
