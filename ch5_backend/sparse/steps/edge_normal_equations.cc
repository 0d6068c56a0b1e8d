#include "ch5_backend/sparse/steps/edge_normal_equations.h"

#include <algorithm>

#include "ch5_backend/graph/fast_edge.h"
#include "ch5_backend/math/dense_kernels.h"

namespace ch5 {

void InformationFactors::Prepare(const Structure& structure, int first_edge) {
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

const double* InformationFactors::Of(const Structure& structure, int e) {
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
void Gather(const Structure& structure, const EdgeRecord& record, double* X) {
  const int stride = record.width + 1, rows = record.edge->ResidualDimension();
  int column = 0;
  const auto append = [&](int position) {
    const Eigen::Map<const MatXX> J = record.edge->Jacobian(static_cast<size_t>(position));
    for (Eigen::Index c = 0; c < J.cols(); ++c, ++column) {
      for (int k = 0; k < rows; ++k) X[column + k * stride] = J(k, c);
    }
  };
  if (record.landmark_position < 0) {
    for (int i = 0; i < static_cast<int>(record.edge->Vertices().size()); ++i) append(i);
  } else {
    for (int t = record.poses_begin; t < record.poses_end; ++t) append(structure.edge_poses[t].position);
    append(record.landmark_position);
  }
  for (int k = 0; k < rows; ++k) X[record.width + k * stride] = record.edge->Residual()[k];
}

// Memory that each thread keeps, with room for what the dense kernels read behind it.
double* Scratch(size_t size) {
  thread_local AlignedVector memory;
  if (memory.size() < size + kernels::kOverread) memory.resize(size + kernels::kOverread);
  return memory.data();
}

}  // namespace

void LinearizeAndMultiplyOut(const Structure& structure, int e, InformationFactors* factors, double* C) {
  const EdgeRecord& record = structure.edges[e];
  FastEdge* fast = AsFast(record.edge);
  if (fast && fast->NegativeProductsInto(C)) return;
  if (!record.is_numeric) record.edge->Linearize();
  MultiplyOut(structure, e, factors, C);
}

void MultiplyOut(const Structure& structure, int e, InformationFactors* factors, double* C) {
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
      Whiten(edge, F, M, r_tilde);
      M_columns.transposeInPlace();
    } else {  // M = F, also for the residual
      M_columns = Eigen::Map<const MatXX>(F, rows, rows).transpose();
    }
    kernels::SubtractProductABt(stride, rows, rows, X, stride, M, rows, A, stride, kernels::Accumulate::kNo);  // −X Mᵀ
    for (int k = 0; k < rows && edge.GetLossFunction(); ++k) A[record.width + k * stride] = -r_tilde[k];
  }
  kernels::SubtractProductAAt(stride, rows, A, stride, C, stride, kernels::Accumulate::kNo);
}

}  // namespace ch5
