/// Robust losses: published numbers, derivatives, and what they make of an edge's gradient and Hessian.
#include "ch5_backend/graph/loss.h"

#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <string>
#include <typeinfo>
#include <vector>

#include "ch5_backend/graph/graph.h"
#include "ch5_backend/graph/sized_edge.h"
#include "ch5_backend/types/vertices.h"

namespace ch5 {
namespace {

std::vector<std::shared_ptr<LossFunction>> UsualLosses(double delta) {
  return {std::make_shared<TrivialLoss>(), std::make_shared<HuberLoss>(delta), std::make_shared<CauchyLoss>(delta),
          std::make_shared<TukeyLoss>(delta)};
}

std::vector<std::shared_ptr<LossFunction>> AllLosses(double delta) {
  auto losses = UsualLosses(delta);
  losses.insert(losses.end(), {std::make_shared<PseudoHuberLoss>(delta), std::make_shared<GemanMcClureLoss>(delta),
                               std::make_shared<WelschLoss>(delta), std::make_shared<FairLoss>(delta),
                               std::make_shared<SaturatedLoss>(delta), std::make_shared<DcsLoss>(delta),
                               std::make_shared<ScaleDeltaLoss>(std::make_shared<HuberLoss>(1.0), delta)});
  return losses;
}

std::string NameOf(const LossFunction& loss) { return typeid(loss).name(); }

TEST(Loss, DerivativesEqualCentralDifferences) {
  for (const double delta : {0.07, 0.7, 1.3, 5.0}) {
    for (const auto& loss : AllLosses(delta)) {
      for (const double fraction : {0.01, 0.5, 0.98, 1.02, 2.25, 100.0}) {  // on both sides of s = δ²
        const double s = fraction * delta * delta, h = 1e-5 * s;
        const Rho rho = loss->Evaluate(s), left = loss->Evaluate(s - h), right = loss->Evaluate(s + h);
        EXPECT_NEAR(rho[1], (right[0] - left[0]) / (2.0 * h), 1e-8) << NameOf(*loss) << " at " << s;
        EXPECT_NEAR(rho[2] * s, (right[1] - left[1]) / (2.0 * h) * s, 1e-8) << NameOf(*loss) << " at " << s;
      }
    }
  }
}

TEST(Loss, SmallResidualsAreUntouchedAndLargeOnesNeverCountMore) {
  for (const auto& loss : AllLosses(0.7)) {
    const std::string name = NameOf(*loss);
    const Rho zero = loss->Evaluate(0.0);
    EXPECT_EQ(zero[0], 0.0) << name;
    EXPECT_EQ(zero[1], 1.0) << name;
    EXPECT_TRUE(std::isfinite(zero[2])) << name;
    // Fair's loss leaves s by O(s^1.5), all others by O(s²).
    EXPECT_NEAR(loss->Evaluate(1e-8)[0], 1e-8, 1e-8 * 1e-3) << name;
    double last = 1.0;
    for (double s = 1e-3; s < 1e6; s *= 1.7) {
      const Rho rho = loss->Evaluate(s);
      EXPECT_LE(rho[0], s * (1 + 1e-12)) << name << " at " << s;
      EXPECT_LE(rho[1], last) << name << " at " << s;
      EXPECT_GE(rho[1], 0.0) << name << " at " << s;
      last = rho[1];
    }
  }
}

TEST(Loss, LimitsWorkedByHand) {
  EXPECT_NEAR(GemanMcClureLoss(4.0).Evaluate(12.0)[0], 3.0, 1e-15);     // 4·12/16
  EXPECT_NEAR(PseudoHuberLoss(1.0).Evaluate(8.0)[0], 4.0, 1e-15);       // 2(√9 − 1)
  EXPECT_NEAR(WelschLoss(2.0).Evaluate(4.0)[0], 4 - 4 / M_E, 1e-14);    // δ²(1 − 1/e)
  EXPECT_NEAR(FairLoss(3.0).Evaluate(9.0)[0], 18 - 18 * M_LN2, 1e-14);  // 2δ²(1 − log 2)
  EXPECT_EQ(SaturatedLoss(3.0).Evaluate(100.0)[0], 9.0);
  EXPECT_NEAR(DcsLoss(2.0).Evaluate(6.0)[0], 4.0, 1e-15);   // 2(18 − 2)/8
  EXPECT_NEAR(DcsLoss(2.0).Evaluate(6.0)[1], 0.25, 1e-15);  // c = 4/8
  const ScaleDeltaLoss scaled(std::make_shared<HuberLoss>(1.0), 0.5);
  EXPECT_NEAR(scaled.Evaluate(4.0)[0], HuberLoss(0.5).Evaluate(4.0)[0], 1e-15);
}

template <typename Loss>
class Threshold : public testing::Test {};
using WithThreshold = testing::Types<HuberLoss, PseudoHuberLoss, CauchyLoss, GemanMcClureLoss, WelschLoss, FairLoss,
                                     TukeyLoss, SaturatedLoss, DcsLoss>;
TYPED_TEST_SUITE(Threshold, WithThreshold, );  // Clang wants a variadic argument, be it empty

TYPED_TEST(Threshold, MustBePositiveAndFinite) {
  for (const double bad : {0.0, -1.0, std::nan(""), static_cast<double>(INFINITY)}) {
    EXPECT_THROW(TypeParam{bad}, std::invalid_argument);
  }
}

TEST(Loss, ScaleDeltaNeedsALossAndAThreshold) {
  EXPECT_THROW(ScaleDeltaLoss(nullptr, 1.0), std::invalid_argument);
  EXPECT_THROW(ScaleDeltaLoss(std::make_shared<TrivialLoss>(), 0.0), std::invalid_argument);
}

// Ceres' loss_function_test.
TEST(Loss, SecondDerivativeAtZeroIsCeres) {
  EXPECT_DOUBLE_EQ(CauchyLoss(0.7).Evaluate(0.0)[2], -1.0 / 0.49);
  EXPECT_DOUBLE_EQ(TukeyLoss(0.7).Evaluate(0.0)[2], -2.0 / 0.49);
}

// GTSAM's testNoiseModel: k = 5, residual 10. Its weight is ρ', its loss ½ρ.
TEST(Loss, NumbersOfGtsamsNoiseModels) {
  EXPECT_DOUBLE_EQ(HuberLoss(5.0).Evaluate(100.0)[1], 0.5);
  EXPECT_DOUBLE_EQ(0.5 * HuberLoss(5.0).Evaluate(100.0)[0], 37.5);
  EXPECT_DOUBLE_EQ(CauchyLoss(5.0).Evaluate(100.0)[1], 0.2);
  EXPECT_NEAR(0.5 * CauchyLoss(5.0).Evaluate(100.0)[0], 20.117973905, 5e-10);
  EXPECT_EQ(TukeyLoss(5.0).Evaluate(100.0)[1], 0.0);
  EXPECT_NEAR(0.5 * TukeyLoss(5.0).Evaluate(100.0)[0], 4.1666667, 5e-8);
}

// Ceres' corrector_test, r = √3, J = 10, ρ = (3, 0.1, −0.01): there both r and J are scaled by √0.1, which is our IRLS
// weight; with the second derivative, JᵀW_ρJ = J²(ρ' + 2ρ''s) = 100 (0.1 − 0.06).
TEST(Loss, CorrectionOfCeresExample) {
  const Rho rho = {3.0, 0.1, -0.01};
  const RobustWeight irls = CorrectLoss(rho, 3.0, LossCorrection::kIrls);
  EXPECT_NEAR(irls.weight, std::sqrt(0.1) * std::sqrt(0.1), 1e-15);
  EXPECT_EQ(irls.rank_one, 0.0);
  const RobustWeight triggs = CorrectLoss(rho, 3.0, LossCorrection::kTriggs);
  EXPECT_EQ(triggs.weight, 0.1);
  EXPECT_NEAR(100.0 * (triggs.weight + triggs.rank_one * 3.0), 4.0, 1e-13);
}

// Cauchy(1): ρ' + 2ρ''s = (1 − s)/(1 + s)².
TEST(Loss, RankOneTermOnlyWhereItKeepsTheHessianPositive) {
  const CauchyLoss cauchy(1.0);
  for (const double s : {0.0, 0.5, 0.999, 1.001, 2.0, 1e6}) {
    const RobustWeight robust = CorrectLoss(cauchy.Evaluate(s), s, LossCorrection::kTriggs);
    EXPECT_EQ(robust.rank_one != 0.0, s < 1.0) << s;
    EXPECT_GT(robust.weight + robust.rank_one * s, 0.0) << s;
  }
}

// Huber's ρ' + 2ρ''s is zero for every s > δ²; no rounding may switch the term on.
TEST(Loss, HuberNeverHasARankOneTerm) {
  for (const double delta : {0.1, 0.7, 1.0, 3.3}) {
    const HuberLoss huber(delta);
    for (double s = 1e-3; s < 1e6; s *= 1.0173) {
      ASSERT_EQ(CorrectLoss(huber.Evaluate(s), s, LossCorrection::kTriggs).rank_one, 0.0) << delta << " " << s;
    }
  }
}

// Tiny, usual, and so far out that a product of them overflows.
TEST(Loss, ManyAtOnceAreTheSumAndTheWeightsOfEach) {
  for (const double scale : {1e-18, 1e-6, 1.0, 1e4, 1e300}) {
    std::vector<double> s;
    for (int k = 0; k < 157; ++k) s.push_back(scale * (0.01 + std::abs(std::sin(7.0 * k))));
    const int n = static_cast<int>(s.size());
    auto losses = UsualLosses(0.7);
    losses.push_back(std::make_shared<CauchyLoss>(0.7, LossCorrection::kIrls));
    for (size_t i = 0; i < losses.size(); ++i) {
      const LossFunction& loss = *losses[i];
      std::vector<double> weight(s.size()), rank_one(s.size());
      loss.Weigh(s.data(), n, weight.data(), rank_one.data());
      double sum = 0.0;
      for (size_t k = 0; k < s.size(); ++k) {
        sum += loss.Evaluate(s[k])[0];
        const RobustWeight robust = CorrectLoss(loss.Evaluate(s[k]), s[k], loss.Correction());
        EXPECT_DOUBLE_EQ(weight[k], robust.weight) << i << " " << s[k];
        EXPECT_DOUBLE_EQ(rank_one[k], robust.rank_one) << i << " " << s[k];
      }
      EXPECT_NEAR(loss.Sum(s.data(), n) / sum, 1.0, 3e-14) << i << " " << scale;
    }
  }
}

// r = A x − c: with a linear residual, JᵀW_ρJ is the exact Hessian of ½ρ wherever the rank-one term is kept.
class LinearEdge : public SizedEdge<2, VertexVector<3>> {
 public:
  explicit LinearEdge(std::shared_ptr<VertexVector<3>> x) : SizedEdge(std::move(x)) {}
  void ComputeResidual() override { r_ = A() * GetVertex<0>().GetEstimate() - Vec2(0.3, -0.2); }
  void ComputeJacobians() override { J<0>() = A(); }
  std::string TypeInfo() const override { return "LinearEdge"; }
  static Mat23 A() { return (Mat23() << 1, 2, -1, 0.5, -1, 2).finished(); }
};

// ρ' JᵀWr at the present state, what b holds negated.
Vec3 Gradient(LinearEdge* edge) {
  edge->ComputeResidual();
  edge->ComputeJacobians();
  return edge->GetRobustWeight().weight * edge->Jacobian(0).transpose() * edge->Information() * edge->Residual();
}

struct Derivatives {
  Vec3 gradient;
  Mat33 hessian;
};

// Of ½ρ, by central differences of the cost and of the gradient.
Derivatives NumericDerivatives(VertexVector<3>* x, LinearEdge* edge) {
  constexpr double kStep = 1e-5;
  const Vec3 x0 = x->GetEstimate();
  Derivatives d;
  for (int k = 0; k < 3; ++k) {
    const auto cost_at = [&](double step, Vec3* gradient) {
      x->SetEstimate(x0 + step * Vec3::Unit(k));
      *gradient = Gradient(edge);
      x->SetEstimate(x0);
      return edge->Cost();
    };
    Vec3 left, right;
    const double cost_left = cost_at(-kStep, &left), cost_right = cost_at(kStep, &right);
    d.gradient[k] = (cost_right - cost_left) / (2.0 * kStep);
    d.hessian.col(k) = (right - left) / (2.0 * kStep);
  }
  return d;
}

TEST(Loss, RobustGradientAndHessianAreThoseOfHalfRho) {
  const auto x = std::make_shared<VertexVector<3>>(Vec3(0.1, 0.2, -0.15));
  LinearEdge edge(x);
  edge.SetInformation((Mat22() << 2.0, 0.5, 0.5, 1.0).finished());
  for (const double delta : {0.3, 2.0}) {  // far out, and near the middle
    for (const auto& loss : UsualLosses(delta)) {
      edge.SetLossFunction(loss);
      const Derivatives numeric = NumericDerivatives(x.get(), &edge);
      EXPECT_LT((Gradient(&edge) - numeric.gradient).norm(), 1e-8);
      double drho;
      MatXX W_rho;
      edge.RobustInfo(&drho, &W_rho);
      const Mat33 H = LinearEdge::A().transpose() * W_rho * LinearEdge::A();
      const bool keeps_curvature = edge.GetRobustWeight().rank_one != 0.0;
      if (keeps_curvature || loss->Evaluate(edge.Chi2())[2] == 0.0) {
        EXPECT_LT((H - numeric.hessian).norm(), 1e-7) << delta;
      }
    }
  }
}

}  // namespace
}  // namespace ch5
