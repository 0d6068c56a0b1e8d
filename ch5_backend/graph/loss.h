#pragma once
/// Robust loss functions ρ(s) of the squared residual s = rᵀWr, and what they do to H and b.
///
/// Cost ½ Σ ρ(s);  ρ(s) = s for small s, so that ρ'(0) = 1.  Source: Triggs et al., "Bundle Adjustment — A Modern
/// Synthesis", 2000, §4.3; Ceres' conventions for δ.

#include <array>

#include "ch5_backend/math/eigen_types.h"

namespace ch5 {

/// ρ(s), ρ'(s), ρ''(s).
using Rho = std::array<double, 3>;

/// How the second derivative of ρ enters H (Triggs' correction), see CorrectLoss.
enum class LossCorrection { kTriggs, kIrls };

class LossFunction {
 public:
  explicit LossFunction(LossCorrection correction = LossCorrection::kTriggs) : correction_(correction) {}
  virtual ~LossFunction() = default;
  /// @param s  rᵀWr ≥ 0, dimensionless
  virtual Rho Evaluate(double s) const = 0;
  LossCorrection Correction() const { return correction_; }

 private:
  LossCorrection correction_;
};

/// ρ(s) = s.
class TrivialLoss : public LossFunction {
 public:
  Rho Evaluate(double s) const override { return {s, 1.0, 0.0}; }
};

/// ρ(s) = s for s ≤ δ², else 2δ√s − δ².
class HuberLoss : public LossFunction {
 public:
  /// @throws std::invalid_argument unless δ > 0
  explicit HuberLoss(double delta, LossCorrection correction = LossCorrection::kTriggs);
  Rho Evaluate(double s) const override;

 private:
  double delta_;
};

/// ρ(s) = δ² log(1 + s/δ²).
class CauchyLoss : public LossFunction {
 public:
  explicit CauchyLoss(double delta, LossCorrection correction = LossCorrection::kTriggs);
  Rho Evaluate(double s) const override;

 private:
  double square_;
};

/// ρ(s) = δ²/3 (1 − (1 − s/δ²)³) for s ≤ δ², else δ²/3: an outlier has no influence at all.
class TukeyLoss : public LossFunction {
 public:
  explicit TukeyLoss(double delta, LossCorrection correction = LossCorrection::kTriggs);
  Rho Evaluate(double s) const override;

 private:
  double square_;
};

/// The robust information matrix is  W_ρ = weight·W + rank_one·(Wr)(Wr)ᵀ;  b uses ρ' alone.
struct RobustWeight {
  double weight;    // ρ'
  double rank_one;  // 2ρ'' where ρ' + 2ρ''s > 0 keeps W_ρ positive, else 0
};

/// Triggs' correction of ½ρ(rᵀWr): gradient ρ' JᵀWr, Hessian ≈ Jᵀ W_ρ J.
RobustWeight CorrectLoss(const Rho& rho, double s, LossCorrection correction);

}  // namespace ch5
