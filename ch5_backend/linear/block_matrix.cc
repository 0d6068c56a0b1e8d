#include "ch5_backend/linear/block_matrix.h"

#include <algorithm>

#include "ch5_backend/math/dispatch.h"

namespace ch5 {
namespace {

// y += A x over vectors whose blocks are padded like A's, each at padded_offset[block].
struct MultiplyPadded {
  using Signature = void(const SymmetricBlockMatrix&, const int* padded_offset, const double* x, double* y);
  template <SimdLevel>
  static CH5_INLINE void Run(const SymmetricBlockMatrix& A, const int* padded_offset, const double* x, double* y) {
    for (int j = 0; j < A.NumColumns(); ++j) {
      const double* x_j = x + padded_offset[j];
      const int diagonal = A.ColumnBegin(j), end = A.ColumnBegin(j + 1), stride_j = Stride(A.Dim(j));
      for (int c = 0; c < A.Dim(j); ++c) {
        const double* column = A.Values(diagonal) + c * stride_j;
        double* y_j = y + padded_offset[j];
        for (int r = 0; r < stride_j; r += kLanes) *AsLanes(y_j + r) += *AsLanes(column + r) * x_j[c];
        Lanes mirrored = {};
        for (int block = diagonal + 1; block < end; ++block) {
          const int i = A.Row(block), stride = Stride(A.Dim(i));
          column = A.Values(block) + c * stride;
          const double* x_i = x + padded_offset[i];
          double* y_i = y + padded_offset[i];
          for (int r = 0; r < stride; r += kLanes) {
            *AsLanes(y_i + r) += *AsLanes(column + r) * x_j[c];
            mirrored += *AsLanes(column + r) * *AsLanes(x_i + r);
          }
        }
        y_j[c] += (mirrored[0] + mirrored[1]) + (mirrored[2] + mirrored[3]);
      }
    }
  }
};

}  // namespace

void SymmetricBlockMatrix::SetPattern(Array<int> dims, const Lists& rows_of_column) {
  dims_ = std::move(dims);
  offsets_.assign(1, 0);
  offsets_.reserve(dims_.size() + 1);
  for (const int dim : dims_) offsets_.push_back(offsets_.back() + dim);
  column_begin_ = rows_of_column.begin;
  rows_ = rows_of_column.items;
  value_begin_.clear();
  value_begin_.reserve(rows_.size());
  int size = 0;
  for (int j = 0; j < NumColumns(); ++j) {
    for (const int i : rows_of_column[j]) {
      value_begin_.push_back(size);
      size += Stride(dims_[i]) * dims_[j];
    }
  }
  SetZeros(static_cast<size_t>(size), &values_);
}

int SymmetricBlockMatrix::Find(int i, int j) const {
  const auto begin = rows_.begin() + column_begin_[j], end = rows_.begin() + column_begin_[j + 1];
  if (i >= j && i - j < end - begin && begin[i - j] == i) return column_begin_[j] + i - j;  // as in a dense column
  const auto it = std::lower_bound(begin, end, i);
  return it != end && *it == i ? static_cast<int>(it - rows_.begin()) : -1;
}

void SymmetricBlockMatrix::Multiply(const double* x, double* y) const {
  thread_local Array<int> padded_offset;
  thread_local AlignedVector padded;
  padded_offset.assign(1, 0);
  for (const int dim : dims_) padded_offset.push_back(padded_offset.back() + Stride(dim));
  SetZeros(2 * static_cast<size_t>(padded_offset.back()), &padded);
  double *x_padded = padded.data(), *y_padded = x_padded + padded_offset.back();
  for (int j = 0; j < NumColumns(); ++j) std::copy_n(x + offsets_[j], dims_[j], x_padded + padded_offset[j]);
  Dispatch<MultiplyPadded>()(*this, padded_offset.data(), x_padded, y_padded);
  for (int j = 0; j < NumColumns(); ++j) std::copy_n(y_padded + padded_offset[j], dims_[j], y + offsets_[j]);
}

ArrayVector SymmetricBlockMatrix::Diagonal() const {
  ArrayVector diagonal(Size());
  for (int j = 0; j < NumColumns(); ++j) {
    const double* A = Values(column_begin_[j]);
    for (int c = 0; c < dims_[j]; ++c) diagonal[offsets_[j] + c] = A[c * Stride(dims_[j]) + c];
  }
  return diagonal;
}

void SymmetricBlockMatrix::CopyLower(double* A) const {
  const int size = Size();
  for (int j = 0; j < NumColumns(); ++j) {
    for (int c = 0; c < dims_[j]; ++c) {
      const int column = offsets_[j] + c;
      double* target = A + static_cast<ptrdiff_t>(column) * size;
      std::fill(target + column, target + size, 0.0);
      for (int block = column_begin_[j]; block < column_begin_[j + 1]; ++block) {
        const int i = rows_[block];
        std::copy_n(Values(block) + c * Stride(dims_[i]), dims_[i], target + offsets_[i]);
      }
    }
  }
}

MatXX SymmetricBlockMatrix::Dense() const {
  MatXX A = MatXX::Zero(Size(), Size());
  CopyLower(A.data());
  return A.selfadjointView<Eigen::Lower>();
}

}  // namespace ch5
