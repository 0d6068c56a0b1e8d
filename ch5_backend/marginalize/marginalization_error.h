#pragma once
/// OKVIS's MarginalizationError: normal equations that grow by residuals and shrink by Schur complements.
///
///          dense part      landmarks (the tail)
///        ┌───────────┬─────────────┐
///    H = │    H_00   │    H_01     │     H δχ = b₀ − H Δχ,   Δχ = x ⊟ x₀
///        ├───────────┼─────────────┤     H = JᵀJ,   e = e₀ + J Δχ,   e₀ = −(Jᵀ)⁺ b₀
///        │   H_01ᵀ   │    H_11     │
///        └───────────┴─────────────┘
///
/// A block's linearization point x₀ is its state when it was first connected; later residuals are linearized there too
/// (first-estimate Jacobians). U, V, W are OKVIS's letters for three blocks of H; W is not an information matrix here.
/// Source: Leutenegger et al., IJRR 2015, §4.3.
///
/// Four functions are homework stage 5 and live in solutions/marginalization_error.cc; the rest is core.

#include <memory>
#include <vector>

#include "ch5_backend/marginalize/edge_prior.h"

namespace ch5 {

class MarginalizationError {
 public:
  virtual ~MarginalizationError();

  /// Adds an edge's part of H and b₀. New vertices are connected at their present states; a fixed one has no columns.
  /// The caller removes the edge from its graph.
  /// @throws std::invalid_argument if the edge is null or connects two landmarks
  void AddResidualBlock(const std::shared_ptr<Edge>& edge);

  /// Stage 5.1. Opens rows and columns for a new block of `dim`: a landmark's at the tail of H, any other's at the end
  /// of the dense part. @return its first row
  virtual int InsertBlock(int dim, bool is_landmark);

  /// Marginalizes vertices: landmarks one small block at a time, then the others in one dense block.
  /// @throws std::invalid_argument if a vertex is not connected
  void MarginalizeOut(const std::vector<std::shared_ptr<Vertex>>& vertices);

  /// Stage 5.2.  U ← U − W V⁺ Wᵀ,  b_a ← b_a − W V⁺ b_b  for one block of variables.
  /// @param V  m×m, of the dropped block;  @param W  n×m;  @param U, b_a  of the rest, changed in place;  @param b_b  m×1
  virtual void SchurComplement(const MatXX& V, const MatXX& W, const VecX& b_b, MatXX* U, VecX* b_a);

  /// Stage 5.3.  J and e₀ from H and b₀; call it after adding and marginalizing, before use.
  virtual void UpdateErrorComputation();

  /// Stage 5.4.  e = e₀ + J Δχ for a given Δχ (n×1).
  virtual VecX Residual(const VecX& delta_chi) const;

  /// x ⊟ x₀ of all blocks at their present states.
  VecX ComputeDeltaChi() const;

  /// The result as a prior on the vertices that remain.
  Prior GetPrior() const;

  const MatXX& H() const { return H_; }
  const VecX& b0() const { return b0_; }
  const MatXX& J() const { return J_; }
  const VecX& e0() const { return e0_; }
  /// First row of a connected vertex in this H, −1 otherwise; the vertex's own OrderingId is its row in the solver's.
  int OrderingId(const Vertex& vertex) const;

 protected:
  int dense_size_ = 0;
  MatXX H_;
  VecX b0_;
  MatXX J_;
  VecX e0_;

 private:
  struct Block {
    std::shared_ptr<Vertex> vertex;
    int ordering_id;
    int dim;
    bool is_landmark;
    VecX x0;
  };

  int Find(const Vertex& vertex) const;
  void Connect(const std::shared_ptr<Vertex>& vertex);
  void EliminateLandmarks(const std::vector<const Block*>& landmarks, const std::vector<int>& rows);
  void EliminateDense(const std::vector<int>& rows, const std::vector<bool>& is_dropped);
  void RemoveRows(const std::vector<bool>& is_dropped);

  std::vector<Block> blocks_;
};

}  // namespace ch5
