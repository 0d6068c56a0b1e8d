#pragma once
/// Products, inverses and factors of matrices in memory, whatever Eigen calls them (compiled_products.h).

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
/// A, of which the lower triangle is read, becomes Q of A = Q T Qᵀ, T tridiagonal with these entries, by Householder's reflections.
/// @param beside  n − 1 numbers
void Tridiagonalize(const View<double>& A, double* diagonal, double* beside);
/// A is multiplied by the reflections I − h v vᵀ of the columns of V, whose diagonal counts as 1 and what is above it as 0: by the last
/// one first, or by the first.
void Reflect(const View<double>& A, const View<const double>& V, const double* h, bool last_first);
/// A becomes L and U of P A = L U, L with ones on its diagonal.  @param pivots  with which row each one changes places
/// @return  how many do
int Factor(const View<double>& A, int* pivots);

}  // namespace ch5::compiled
