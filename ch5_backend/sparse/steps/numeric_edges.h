#pragma once
/// Edges whose Jacobians are numeric, linearized by several threads.
///
/// Differentiating numerically moves an edge's vertices for a moment. So edges are colored: no two of a color have a
/// vertex in common, each color is one loop of the pool, and all of them come before the other edges are linearized.

#include "ch5_backend/math/parallel.h"
#include "ch5_backend/sparse/steps/structure.h"

namespace ch5 {

class NumericEdges {
 public:
  /// Marks these edges in the structure (EdgeRecord::is_numeric), from edge `first` on. One edge of each type tells whether
  /// the type brings its own Jacobians.
  void Find(int first, Structure* structure);
  /// Edge::Linearize of all of them at the present states.
  void Linearize(ThreadPool* pool) const;

 private:
  Array<Array<Edge*>> colors_;
};

}  // namespace ch5
