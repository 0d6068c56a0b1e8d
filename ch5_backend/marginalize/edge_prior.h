#pragma once
/// A prior is just another edge:  r = r₀ + J (x ⊟ x₀),  W = I,  on the vertices that a marginalisation kept.
///
/// H = JᵀJ and b = −Jᵀr₀ at x₀. J stays as it was at x₀ (the prior's first estimate); only ⊟ moves with x.

#include <memory>
#include <vector>

#include "ch5_backend/graph/edge.h"

namespace ch5 {

/// What a marginalisation leaves behind, as plain values.
struct Prior {
  std::vector<std::shared_ptr<Vertex>> vertices;  ///< in the order of J's columns
  std::vector<VecX> x0;                           ///< their parameters at the linearisation point
  MatXX J;                                        ///< m×n, n = Σ LocalDimension
  VecX r0;                                        ///< m×1
};

class EdgePrior : public Edge {
 public:
  /// @throws std::invalid_argument if J, r0, x0 and the vertices do not fit together
  explicit EdgePrior(Prior prior);
  void ComputeResidual() override;
  void ComputeJacobians() override;
  std::string TypeInfo() const override { return "EdgePrior"; }

  const Prior& GetPrior() const { return prior_; }

 private:
  Prior prior_;
  VecX r_;
  MatXX W_;
  MatXX J_;  // the vertices' blocks side by side
};

}  // namespace ch5
