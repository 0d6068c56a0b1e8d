#pragma once
/// What an edge may offer beside Edge's functions, for the sparse solver and for marginalization. All of it is optional:
/// an edge without it is linearized by Edge's own functions, to the same numbers.
///
///   class EdgeReprojection : public SizedEdge<2, …>, public FastEdge { … };

#include <memory>

#include "ch5_backend/graph/edge.h"
#include "ch5_backend/math/key_numbers.h"
#include "ch5_backend/math/simd.h"

namespace ch5 {

/// A of one vertex of an edge that sees its poses only through T_ji, that of i in j. With ξ = [δt; φ] moving it to
/// (Exp(φ) R_ji, p_ji + δt):  ξ = A [δp; δθ],  J = J_ξ A.  Row-major, kPack numbers a row; the lower left 3×3 is zero.
struct alignas(64) RelativeJacobian {
  static constexpr int kDim = 6;
  double row[kDim][kPack];
};

/// Edges of one type side by side in memory: eight at a time are linearized in the lanes of SIMD registers, where single
/// edges would each wait for their own place in memory. Numbers go in packs: number i of edge k of a pack lies at
/// [kPack·i + k].
class EdgeBatch {
 public:
  virtual ~EdgeBatch() = default;
  virtual void Clear() = 0;
  /// Makes room for so many edges in all.
  virtual void Reserve(size_t count) = 0;
  /// Copies an edge's measurement and notes its vertices, behind the edges that are there.
  /// @param edge  of the type whose batch this is; its vertices must outlive the batch
  virtual void Add(const Edge& edge) = 0;

  /// Reads the poses' present states, with what all their edges need of them. Call it before the functions below.
  virtual void LoadPoses() = 0;
  /// r of edges [first, first + count), count ≤ kPack, as one pack; lanes without an edge hold copies of the last one.
  virtual void ComputeResiduals(int first, int count, double* r) const = 0;
  /// r, and J_0, J_1, … behind each other, each column-major. If IsRelative, only those of vertex 0, the landmark, and J_ξ.
  virtual void Linearize(int first, int count, double* r, double* J) const = 0;

  /// Whether J_v = J_ξ A_v for all poses v of an edge.
  virtual bool IsRelative() const { return false; }
  /// If so: for each vertex of edge `first` its A, which is left as it is where the vertex is no pose.
  /// @return how many edges from `first` on, at most `count`, have the same
  virtual int RelativeJacobians(int /*first*/, int /*count*/, RelativeJacobian* /*A*/) const { return 0; }
};

class FastEdge {
 public:
  virtual ~FastEdge() = default;

  /// An empty batch for edges of this type, or null if there is none.
  virtual std::unique_ptr<EdgeBatch> MakeBatch() const { return nullptr; }
  /// For an edge that gets JᵀWJ more cheaply than from J: the lower half of C = −[J r]ᵀW[J r] at the present state (negative
  /// because the dense kernels subtract), over the columns of all its vertices in their order, (n + 1)×(n + 1),
  /// column-major; above the diagonal anything is left. r is left computed, J is not.
  /// @return false if the type does not offer it, or if W or a loss would make it another matrix
  virtual bool NegativeProductsInto(double* /*C*/) { return false; }
};

/// The edge's fast side, or null if it has none.
inline FastEdge* AsFast(Edge* edge) { return dynamic_cast<FastEdge*>(edge); }
inline const FastEdge* AsFast(const Edge& edge) { return dynamic_cast<const FastEdge*>(&edge); }

/// Numbers vertices in the order in which they come.
template <typename V>
class VertexNumbers {
 public:
  void Clear() { numbers_.Clear(); }
  int Of(const V& vertex) { return numbers_.Of(&vertex); }
  const std::vector<const V*>& Vertices() const { return numbers_.Keys(); }

 private:
  KeyNumbers<const V*> numbers_;
};

}  // namespace ch5
