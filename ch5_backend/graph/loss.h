#pragma once
/// Robust loss functions ρ(s) of the squared residual s = rᵀWr, and what they do to H and b.
///
/// Cost ½ Σ ρ(s);  ρ(s) = s for small s, so that ρ'(0) = 1.  Source: Triggs et al., "Bundle Adjustment — A Modern
/// Synthesis", 2000, §4.3; Ceres' conventions for δ.

#include <array>
#include <memory>

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
  /// The same where ρ itself is not needed: this can save a logarithm.
  virtual Rho EvaluateSlopes(double s) const { return Evaluate(s); }
  /// Many at once, which is cheaper for some losses: Σ ρ(s_k), and CorrectLoss of each s_k.
  virtual double Sum(const double* s, int n) const;
  virtual void Weigh(const double* s, int n, double* weight, double* rank_one) const;
  LossCorrection Correction() const { return correction_; }

 private:
  LossCorrection correction_;
};

/// ρ(s) = s.
class TrivialLoss : public LossFunction {
 public:
  Rho Evaluate(double s) const override { return {s, 1.0, 0.0}; }
};

/// A loss with a threshold, the δ or φ of its formula.
class ThresholdLoss : public LossFunction {
 public:
  /// @throws std::invalid_argument unless `threshold` > 0 is finite
  explicit ThresholdLoss(double threshold, LossCorrection correction = LossCorrection::kTriggs);

 protected:
  double threshold_, square_;  // δ and δ², or φ and φ²
};

/// ρ(s) = s for s ≤ δ², else 2δ√s − δ².
class HuberLoss : public ThresholdLoss {
 public:
  using ThresholdLoss::ThresholdLoss;
  Rho Evaluate(double s) const override;
};

/// ρ(s) = δ² log(1 + s/δ²).
class CauchyLoss : public ThresholdLoss {
 public:
  using ThresholdLoss::ThresholdLoss;
  Rho Evaluate(double s) const override;
  Rho EvaluateSlopes(double s) const override;
  double Sum(const double* s, int n) const override;
  void Weigh(const double* s, int n, double* weight, double* rank_one) const override;
};

/// ρ(s) = δ²/3 (1 − (1 − s/δ²)³) for s ≤ δ², else δ²/3: an outlier has no influence at all.
class TukeyLoss : public ThresholdLoss {
 public:
  using ThresholdLoss::ThresholdLoss;
  Rho Evaluate(double s) const override;
};

/// ρ(s) = 2δ² (√(1 + s/δ²) − 1): Huber without a corner.
class PseudoHuberLoss : public ThresholdLoss {
 public:
  using ThresholdLoss::ThresholdLoss;
  Rho Evaluate(double s) const override;
};

/// ρ(s) = φs/(φ + s), which never exceeds φ. Mind that φ is a threshold on s, not on √s, as in g2o.
class GemanMcClureLoss : public ThresholdLoss {
 public:
  using ThresholdLoss::ThresholdLoss;
  Rho Evaluate(double s) const override;
};

/// ρ(s) = δ² (1 − exp(−s/δ²)).
class WelschLoss : public ThresholdLoss {
 public:
  using ThresholdLoss::ThresholdLoss;
  Rho Evaluate(double s) const override;
};

/// ρ(s) = 2δ² (√s/δ − log(1 + √s/δ)).  ρ'' has a pole at s = 0, where only ρ''s = 0 matters: it is given as 0 there.
class FairLoss : public ThresholdLoss {
 public:
  using ThresholdLoss::ThresholdLoss;
  Rho Evaluate(double s) const override;
};

/// ρ(s) = min(s, δ²): truncated least squares.
class SaturatedLoss : public ThresholdLoss {
 public:
  using ThresholdLoss::ThresholdLoss;
  Rho Evaluate(double s) const override;
};

/// Dynamic covariance scaling (Agarwal et al., ICRA 2013): an edge's W is scaled by c², c = min(1, 2φ/(φ + s)); φ is a
/// threshold on s. The loss whose slope is c²: ρ(s) = s for s ≤ φ, else φ(3s − φ)/(s + φ). (g2o reports c²s for ρ,
/// of which c² is not the derivative; a gain ratio needs the integral.)
class DcsLoss : public ThresholdLoss {
 public:
  using ThresholdLoss::ThresholdLoss;
  Rho Evaluate(double s) const override;
};

/// ρ(s) = δ² κ(s/δ²): the loss κ, stretched to another threshold.
class ScaleDeltaLoss : public LossFunction {
 public:
  /// @throws std::invalid_argument unless δ > 0 and there is a κ; the correction is κ's
  ScaleDeltaLoss(std::shared_ptr<const LossFunction> kappa, double delta);
  Rho Evaluate(double s) const override;

 private:
  std::shared_ptr<const LossFunction> kappa_;
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
