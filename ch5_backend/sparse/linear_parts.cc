#include "ch5_backend/sparse/linear_parts.h"

#include <algorithm>
#include <limits>

#include "ch5_backend/math/dense_kernels.h"

namespace ch5 {

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

namespace {

void Whiten(const double* F, int n, const RobustWeight& robust, const double* r, double* M, double* r_tilde) {
  double s = 0.0;
  for (int k = 0; k < n; ++k) {
    r_tilde[k] = 0.0;
    for (int c = 0; c < n; ++c) r_tilde[k] += F[k * n + c] * r[c];
    s += r_tilde[k] * r_tilde[k];
  }
  const double root = std::sqrt(robust.weight), shrink = Shrink(robust, s);
  for (int c = 0; c < n; ++c) {
    double g = 0.0;  // of (Fr)ᵀF
    for (int k = 0; k < n && shrink != 1.0; ++k) g += r_tilde[k] * F[k * n + c];
    const double bend = shrink == 1.0 ? 0.0 : (1.0 - shrink) / s * g;
    for (int k = 0; k < n; ++k) M[k * n + c] = root * (F[k * n + c] - bend * r_tilde[k]);
  }
  for (int k = 0; k < n; ++k) r_tilde[k] *= root / shrink;
}

}  // namespace

void WhitenFully(const Edge& edge, const double* F, double* M, double* r_tilde) {
  Whiten(F, edge.ResidualDimension(), edge.GetRobustWeight(), edge.Residual().data(), M, r_tilde);
}

void WhitenFully(const Edge& edge, const RobustWeight& robust, double* M, double* r_tilde) {
  const int n = edge.ResidualDimension();
  thread_local std::vector<double> F;
  F.resize(static_cast<size_t>(n * n));
  FactorPsd(edge.Information().data(), n, F.data());
  Whiten(F.data(), n, robust, edge.Residual().data(), M, r_tilde);
}

void InformationFactors::Prepare(const BlockStructure& structure, int first_edge) {
  first_edge_ = first_edge;
  entries_.assign(static_cast<size_t>(structure.num_active_edges - first_edge), {});
  size_t size = 0;
  for (int e = first_edge; e < structure.num_active_edges; ++e) {
    const EdgeRecord& record = structure.edges[e];
    if (record.edge->IsotropicInformation() >= 0.0) continue;
    entries_[e - first_edge].begin = static_cast<int>(size);
    const auto rows = static_cast<size_t>(record.edge->ResidualDimension());
    size += rows * rows;
  }
  values_.resize(size);
}

const double* InformationFactors::Of(const BlockStructure& structure, int e) {
  const Edge& edge = *structure.edges[e].edge;
  Entry& entry = entries_[e - first_edge_];
  const int n = edge.ResidualDimension();
  if (entry.begin < 0) {  // W was a multiple of the identity when the memory was taken
    thread_local std::vector<double> F;
    F.resize(static_cast<size_t>(n * n));
    FactorPsd(edge.Information().data(), n, F.data());
    return F.data();
  }
  double* F = values_.data() + entry.begin;
  if (entry.version != edge.InformationVersion()) FactorPsd(edge.Information().data(), n, F);
  entry.version = edge.InformationVersion();
  return F;
}

namespace {

// X = [J r]ᵀ (width + 1 rows, a column for each residual).
void Gather(const BlockStructure& structure, const EdgeRecord& record, double* X) {
  const int stride = record.width + 1, rows = record.edge->ResidualDimension();
  int column = 0;
  const auto append = [&](int position) {
    const Eigen::Map<const MatXX> J = record.edge->Jacobian(static_cast<size_t>(position));
    for (Eigen::Index c = 0; c < J.cols(); ++c, ++column) {
      for (int k = 0; k < rows; ++k) X[column + k * stride] = J(k, c);
    }
  };
  for (int t = record.terms_begin; t < record.terms_end; ++t) append(structure.terms[t].position);
  if (record.landmark_position >= 0) append(record.landmark_position);
  for (int k = 0; k < rows; ++k) X[record.width + k * stride] = record.edge->Residual()[k];
}

// Memory that each thread keeps, with room for what the dense kernels read behind it.
double* Scratch(size_t size) {
  thread_local AlignedVector memory;
  if (memory.size() < size + kernels::kOverread) memory.resize(size + kernels::kOverread);
  return memory.data();
}

}  // namespace

bool TakeProducts(Edge* edge, const std::vector<int>& columns, double* C) {
  size_t n = 1;
  for (const auto& vertex : edge->Vertices()) n += static_cast<size_t>(vertex->LocalDimension());
  double* own = Scratch(n * n);
  if (!edge->ProductsInto(own)) return false;
  // A run of successive numbers (a vertex) does not hold j again: it lies below own's diagonal, or above it.
  const auto size = columns.size();
  for (size_t c = 0; c < size; ++c) {
    const auto j = static_cast<size_t>(columns[c]);
    for (size_t r = c; r < size;) {
      const auto i = static_cast<size_t>(columns[r]);
      const size_t step = i >= j ? 1 : n;
      const double* from = own + (i >= j ? j * n + i : i * n + j);
      double* to = C + c * size;
      do {
        to[r++] = -*from;
        from += step;
      } while (r < size && columns[r] == columns[r - 1] + 1);
    }
  }
  return true;
}

void LinearizedProducts(const BlockStructure& structure, int e, InformationFactors* factors, double* C) {
  const EdgeRecord& record = structure.edges[e];
  thread_local std::vector<int> columns, begin;
  begin.assign(1, 0);
  for (const auto& vertex : record.edge->Vertices()) begin.push_back(begin.back() + vertex->LocalDimension());
  columns.clear();
  const auto list = [&](int position) {
    for (int c = begin[position]; c < begin[position + 1]; ++c) columns.push_back(c);
  };
  for (int t = record.terms_begin; t < record.terms_end; ++t) list(structure.terms[t].position);
  if (record.landmark_position >= 0) list(record.landmark_position);
  columns.push_back(begin.back());
  if (TakeProducts(record.edge, columns, C)) return;
  record.edge->Linearize();
  EdgeProducts(structure, e, factors, C);
}

void EdgeProducts(const BlockStructure& structure, int e, InformationFactors* factors, double* C) {
  const EdgeRecord& record = structure.edges[e];
  const Edge& edge = *record.edge;
  const int stride = record.width + 1, rows = edge.ResidualDimension();
  if (rows == 0) return void(std::fill_n(C, stride * stride, 0.0));
  const auto most = [&](int n) { return static_cast<size_t>(n) * static_cast<size_t>(structure.max_rows); };
  double* X = Scratch(2 * most(structure.max_width + 1) + most(structure.max_rows + 1));
  double* A = X + most(structure.max_width + 1);
  double* M = A + most(structure.max_width + 1);
  double* r_tilde = M + most(structure.max_rows);
  Gather(structure, record, X);
  const double scale = ScalarWhitening(edge);
  if (scale >= 0.0) {
    A = X;
    for (int i = 0; i < stride * rows && scale != 1.0; ++i) A[i] *= scale;
  } else {
    const double* F = factors->Of(structure, e);
    Eigen::Map<MatXX> M_columns(M, rows, rows);
    if (edge.GetLossFunction()) {
      WhitenFully(edge, F, M, r_tilde);
      M_columns.transposeInPlace();
    } else {  // M = F, also for the residual
      M_columns = Eigen::Map<const MatXX>(F, rows, rows).transpose();
    }
    kernels::SubtractProductABt(stride, rows, rows, X, stride, M, rows, A, stride, kernels::Old::kForget);  // −X Mᵀ
    for (int k = 0; k < rows && edge.GetLossFunction(); ++k) A[record.width + k * stride] = -r_tilde[k];
  }
  kernels::SubtractProductAAt(stride, rows, A, stride, C, stride, kernels::Old::kForget);
}

}  // namespace ch5
