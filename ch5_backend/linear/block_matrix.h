#pragma once
/// A symmetric matrix of small blocks of which only the lower half of the non-zero ones is stored, column by column.
///
///      ┌────┐
///      │ 00 │ ·                 column 0: rows 0, 2;  column 1: row 1;  column 2: row 2
///      │    │ 11 │ ·            a column's first block is its diagonal one
///      │ 20 │    │ 22 │
///      └────┴────┴────┘
///
/// Each block is column-major with its own leading dimension, the number of rows rounded up to whole SIMD registers:
/// the inner loops then need no remainder, whatever the size. The padding rows are zero.

#include <vector>

#include "ch5_backend/linear/aligned_vector.h"
#include "ch5_backend/math/eigen_types.h"
#include "ch5_backend/math/lists.h"
#include "ch5_backend/math/simd.h"

namespace ch5 {

/// Leading dimension of a stored block with `dim` rows.
constexpr int Stride(int dim) { return Padded(dim); }

/// Copies the lower half of a diagonal block to the upper one.
CH5_INLINE void MirrorLower(int dim, double* block) {
  for (int c = 0; c < dim; ++c) {
    for (int r = c + 1; r < dim; ++r) block[r * Stride(dim) + c] = block[c * Stride(dim) + r];
  }
}

class SymmetricBlockMatrix {
 public:
  /// Builds the pattern; all values are zero.
  /// @param dims  size of each diagonal block
  /// @param rows_of_column  ascending block rows i ≥ j of each column j, the diagonal first
  void SetPattern(Array<int> dims, const Lists& rows_of_column);

  int NumColumns() const { return static_cast<int>(dims_.size()); }
  int Dim(int block) const { return At(dims_, block); }
  int Offset(int block) const { return At(offsets_, block); }  ///< first scalar row; Offset(NumColumns()) = Size()
  int Size() const { return offsets_.back(); }

  /// The stored blocks of column j are numbered [ColumnBegin(j), ColumnBegin(j + 1)).
  int ColumnBegin(int j) const { return At(column_begin_, j); }
  int Row(int block) const { return At(rows_, block); }
  double* Values(int block) { return values_.data() + At(value_begin_, block); }
  const double* Values(int block) const { return values_.data() + At(value_begin_, block); }
  /// Where a block's numbers begin in AllValues().
  int ValueBegin(int block) const { return At(value_begin_, block); }
  int NumValues() const { return static_cast<int>(values_.size()); }
  double* AllValues() { return values_.data(); }
  /// The end of the numbers of column j, whose blocks are stored consecutively.
  double* ColumnEnd(int j) {
    return j + 1 < NumColumns() ? Values(ColumnBegin(j + 1)) : values_.data() + values_.size();
  }
  int NumBlocks() const { return static_cast<int>(rows_.size()); }

  /// The number of block (i, j), i ≥ j, or −1 if it is not stored.
  int Find(int i, int j) const;

  /// y = A x.
  void Multiply(const double* x, double* y) const;
  ArrayVector Diagonal() const;
  /// Fills the lower half of `A`, Size()×Size(); the upper half is not written.
  void CopyLower(double* A) const;
  MatXX Dense() const;

 private:
  static int At(const Array<int>& numbers, int i) { return numbers[static_cast<size_t>(i)]; }

  Array<int> dims_;
  Array<int> offsets_{0};
  Array<int> column_begin_{0};
  Array<int> rows_;
  Array<int> value_begin_;
  AlignedVector values_;
};

}  // namespace ch5
