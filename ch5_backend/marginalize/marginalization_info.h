#pragma once
/// VINS-Mono's MarginalizationInfo: residuals with the positions of the blocks to drop in each of them.
///
///         dropped (m)  kept (n)
///       ┌───────────┬──────────┐
///   A = │   A_mm    │   A_mr   │     A = Σ JᵀW_ρJ,  b = +Σ ρ'JᵀWr   (VINS' sign: A Δx = −b)
///       ├───────────┼──────────┤     A_r = A_rr − A_rm A_mm⁺ A_mr,  b_r = b_r − A_rm A_mm⁺ b_m
///       │   A_rm    │   A_rr   │     J = S^½ Vᵀ,  r₀ = S^-½ Vᵀ b_r,  A_r = V S Vᵀ
///       └───────────┴──────────┘     eigenvalues ≤ 1e-8 count as zero, in A_mm and in A_r
///
/// Blocks are kept by vertex id, never by address, so that a run repeats to the bit. For speed the estimators call
/// Marginalize (marginalize.h), which gives the same prior; this is the plain form.
/// Source: Qin, Li, Shen, "VINS-Mono", TRO 2018, §VI-D.
///
/// Five functions are homework stage 6 and live in solutions/vins_window.cc; the rest is core.

#include <map>
#include <memory>
#include <vector>

#include "ch5_backend/marginalize/edge_prior.h"

namespace ch5 {

/// One residual to be marginalized. `drop_set` holds positions in edge->Vertices().
struct ResidualBlockInfo {
  std::shared_ptr<Edge> edge;
  std::vector<int> drop_set;
};

class MarginalizationInfo {
 public:
  static constexpr double kEps = 1e-8;  ///< eigenvalues up to it count as zero

  /// A vertex and its place in A.
  struct Block {
    std::shared_ptr<Vertex> vertex;
    VecX x0;  // its parameters in PreMarginalize
    int idx;  // its first row in A
  };
  /// What remains for the kept vertices, H Δx = b.
  struct KeptSystem {  // n×n and n×1
    MatXX A;
    VecX b;
  };

  virtual ~MarginalizationInfo();

  /// @throws std::invalid_argument if the edge is null, one of its vertices is in no graph, or a position lies outside of
  ///         them
  void AddResidualBlockInfo(const ResidualBlockInfo& info);

  /// Stage 6a, 6b. Evaluates every residual at the present states, remembers the states, and numbers the blocks: those
  /// that any residual drops first, the others after them, each in order of id. Fixed vertices have no columns.
  virtual void PreMarginalize();

  /// Stage 6c. A_ and b_, (m + n)×(m + n) and (m + n)×1.
  virtual void ConstructA();
  /// Stage 6d. A_r and b_r.
  virtual KeptSystem SchurComplement() const;
  /// Stage 6e. linearized_jacobians_ and linearized_residuals_ from A_r and b_r.
  virtual void Factor(const KeptSystem& kept);
  /// The three of them; after PreMarginalize.
  void Marginalize();

  /// Stage 6f. The prior on the kept blocks. A window that slides hands its states on: `shift` maps the id of a kept
  /// vertex to the vertex that takes over its state (VINS' addr_shift); all others stay.
  virtual Prior GetParameterBlocks(const std::map<int, std::shared_ptr<Vertex>>& shift = {}) const;

  int m() const { return m_; }  ///< rows of the dropped blocks
  int n() const { return n_; }  ///< rows of the kept blocks
  const MatXX& A() const { return A_; }
  const VecX& b() const { return b_; }

 protected:
  std::vector<ResidualBlockInfo> factors_;
  std::map<int, Block> blocks_;  // by vertex id
  std::vector<int> keep_;        // ids of the kept blocks, in the order of their rows
  int m_ = 0, n_ = 0;
  MatXX A_;
  VecX b_;
  MatXX linearized_jacobians_;
  VecX linearized_residuals_;
};

}  // namespace ch5
