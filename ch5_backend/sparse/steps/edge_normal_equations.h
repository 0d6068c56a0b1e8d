#pragma once
/// The normal equations of one edge:  C = −[J r]ᵀ [W_ρ J  ρ'W r]  with W_ρ of its loss (graph/loss.h), or W; laid out as in
/// structure.h, of which the lower half is meant; column-major without padding. They are negative because the dense kernels
/// of a prior subtract.

#include "ch5_backend/sparse/steps/structure.h"

namespace ch5 {

/// C of edge e at its last Linearize.
void MultiplyOut(const Structure& structure, int e, double* C);

/// C of edge e at the present states: linearizes the edge, or takes its own products (FastEdge::NegativeProductsInto).
void LinearizeAndMultiplyOut(const Structure& structure, int e, double* C);
/// The same for an edge by itself, with the columns of all of its vertices in its own order.
/// @param width  the sum of its vertices' LocalDimension()
void LinearizeAndMultiplyOut(Edge* edge, int width, double* C);

}  // namespace ch5
