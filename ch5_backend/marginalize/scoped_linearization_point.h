#pragma once
/// Linearizes away from the present estimates: vertices take other states for the duration of a scope.

#include <utility>
#include <vector>

#include "ch5_backend/graph/vertex.h"

namespace ch5 {

/// Moves vertices; at the end of its scope they have their former states again, to the bit. Not thread-safe.
class ScopedLinearizationPoint {
 public:
  ScopedLinearizationPoint() = default;
  ~ScopedLinearizationPoint() {
    for (auto it = former_.rbegin(); it != former_.rend(); ++it) it->first->Parameters() = it->second;
  }
  ScopedLinearizationPoint(const ScopedLinearizationPoint&) = delete;
  ScopedLinearizationPoint& operator=(const ScopedLinearizationPoint&) = delete;

  void Move(Vertex* vertex, const VecX& x) {
    former_.emplace_back(vertex, vertex->Parameters());
    vertex->Parameters() = x;
  }

 private:
  std::vector<std::pair<Vertex*, VecX>> former_;
};

}  // namespace ch5
