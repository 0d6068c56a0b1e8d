#include "ch5_backend/math/quick_matrix.h"

#include <algorithm>

#include "ch5_backend/math/dense_kernels.h"

namespace ch5 {
namespace {

// C += A, C with R rows in column-major memory.
template <int R>
void AddColumns(double* __restrict C, Eigen::Index ldc, const double* __restrict A, Eigen::Index columns) {
  for (Eigen::Index j = 0; j < columns; ++j, C += ldc, A += R) {
    for (int i = 0; i < R; ++i) C[i] += A[i];
  }
}

}  // namespace

void QuickMatrix::Block::Add(const double* A, Eigen::Index row_step, Eigen::Index column_step) {
  double* C = data();
  const Eigen::Index m = rows(), n = cols(), ldc = outerStride();
  if (row_step == 1 && m == 6) return AddColumns<6>(C, ldc, A, n);  // a pose's rows
  if (row_step == 1 && m == 1) return AddColumns<1>(C, ldc, A, n);  // an inverse depth's
  for (Eigen::Index j = 0; j < n; ++j) {
    for (Eigen::Index i = 0; i < m; ++i) C[j * ldc + i] += A[i * row_step + j * column_step];
  }
}

MatXX Multiply(const Eigen::Ref<const MatXX>& A, const Eigen::Ref<const MatXX>& B) {
  constexpr int kDepth = 64;  // columns of A at a time: their copy stays in the cache
  const int m = static_cast<int>(A.rows()), k = static_cast<int>(A.cols()), n = static_cast<int>(B.cols());
  MatXX C = MatXX::Zero(m, n);
  if (C.size() == 0) return C;
  // The kernel computes C −= A (−Bᵀ)ᵀ and reads a little behind its arguments.
  VecX A_part(m * kDepth + kernels::kOverread), B_part(n * kDepth + kernels::kOverread);
  for (int first = 0; first < k; first += kDepth) {
    const int depth = std::min(kDepth, k - first);
    Eigen::Map<MatXX>(A_part.data(), m, depth) = A.middleCols(first, depth);
    Eigen::Map<MatXX>(B_part.data(), n, depth) = -B.middleRows(first, depth).transpose();
    kernels::SubtractProductABt(m, n, depth, A_part.data(), m, B_part.data(), n, C.data(), m);
  }
  return C;
}

}  // namespace ch5
