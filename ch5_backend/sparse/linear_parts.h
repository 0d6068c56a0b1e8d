#pragma once
/// The normal equations of one edge, whitened (graph/whitening.h), and the factors of the edges' W that it takes.

#include "ch5_backend/graph/whitening.h"
#include "ch5_backend/sparse/block_structure.h"

namespace ch5 {

/// The factor F of the edges' W, made anew only where W has changed.
class InformationFactors {
 public:
  /// Takes memory for the edges from `first_edge` on whose W is not a multiple of the identity.
  void Prepare(const BlockStructure& structure, int first_edge);
  /// F (n×n, row-major) of edge e. Safe to call for different edges at once.
  const double* Of(const BlockStructure& structure, int e);

 private:
  struct Entry {
    int begin = -1, version = -1;
  };
  int first_edge_ = 0;
  std::vector<Entry> entries_;
  std::vector<double> values_;
};

/// The normal equations of edge e (see block_structure.h) at its last Linearize, negative: C = −[J̃ r̃]ᵀ[J̃ r̃], of
/// which the lower half is meant, column-major without padding.
void EdgeProducts(const BlockStructure& structure, int e, InformationFactors* factors, double* C);

/// Linearises edge e first, or asks it for its products where it has them (FastEdge::ProductsInto).
void LinearizedProducts(const BlockStructure& structure, int e, InformationFactors* factors, double* C);
}  // namespace ch5
