#include "ch5_backend/linear/sparse_cholesky.h"

#include <algorithm>
#include <atomic>

#include "ch5_backend/math/dense_kernels.h"
#include "ch5_backend/math/vector_kernels.h"

namespace ch5 {
// ---- Factorize -------------------------------------------------------------------------------------------------

// A = L Lᵀ, front by front, children first.  Liu (1992)
bool SparseCholesky::Factorize(const SymmetricBlockMatrix& A, const VecX& min_pivot) {
  for (size_t i = 0; i < permutation_.size(); ++i) min_pivot_[i] = min_pivot[permutation_[i]];
  std::atomic<bool> ok{true};
  ParallelFor(pool_, tasks_.size() - 1, 1, [&](int t, int) {
    for (const int f : tasks_[t]) {
      if (!ok.load(std::memory_order_relaxed)) return;
      if (!FactorFront(A, f, nullptr)) ok = false;
    }
  });
  for (const int f : tasks_[tasks_.size() - 1]) {
    if (!ok) return false;
    if (!FactorFront(A, f, pool_)) ok = false;
  }
  return ok;
}

bool SparseCholesky::FactorFront(const SymmetricBlockMatrix& A, int f, ThreadPool* pool) {
  const Front& front = plan_.fronts[f];
  const FrontMemory& place = places_[f];
  const int k = front.pivots, r = front.rows_below, m = k + r;
  double* columns = L_.data() + place.columns;

  std::fill_n(columns, static_cast<ptrdiff_t>(m) * k + kernels::kOverread, 0.0);
  CopyBlocks(A, place, m);
  for (const int child : children_[f]) AddToColumns(child, f);
  if (!kernels::Factor(k, columns, m, min_pivot_.data() + plan_.offset[front.first], pool)) return false;
  kernels::Eliminate(r, k, columns, columns + k, m, updates_.data() + place.update, r, kernels::Accumulate::kNo, pool);
  for (const int child : children_[f]) AddToUpdate(child, f);
  return true;
}

// The columns of a block, `Rows` a constant where it is not 0.
template <int Rows>
inline void CopyColumns(const double* block, int rows, int columns, double* target, ptrdiff_t m) {
  if constexpr (Rows > 0) rows = Rows;
  for (int j = 0; j < columns; ++j, block += Stride(rows), target += m) std::copy_n(block, rows, target);
}

// Copies the front's blocks of A into its columns of L, m numbers each.
void SparseCholesky::CopyBlocks(const SymmetricBlockMatrix& A, const FrontMemory& place, ptrdiff_t m) {
  for (int c = place.copies_begin; c < place.copies_end; ++c) {
    const Copy& copy = copies_[c];
    const double* block = A.Values(copy.block);
    double* target = L_.data() + copy.target;
    if (copy.transposed) {
      for (int j = 0; j < copy.dim_j; ++j, block += Stride(copy.dim_i)) {
        for (int i = 0; i < copy.dim_i; ++i) target[j + i * m] = block[i];
      }
    } else if (copy.dim_i == 6) {
      CopyColumns<6>(block, 6, copy.dim_j, target, m);
    } else if (copy.dim_i == 9) {
      CopyColumns<9>(block, 9, copy.dim_j, target, m);
    } else {
      CopyColumns<0>(block, copy.dim_i, copy.dim_j, target, m);
    }
  }
}

// Adds those columns of the child's U that are pivots here.
void SparseCholesky::AddToColumns(int child, int parent) {
  const Front& front = plan_.fronts[parent];
  const ptrdiff_t m = front.pivots + front.rows_below;
  double* columns = L_.data() + places_[parent].columns;
  AddRuns(child, places_[child].runs_begin, places_[child].runs_below, columns, m, 0);
}

// Adds the other columns to this front's own U, whose first row is row k of the front.
void SparseCholesky::AddToUpdate(int child, int parent) {
  const ptrdiff_t k = plan_.fronts[parent].pivots, r = plan_.fronts[parent].rows_below;
  double* U = updates_.data() + places_[parent].update;
  AddRuns(child, places_[child].runs_below, places_[child].runs_end, U, r, k);
}

// Columns [begin, end) of the runs, with all rows from the diagonal on; (first, first) goes to target[0].
void SparseCholesky::AddRuns(int child, int begin, int end, double* target, ptrdiff_t ld, ptrdiff_t first) {
  const ptrdiff_t r = plan_.fronts[child].rows_below;
  const double* U = updates_.data() + places_[child].update;
  const RowRun* last = runs_.data() + places_[child].runs_end;
  for (const RowRun* run = runs_.data() + begin; run != runs_.data() + end; ++run) {
    for (int c = 0; c < run->length; ++c) {
      const double* from = U + (run->from + c) * r;
      double* to = target + (run->to + c - first) * ld;
      Add(from + run->from + c, run->length - c, to + run->to + c - first);
      for (const RowRun* other = run + 1; other != last; ++other) {
        Add(from + other->from, other->length, to + other->to - first);
      }
    }
  }
}

// ---- Solve -----------------------------------------------------------------------------------------------------

void SparseCholesky::Solve(const VecX& b, VecX* x) {
  const int n = static_cast<int>(permutation_.size());
  for (int i = 0; i < n; ++i) x_[i] = b[permutation_[i]];
  auto y = VecX::Map(x_.data(), n), gathered = VecX::Map(gathered_.data(), static_cast<Eigen::Index>(gathered_.size()));

  // Calls use(number in x_, number in gathered_, length) for each block below a front.
  const auto for_rows_below = [&](const Front& front, auto use) {
    int row = 0;
    for (const int block : front.below) {
      const int length = plan_.Dim(block);
      use(plan_.offset[block], row, length);
      row += length;
    }
  };
  for (size_t f = 0; f < places_.size(); ++f) {  // L y = b
    const Front& front = plan_.fronts[f];
    const int k = front.pivots, r = front.rows_below;
    const double* L_11 = L_.data() + places_[f].columns;
    double* x_k = x_.data() + plan_.offset[front.first];
    kernels::SolveLower(k, L_11, k + r, x_k);
    gathered.head(r).setZero();
    kernels::SubtractProductAx(r, k, L_11 + k, k + r, x_k, gathered_.data());
    for_rows_below(front, [&](int i, int row, int length) { y.segment(i, length) += gathered.segment(row, length); });
  }
  for (int f = static_cast<int>(places_.size()) - 1; f >= 0; --f) {  // Lᵀ x = y
    const Front& front = plan_.fronts[f];
    const int k = front.pivots, r = front.rows_below;
    const double* L_11 = L_.data() + places_[f].columns;
    double* x_k = x_.data() + plan_.offset[front.first];
    for_rows_below(front, [&](int i, int row, int length) { gathered.segment(row, length) = y.segment(i, length); });
    kernels::SubtractProductAtx(r, k, L_11 + k, k + r, gathered_.data(), x_k);
    kernels::SolveLowerTranspose(k, L_11, k + r, x_k);
  }
  x->resize(n);
  for (int i = 0; i < n; ++i) (*x)[permutation_[i]] = x_[i];
}

}  // namespace ch5
