#pragma once
/// Marginalization without forming H: orthogonal transformations of the whitened Jacobians.
///
///   rows of one landmark          all rows that are left              what remains
///   [ J_l │ J_p │ r ]   ──QR──►   [ J_d │ J_k │ r ]   ──QR──►   [ R_k │ r₀ ],   H = R_kᵀR_k,  b = −R_kᵀr₀
///   the first rows, which hold the landmark, are dropped; the rows in the null space of J_lᵀ are kept
///
/// The condition number is that of J and not its square, so that rounding takes half as many digits of a weak prior as
/// in the Schur complement. Single precision still has less than Schur's double.
/// Source: Demmel et al., ICCV 2021 (arXiv 2109.02182); Golub & Van Loan, §5.2.

#include "ch5_backend/marginalize/edge_prior.h"

namespace ch5 {

/// The same prior as Marginalize, by QR in the given precision; J is upper triangular, n×n.
/// @tparam Scalar  float, double or, to compare them with, long double (64 bits of mantissa on x86): all arithmetic after the
///                 linearization
/// @throws std::invalid_argument as Marginalize
template <typename Scalar>
Prior MarginalizeQr(const std::vector<std::shared_ptr<Edge>>& edges, const std::vector<std::shared_ptr<Vertex>>& drop);

}  // namespace ch5
