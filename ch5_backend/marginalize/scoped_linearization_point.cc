#include "ch5_backend/marginalize/scoped_linearization_point.h"

namespace ch5 {

ScopedLinearizationPoint::~ScopedLinearizationPoint() {
  for (auto it = former_.rbegin(); it != former_.rend(); ++it) it->first->Parameters() = it->second;
}

void ScopedLinearizationPoint::Move(Vertex* vertex, const VecX& x) {
  former_.emplace_back(vertex, vertex->Parameters());
  vertex->Parameters() = x;
}

}  // namespace ch5
