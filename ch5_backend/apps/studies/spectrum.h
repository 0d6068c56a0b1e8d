#pragma once
/// Eigenvalues, and how many of them a free gauge makes zero.

#include "ch5_backend/math/eigen_types.h"

namespace ch5 {

/// Ascending eigenvalues of a symmetric H (n×n).
VecX Eigenvalues(const MatXX& H);

/// How many eigenvalues are zero next to the largest one: ≤ `relative`·λ_max. H is scaled to a unit diagonal first,
/// so that metres, radians and inverse metres can be compared; scaling keeps the rank.
int NullDimension(const MatXX& H, double relative = 1e-10);

}  // namespace ch5
