#include "ch5_backend/marginalize/qr_elimination.h"

#include <Eigen/QR>
#include <limits>

#include "ch5_backend/graph/whitening.h"
#include "ch5_backend/marginalize/layout.h"

namespace ch5 {
namespace {

// Rows [J | r] of one edge over `columns` of the unknowns, whitened:  J̃ = M J,  J̃ᵀr̃ = ρ'JᵀWr (graph/whitening.h).
template <typename Column>
void WriteRows(const Layout& layout, const Layout::Row& row, const Column& column, Eigen::Ref<MatXX> rows) {
  Edge* edge = row.edge;
  edge->Linearize();
  const int n = edge->ResidualDimension();
  Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor> M(n, n);
  VecX r(n);
  Whiten(*edge, edge->GetRobustWeight(), M.data(), r.data());
  rows.setZero();
  for (size_t i = 0; i < edge->Vertices().size(); ++i) {
    const int first = layout.ColumnsOf(row)[i];
    if (first == Layout::kFixed) continue;
    rows.middleCols(column(first), edge->Vertices()[i]->LocalDimension()).noalias() = M * edge->Jacobian(i);
  }
  rows.rightCols<1>() = r;
}

int TotalRows(const std::vector<Layout::Row>& edges) {
  int rows = 0;
  for (const Layout::Row& row : edges) rows += row.edge->ResidualDimension();
  return rows;
}

// A ← Qᵀ A for the Q that makes the first `columns` columns upper triangular; returns the rows below them.
template <typename Scalar>
Eigen::Matrix<Scalar, Eigen::Dynamic, Eigen::Dynamic> RowsBelow(
    const Eigen::Matrix<Scalar, Eigen::Dynamic, Eigen::Dynamic>& A, int columns) {
  using Matrix = Eigen::Matrix<Scalar, Eigen::Dynamic, Eigen::Dynamic>;
  const Eigen::Index drop = std::min<Eigen::Index>(columns, A.rows());
  // Columns of unit norm, whatever their units: the span, and so Q, stays the same.
  const auto norms = A.leftCols(columns).colwise().norm().array().max(std::numeric_limits<Scalar>::min());
  const Matrix head = A.leftCols(columns).array().rowwise() / norms.eval();
  Matrix tail = A.rightCols(A.cols() - columns);
  // Pivoting puts what cannot be observed last: such columns are zero, and their rows are not to be dropped.
  const Eigen::ColPivHouseholderQR<Matrix> qr(head);
  tail.applyOnTheLeft(qr.householderQ().adjoint());
  const Eigen::Index rank = std::min(drop, qr.rank());
  return tail.bottomRows(A.rows() - rank);
}

}  // namespace

template <typename Scalar>
Prior MarginalizeQr(const std::vector<std::shared_ptr<Edge>>& edges, const std::vector<std::shared_ptr<Vertex>>& drop) {
  using Matrix = Eigen::Matrix<Scalar, Eigen::Dynamic, Eigen::Dynamic>;
  const Layout layout = MakeLayout(edges, drop);
  const int kept = layout.kept_size, dropped = layout.size - kept;
  std::vector<Matrix> pieces;  // rows over [dropped | kept | r]
  const auto dense_column = [&](int column) { return column < kept ? dropped + column : column - kept; };

  MatXX rows(TotalRows(layout.dense_edges), layout.size + 1);
  int next = 0;
  for (const Layout::Row& row : layout.dense_edges) {
    WriteRows(layout, row, dense_column, rows.middleRows(next, row.edge->ResidualDimension()));
    next += row.edge->ResidualDimension();
  }
  pieces.push_back(rows.cast<Scalar>());

  for (size_t l = 0; l < layout.landmarks.size(); ++l) {
    const int dim = layout.landmarks[l]->LocalDimension();
    const auto column = [&](int c) { return c == Layout::kLandmark ? 0 : dim + dense_column(c); };
    rows.resize(TotalRows(layout.landmark_edges[l]), dim + layout.size + 1);
    next = 0;
    for (const Layout::Row& row : layout.landmark_edges[l]) {
      WriteRows(layout, row, column, rows.middleRows(next, row.edge->ResidualDimension()));
      next += row.edge->ResidualDimension();
    }
    pieces.push_back(RowsBelow<Scalar>(rows.cast<Scalar>(), dim));
  }

  Eigen::Index total = 0;
  for (const Matrix& piece : pieces) total += piece.rows();
  Matrix stack(total, layout.size + 1);
  total = 0;
  for (const Matrix& piece : pieces) {
    stack.middleRows(total, piece.rows()) = piece;
    total += piece.rows();
  }
  if (dropped > 0) stack = RowsBelow<Scalar>(stack, dropped);

  // One more QR turns the tall rest into a triangle; r's part below it is a constant of the cost.
  const Eigen::HouseholderQR<Matrix> qr(stack);
  const Eigen::Index n = std::min<Eigen::Index>(kept, stack.rows());
  const Matrix R = qr.matrixQR().topRows(n).template triangularView<Eigen::Upper>();
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
