#pragma once
/// The order in which a sparse symmetric matrix is eliminated, and the dense submatrices ("fronts") that result.
///
/// Eliminating a variable connects all its neighbors with each other (fill-in). A good order keeps that small:
/// approximate minimum degree. The elimination tree: a variable's parent is the first of its neighbors that is later
/// in the order. Consecutive variables with (nearly) the same later neighbors are eliminated together, as one front:
///
///            pivots  below            pivots   the variables that this front eliminates
///          ┌────────┬───────┐         below    their later neighbors: all belong to ancestors
///   pivots │  L_11  │       │
///          ├────────┼───────┤         U goes to the parent's front, which holds all of its rows:
///   below  │  L_21  │   U   │         eliminating is marginalizing, and U is the message of a subtree.
///          └────────┴───────┘
///
/// Sources: Davis, "Direct Methods for Sparse Linear Systems", ch. 4 and 6; Duff & Reid, "The multifrontal solution of
/// indefinite sparse symmetric linear equations", 1983; Liu, "The multifrontal method", 1992.

#include <vector>

#include "ch5_backend/linear/block_matrix.h"

namespace ch5 {

/// One dense submatrix. Blocks are counted in elimination order.
struct Front {
  int first, last;   ///< eliminates blocks [first, last)
  Array<int> below;  ///< ascending blocks ≥ last
  int parent = -1;   ///< the front that eliminates below[0]; −1 for a root
  int pivots = 0;    ///< the sizes of both in numbers
  int rows_below = 0;
};

struct EliminationPlan {
  Array<int> order;                ///< block `order[k]` of the matrix is the k-th to be eliminated
  Array<int> position;             ///< its inverse
  Array<int> offset;               ///< first number of the k-th block in elimination order
  Array<Front> fronts;             ///< children before parents
  double num_factor_values = 0.0;  ///< numbers in L, the zeros that a front stores included
  double multiplications = 0.0;    ///< of the factorization; a dense one takes n³/6

  /// The size of the k-th block in elimination order.
  int Dim(int k) const {
    const auto first = offset.begin() + k;
    return first[1] - first[0];
  }
  /// The front that eliminates each block, in elimination order.
  Array<int> FrontOfEachBlock() const;
};

/// Plans for the pattern of A; its values do not matter.
EliminationPlan PlanElimination(const SymmetricBlockMatrix& A);
/// The same for a pattern without a matrix.
/// @param dims  the size of each block;  @param neighbors  of each, on both sides of the diagonal, without itself, each once
/// @param last  the blocks [0, last) are eliminated last
EliminationPlan PlanElimination(const Array<int>& dims, const Lists& neighbors, int last = 0);

/// The children of each node of a tree or of several, ascending; behind them the roots, whose parent is −1.
Lists ChildrenOf(const Array<int>& parent);

/// The plan that treats A as a dense matrix: one front of all blocks.
EliminationPlan PlanOneFront(const SymmetricBlockMatrix& A);

}  // namespace ch5
