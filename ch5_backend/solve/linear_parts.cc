#include "ch5_backend/solve/linear_parts.h"

#include <algorithm>
#include <limits>

namespace ch5 {
namespace {

// A (rows×dim, each row padded to Stride(dim)) = M J,  J column-major.
void MultiplyJacobian(const double* M, const double* J, int rows, int dim, double* A) {
  for (int r = 0; r < rows; ++r, A += Stride(dim)) {
    for (int c = 0; c < dim; ++c) {
      double sum = 0.0;
      for (int k = 0; k < rows; ++k) sum += M[r * rows + k] * J[c * rows + k];
      A[c] = sum;
    }
  }
}

// The same for M = scale·I.
void ScaleJacobian(double scale, const double* J, int rows, int dim, double* A) {
  for (int r = 0; r < rows; ++r, A += Stride(dim)) {
    for (int c = 0; c < dim; ++c) A[c] = scale * J[c * rows + r];
  }
}

}  // namespace

void FactorPsd(const double* W, int n, double* F) {
  thread_local std::vector<double> rest;
  rest.assign(W, W + n * n);
  std::fill_n(F, n * n, 0.0);
  double largest = 0.0;
  for (int i = 0; i < n; ++i) largest = std::max(largest, W[i * n + i]);
  const double rounding = n * std::numeric_limits<double>::epsilon() * largest;
  for (int k = 0; k < n; ++k) {
    int pivot = 0;
    for (int i = 1; i < n; ++i) {
      if (rest[i * n + i] > rest[pivot * n + pivot]) pivot = i;
    }
    if (!(rest[pivot * n + pivot] > rounding)) return;
    double* row = F + k * n;
    const double root = std::sqrt(rest[pivot * n + pivot]);
    for (int i = 0; i < n; ++i) row[i] = rest[pivot * n + i] / root;
    for (int j = 0; j < n; ++j) {
      for (int i = 0; i < n; ++i) rest[j * n + i] -= row[i] * row[j];
    }
    for (int i = 0; i < n; ++i) rest[pivot * n + i] = rest[i * n + pivot] = 0.0;
  }
}

void WhitenFully(const Edge& edge, const RobustWeight& robust, double* M, double* r_tilde) {
  const int n = edge.ResidualDimension();
  FactorPsd(edge.Information().data(), n, M);
  const double* r = edge.Residual().data();
  double s = 0.0;
  for (int k = 0; k < n; ++k) {
    r_tilde[k] = 0.0;
    for (int c = 0; c < n; ++c) r_tilde[k] += M[k * n + c] * r[c];
    s += r_tilde[k] * r_tilde[k];
  }
  const double root = std::sqrt(robust.weight);
  const bool bends = robust.rank_one != 0.0 && s > 0.0;
  const double shrink = bends ? std::sqrt(1.0 + robust.rank_one * s / robust.weight) : 1.0;  // 1 − α
  for (int c = 0; c < n && bends; ++c) {
    double g = 0.0;  // of (Fr)ᵀF
    for (int k = 0; k < n; ++k) g += r_tilde[k] * M[k * n + c];
    for (int k = 0; k < n; ++k) M[k * n + c] -= (1.0 - shrink) / s * r_tilde[k] * g;
  }
  for (int i = 0; i < n * n; ++i) M[i] *= root;
  for (int k = 0; k < n; ++k) r_tilde[k] *= root / shrink;
}

void WriteLinearParts(const BlockStructure& structure, const EdgeRecord& record, double* linear) {
  const Edge& edge = *record.edge;
  const int rows = record.rows;
  const double scale = ScalarWhitening(edge);
  thread_local std::vector<double> M;
  if (scale >= 0.0) {
    for (int k = 0; k < rows; ++k) linear[record.residual + k] = scale * edge.Residual()[k];
  } else {
    M.resize(static_cast<size_t>(rows * rows));
    WhitenFully(edge, edge.GetRobustWeight(), M.data(), linear + record.residual);
  }
  const auto write = [&](const EdgeTerm& term) {
    const auto J = edge.Jacobian(static_cast<size_t>(term.position));
    const int dim = static_cast<int>(J.cols());
    double* A = linear + term.jacobian;
    scale >= 0.0 ? ScaleJacobian(scale, J.data(), rows, dim, A) : MultiplyJacobian(M.data(), J.data(), rows, dim, A);
  };
  for (int t = record.terms_begin; t < record.terms_end; ++t) write(structure.terms[t]);
  if (record.landmark.block >= 0) write(record.landmark);
}

}  // namespace ch5
