#include "ch5_backend/linear/block_matrix.h"

#include <algorithm>

namespace ch5 {

void SymmetricBlockMatrix::SetPattern(std::vector<int> dims, const std::vector<std::vector<int>>& rows_of_column) {
  dims_ = std::move(dims);
  offsets_.assign(1, 0);
  for (const int dim : dims_) offsets_.push_back(offsets_.back() + dim);
  column_begin_.assign(1, 0);
  rows_.clear();
  value_begin_.clear();
  int size = 0;
  for (size_t j = 0; j < dims_.size(); ++j) {
    for (const int i : rows_of_column[j]) {
      rows_.push_back(i);
      value_begin_.push_back(size);
      size += Stride(dims_[i]) * dims_[j];
    }
    column_begin_.push_back(static_cast<int>(rows_.size()));
  }
  values_.assign(static_cast<size_t>(size), 0.0);
}

int SymmetricBlockMatrix::Find(int i, int j) const {
  const auto begin = rows_.begin() + column_begin_[j], end = rows_.begin() + column_begin_[j + 1];
  const auto it = std::lower_bound(begin, end, i);
  return it != end && *it == i ? static_cast<int>(it - rows_.begin()) : -1;
}

void SymmetricBlockMatrix::Multiply(const double* x, double* y) const {
  std::fill_n(y, Size(), 0.0);
  for (int j = 0; j < NumColumns(); ++j) {
    const double* x_j = x + offsets_[j];
    double* y_j = y + offsets_[j];
    for (int block = column_begin_[j]; block < column_begin_[j + 1]; ++block) {
      const int i = rows_[block], rows = dims_[i], stride = Stride(rows);
      const double* A = Values(block);
      const double* x_i = x + offsets_[i];
      double* y_i = y + offsets_[i];
      for (int c = 0; c < dims_[j]; ++c, A += stride) {
        double mirrored = 0.0;
        for (int r = 0; r < rows; ++r) {
          y_i[r] += A[r] * x_j[c];
          mirrored += A[r] * x_i[r];
        }
        if (i != j) y_j[c] += mirrored;
      }
    }
  }
}

VecX SymmetricBlockMatrix::Diagonal() const {
  VecX diagonal(Size());
  for (int j = 0; j < NumColumns(); ++j) {
    const double* A = Values(column_begin_[j]);
    for (int c = 0; c < dims_[j]; ++c) diagonal[offsets_[j] + c] = A[c * Stride(dims_[j]) + c];
  }
  return diagonal;
}

void SymmetricBlockMatrix::CopyLower(MatXX* A) const {
  const int size = Size();
  for (int j = 0; j < NumColumns(); ++j) {
    for (int c = 0; c < dims_[j]; ++c) {
      const int column = offsets_[j] + c;
      double* target = A->data() + static_cast<ptrdiff_t>(column) * size;
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
  CopyLower(&A);
  return A.selfadjointView<Eigen::Lower>();
}

}  // namespace ch5
