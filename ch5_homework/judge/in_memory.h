#pragma once
/// Products and inverses of matrices in memory, whatever Eigen calls them (compiled_products.h).

#include <cstddef>

namespace ch5::compiled {

/// A matrix: how far its rows lie apart, and its columns.
template <typename Number>
struct View {
  Number* data;
  std::ptrdiff_t rows, columns, to_next_row, to_next_column;

  Number& operator()(std::ptrdiff_t i, std::ptrdiff_t j) const { return data[i * to_next_row + j * to_next_column]; }
};

/// C = factor A B, or C += factor A B.
void Multiply(double factor, const View<const double>& A, const View<const double>& B, bool adds,
              const View<double>& C);
/// The inverse (n×n) of an n×n matrix, which is lost, by Gauss-Jordan elimination with partial pivoting.
void Invert(const View<double>& A, const View<double>& inverse);

}  // namespace ch5::compiled
