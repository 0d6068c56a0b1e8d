#pragma once
/// When a pivot of a Cholesky (or LDLᵀ) factorization is rounding, and its matrix counts as singular.
///
/// The k-th pivot of an n×n matrix A = L Lᵀ is a_kk − Σ l_kj², j < k: all of its terms are at most a_kk, so that is what
/// its rounding error is measured by, entry by entry and whatever the units. The factorization is exact for a matrix
/// whose diagonal differs from A's by at most about n ε a_kk (Higham, "Accuracy and Stability of Numerical Algorithms",
/// 2nd ed., thm. 10.3). A itself is known no better: it is a sum of products, or a Schur complement, whose terms were as
/// large. A factor of 8 covers those sums. So of a pivot that a scale s (a_kk, or the diagonal from which a Schur
/// complement a_kk was computed) went into, what is at most 8 n ε s is zero.

#include <limits>

namespace ch5 {

/// 8 n ε: a pivot must exceed this part of its scale.
/// @param n  rows of the matrix that is factorized
constexpr double PivotRounding(int n) { return 8.0 * static_cast<double>(n) * std::numeric_limits<double>::epsilon(); }

}  // namespace ch5
