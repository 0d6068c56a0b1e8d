#pragma once
/// Linearises elsewhere: vertices stand at other estimates for a while, then where they were.

#include <utility>
#include <vector>

#include "ch5_backend/marginalize/edge_prior.h"

namespace ch5 {

/// Moves vertices for the duration of a scope; at its end they are back, to the bit.
class MovedVertices {
 public:
  MovedVertices() = default;
  /// To the prior's linearisation points; null: nowhere.
  explicit MovedVertices(const Prior* prior);
  ~MovedVertices();
  MovedVertices(const MovedVertices&) = delete;
  MovedVertices& operator=(const MovedVertices&) = delete;

  void Move(Vertex* vertex, const VecX& x);

 private:
  std::vector<std::pair<Vertex*, VecX>> before_;
};

}  // namespace ch5
