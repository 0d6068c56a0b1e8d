#pragma once
/// Products of matrices with few rows, such as an edge's [J r]: row-major, each row padded with zeros to RowStride numbers.

namespace ch5::kernels {

/// From row to row of a matrix with so many columns: whole registers of any width.
constexpr int RowStride(int columns) { return (columns + 7) / 8 * 8; }

/// Y = M X;  M rows×rows and row-major without padding, X and Y rows×columns.
void MultiplyRows(int rows, int columns, const double* M, const double* X, double* Y);

/// The lower half of C = −XᵀY, columns×columns, column-major without padding; above the diagonal anything is left. Zeros of
/// X are skipped.
void NegativeProducts(int rows, int columns, const double* X, const double* Y, double* C);

}  // namespace ch5::kernels
