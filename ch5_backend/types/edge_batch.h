#pragma once
/// Edges of one type side by side in memory: eight at a time are linearised in the lanes of SIMD registers, where single
/// edges would each wait for their own place in memory.
///
/// Numbers go in packs: number i of edge k of a pack lies at [kPack·i + k].

#include <unordered_map>
#include <vector>

#include "ch5_backend/math/simd.h"

namespace ch5 {

class Edge;

class EdgeBatch {
 public:
  virtual ~EdgeBatch() = default;
  virtual void Clear() = 0;
  /// Copies an edge's measurement and notes its vertices, behind the edges that are there.
  /// @param edge  of the type whose batch this is; its vertices must outlive the batch
  virtual void Add(const Edge& edge) = 0;

  /// Reads the poses' present states, with what all their edges need of them. Call it before the functions below.
  virtual void LoadPoses() = 0;
  /// r of edges [first, first + count), count ≤ kPack, as one pack; lanes without an edge hold copies of the last one.
  virtual void ComputeResiduals(int first, int count, double* r) const = 0;
  /// r, and J_0, J_1, … behind each other, each column-major: FastEdge::LinearizeInto for all edges of the pack.
  virtual void Linearize(int first, int count, double* r, double* J) const = 0;
};

/// Numbers vertices in the order in which they come.
template <typename V>
class VertexNumbers {
 public:
  void Clear() {
    vertices_.clear();
    number_.clear();
  }
  int Of(const V& vertex) {
    const auto [it, is_new] = number_.try_emplace(&vertex, static_cast<int>(vertices_.size()));
    if (is_new) vertices_.push_back(&vertex);
    return it->second;
  }
  const std::vector<const V*>& Vertices() const { return vertices_; }

 private:
  std::vector<const V*> vertices_;
  std::unordered_map<const V*, int> number_;
};

}  // namespace ch5
