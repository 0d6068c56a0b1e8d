#pragma once
/// A matrix as rows of a table: labels, row, column, value.

#include <string>

#include "ch5_backend/math/eigen_types.h"
#include "ch5_backend/world/files/csv.h"

namespace ch5 {

/// Appends the entries of M that are not zero, `labels…,row,column,value`.
template <typename... Labels>
void AppendNonZeros(const MatXX& M, CsvTable* table, const Labels&... labels) {
  for (int row = 0; row < M.rows(); ++row) {
    for (int column = 0; column < M.cols(); ++column) {
      if (M(row, column) != 0.0) table->Row(labels..., row, column, M(row, column));
    }
  }
}

}  // namespace ch5
