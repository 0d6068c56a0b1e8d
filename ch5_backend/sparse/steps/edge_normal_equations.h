#pragma once
/// The normal equations of one edge, whitened (graph/whitening.h):  C = −[J̃ r̃]ᵀ[J̃ r̃], laid out as in structure.h, of which
/// the lower half is meant; column-major without padding. They are negative because the dense kernels subtract.

#include "ch5_backend/graph/whitening.h"
#include "ch5_backend/sparse/steps/structure.h"

namespace ch5 {

/// The factor F of each edge's W = FᵀF, computed anew only where W has changed.
class InformationFactors {
 public:
  /// Takes memory for the edges from `first_edge` on whose W is not a multiple of the identity.
  void Prepare(const Structure& structure, int first_edge);
  /// F (n×n, row-major) of edge e. Safe to call for different edges at once.
  const double* Of(const Structure& structure, int e);

 private:
  struct Entry {
    int begin = -1, version = -1;
  };
  int first_edge_ = 0;
  std::vector<Entry> entries_;
  std::vector<double> values_;
};

/// C of edge e at its last Linearize.
void MultiplyOut(const Structure& structure, int e, InformationFactors* factors, double* C);

/// C of edge e at the present states: linearizes the edge, or takes its own products (FastEdge::NegativeProductsInto).
void LinearizeAndMultiplyOut(const Structure& structure, int e, InformationFactors* factors, double* C);

}  // namespace ch5
