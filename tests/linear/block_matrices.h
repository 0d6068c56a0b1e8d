#pragma once
/// Symmetric block matrices for the tests of linear/: positive definite, in the patterns of real problems.

#include <cstdint>
#include <utility>
#include <vector>

#include "ch5_backend/linear/block_matrix.h"

namespace ch5::test {

/// Pairs (i, j), i > j, of blocks that are tied: that have a block in the matrix.
using Ties = std::vector<std::pair<int, int>>;

Ties Chain(int n);                                 ///< of n blocks, like a trajectory
Ties Grid(int side);                               ///< of side², like a map
Ties Everything(int n);                            ///< all pairs
Ties RandomTies(int n, int count, uint64_t seed);  ///< `count` random pairs, fewer where one comes twice

/// Random blocks of the given sizes where there are ties; diagonally dominant, so positive definite.
SymmetricBlockMatrix MakeMatrix(const std::vector<int>& dims, const Ties& ties, uint64_t seed);

/// Sizes 6, 3, 1, 9, 2, 6, 15, and again.
std::vector<int> MixedDims(int n);
/// Standard normal numbers.
VecX RandomVector(int n, uint64_t seed);
/// Matrices of all these patterns.
std::vector<SymmetricBlockMatrix> Matrices();

/// A⁻¹ b by Eigen.
VecX SolveByEigen(const SymmetricBlockMatrix& A, const VecX& b);

}  // namespace ch5::test
