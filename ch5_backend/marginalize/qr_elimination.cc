#include "ch5_backend/marginalize/qr_elimination.h"

#include <Eigen/QR>
#include <limits>

#include "ch5_backend/graph/whitening.h"
#include "ch5_backend/marginalize/layout.h"

namespace ch5 {
namespace {

template <typename Scalar>
using Matrix = Eigen::Matrix<Scalar, Eigen::Dynamic, Eigen::Dynamic>;

int TotalRows(const std::vector<Layout::EdgeColumns>& edges) {
  int rows = 0;
  for (const Layout::EdgeColumns& edge : edges) rows += edge.edge->ResidualDimension();
  return rows;
}

// Rows [J̃ | r̃] of one edge, whitened:  J̃ = M J,  J̃ᵀr̃ = ρ'JᵀWr (graph/whitening.h).
// @param column_of  the column of an entry of Layout::columns
template <typename ColumnOf>
void WriteRows(const Layout& layout, const Layout::EdgeColumns& entry, const ColumnOf& column_of,
               Eigen::Ref<MatXX> rows) {
  Edge* edge = entry.edge;
  edge->Linearize();
  const int n = edge->ResidualDimension();
  Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor> M(n, n);
  VecX r(n);
  Whiten(*edge, edge->GetRobustWeight(), M.data(), r.data());
  rows.setZero();
  for (size_t i = 0; i < edge->Vertices().size(); ++i) {
    const int first = layout.ColumnsOf(entry)[i];
    if (first == Layout::kFixed) continue;
    rows.middleCols(column_of(first), edge->Vertices()[i]->LocalDimension()).noalias() = M * edge->Jacobian(i);
  }
  rows.rightCols<1>() = r;
}

// The rows of several edges, over `columns` columns, the residual's included.
template <typename ColumnOf>
MatXX StackRows(const Layout& layout, const std::vector<Layout::EdgeColumns>& edges, int columns,
                const ColumnOf& column_of) {
  MatXX rows(TotalRows(edges), columns);
  int next = 0;
  for (const Layout::EdgeColumns& entry : edges) {
    const int n = entry.edge->ResidualDimension();
    WriteRows(layout, entry, column_of, rows.middleRows(next, n));
    next += n;
  }
  return rows;
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
  tail.applyOnTheLeft(qr.householderQ().adjoint());
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
  const Layout layout = MakeLayout(edges, drop);
  const int kept = layout.kept_size, dropped = layout.size - kept;
  const auto dense_column = [&](int column) { return column < kept ? dropped + column : column - kept; };
  std::vector<Matrix<Scalar>> blocks;  // rows over [dropped | kept | r]
  blocks.push_back(StackRows(layout, layout.dense_edges, layout.size + 1, dense_column).template cast<Scalar>());
  for (size_t l = 0; l < layout.landmarks.size(); ++l) {
    const int dim = layout.landmarks[l]->LocalDimension();
    const auto column = [&](int c) { return c == Layout::kLandmark ? 0 : dim + dense_column(c); };
    const MatXX rows = StackRows(layout, layout.landmark_edges[l], dim + layout.size + 1, column);
    blocks.push_back(RowsBelow<Scalar>(rows.cast<Scalar>(), dim));
  }
  Matrix<Scalar> stack = StackAll(blocks, layout.size + 1);
  if (dropped > 0) stack = RowsBelow<Scalar>(stack, dropped);

  // One more QR makes the remaining rows triangular; r's part below the triangle is a constant of the cost.
  const Eigen::HouseholderQR<Matrix<Scalar>> qr(stack);
  const Eigen::Index n = std::min<Eigen::Index>(kept, stack.rows());
  const Matrix<Scalar> R = qr.matrixQR().topRows(n).template triangularView<Eigen::Upper>();
  Prior prior;
  prior.vertices = layout.kept;
  for (const auto& vertex : layout.kept) prior.x0.emplace_back(vertex->Parameters());
  prior.J = R.leftCols(kept).template cast<double>();
  prior.r0 = R.col(kept).template cast<double>();
  return prior;
}

template Prior MarginalizeQr<double>(const std::vector<std::shared_ptr<Edge>>&,
                                     const std::vector<std::shared_ptr<Vertex>>&);
template Prior MarginalizeQr<float>(const std::vector<std::shared_ptr<Edge>>&,
                                    const std::vector<std::shared_ptr<Vertex>>&);

}  // namespace ch5
