#pragma once
/// A prior is just another edge:  r = r₀ + J (x ⊟ x₀),  W = I,  on the vertices that a marginalization kept.
///
/// H = JᵀJ and b = −Jᵀr₀ at x₀. J stays as it was at x₀ (the prior's first estimate); only x ⊟ x₀ changes with x. With B
/// the small blocks of ∂(x ⊟ x₀)/∂δ, the Hessian elsewhere is  Bᵀ(JᵀJ)B,  whose product in brackets is computed once.

#include <cmath>
#include <memory>
#include <optional>
#include <vector>

#include "ch5_backend/graph/fast_edge.h"
#include "ch5_backend/linear/aligned_vector.h"

namespace ch5 {

/// The result of a marginalization, as plain values.
struct Prior {
  std::vector<std::shared_ptr<Vertex>> vertices;  ///< in the order of J's columns
  std::vector<VecX> x0;                           ///< their parameters at the linearization point
  MatXX J;                                        ///< m×n, n = Σ LocalDimension
  VecX r0;                                        ///< m×1
  std::vector<VecX> first_estimates = {};         ///< the vertices' states when they first entered a prior; empty: x0

  const VecX& FirstEstimate(std::ptrdiff_t i) const {
    return (first_estimates.empty() ? x0 : first_estimates)[static_cast<size_t>(i)];
  }
};

class EdgePrior : public Edge, public FastEdge {
 public:
  /// @throws std::invalid_argument if J, r0, x0 and the vertices do not fit together
  explicit EdgePrior(Prior prior);
  void ComputeResidual() override;
  void ComputeJacobians() override;
  bool NegativeProductsInto(double* C) override;
  std::string TypeInfo() const override { return "EdgePrior"; }

  /// First-estimate Jacobians: J stays that of x₀, without the factor B. Off by default.
  void KeepJacobian(bool keep) { keep_jacobian_ = keep; }

  const Prior& GetPrior() const { return prior_; }

 protected:
  /// For a residual that another class computes.  @param r  as long as r₀
  void SetResidual(const VecX& r) {
    r_ = r;
    minus_delta_.setConstant(NAN);
  }

 private:
  void TakeJacobians() const override;

  Prior prior_;
  ArrayVector r_, minus_delta_;  // r, and the −(x ⊟ x₀) that it was computed at, or NaN
  ArrayMatrix W_;
  mutable MatXX J_;                       // the vertices' blocks side by side
  std::optional<ArrayMatrix> minus_JtJ_;  // at x₀, its lower half; empty until it is asked for
  bool keep_jacobian_ = false;
};

}  // namespace ch5
