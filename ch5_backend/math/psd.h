#pragma once
/// Symmetric positive semi-definite matrices: a test, and an inverse that allows for rank deficiency.

#include <string>

#include "ch5_backend/math/eigen_types.h"

namespace ch5 {

/// Empty if `A` is square, finite, symmetric and positive semi-definite to a relative tolerance of 1e-9; otherwise the
/// rest of a sentence that begins with "The matrix", naming the entry or the eigenvalue at fault.
std::string WhyNotPositiveSemiDefinite(const MatXX& A);

/// The positive semi-definite matrix nearest to a symmetric `A` (n×n) in Frobenius' norm: its negative eigenvalues become
/// zero.  Higham, "Computing a nearest symmetric positive semidefinite matrix", 1988
MatXX ProjectToPsd(const MatXX& A);

/// Moore-Penrose inverse of a symmetric positive semi-definite `A` (n×n): eigenvalues ≤ n·ε·λ_max count as zero.
MatXX PseudoInversePsd(const MatXX& A);

/// The same where the rank is known, as with a free gauge: the `nullity` smallest eigenvalues count as zero.
/// @throws std::invalid_argument if another eigenvalue is not positive
MatXX PseudoInversePsd(const MatXX& A, int nullity);

/// Σ⁻¹ of a covariance (n×n).  @param of  what has it, for the message
/// @throws std::invalid_argument that says why, unless it is symmetric positive definite
MatXX InverseOfCovariance(const MatXX& covariance, const std::string& of);

}  // namespace ch5
