#pragma once
/// What typical mistakes in OKVIS's SchurComplement (5.2) and UpdateErrorComputation (5.3) give.

#include <string>
#include <vector>

#include "ch5_backend/marginalize/square_root.h"
#include "ch5_backend/math/psd.h"
#include "ch5_homework/judge/narrate.h"
#include "ch5_homework/judge/scenes.h"

namespace ch5::homework::stage_5 {

struct SchurCase {
  MatXX V, W, U, V_inverse;
  VecX b_b, b_a;

  SchurCase(int stays, int goes, Random* random)
      : V(RandomPositiveDefinite(goes, random)),
        W(RandomMatrix(stays, goes, random)),
        b_b(RandomMatrix(goes, 1, random)),
        b_a(RandomMatrix(stays, 1, random)) {
    V_inverse = PseudoInversePsd(V);
    U = RandomPositiveDefinite(stays, random) + W * V_inverse * W.transpose();
  }

  MatXX Subtracted() const { return W * V_inverse * W.transpose(); }
  std::vector<Mistake> Mistakes() const {
    const MatXX S = PseudoInverseSquareRoot(V);
    return {{"5.2", "U was not changed", [this] { return U; }},
            {"5.2", "the sign: M Mᵀ is added, not subtracted", [this] { return MatXX(U + Subtracted()); }},
            {"5.2", "U is overwritten with −M Mᵀ: it is `*U -= …`", [this] { return MatXX(-Subtracted()); }},
            {"5.2", "U is overwritten with M Mᵀ: it is `*U -= …`", [this] { return Subtracted(); }},
            {"5.2", "V⁺ is missing: this is U − W Wᵀ", [this] { return MatXX(U - W * W.transpose()); }},
            {"5.2", "V stands where its inverse is meant", [this] { return MatXX(U - W * V * W.transpose()); }},
            {"5.2", "V_inv_sqrt is not symmetric: M = W V_inv_sqrt, without a transpose",
             [this, S] { return S.rows() == S.cols() ? MatXX(U - W * S.transpose() * S * W.transpose()) : U; }},
            {"5.2", "V⁺ is squared: M holds V⁺, but its root V_inv_sqrt is meant",
             [this] { return MatXX(U - W * V_inverse * V_inverse * W.transpose()); }},
            {"5.2", "only one root of V⁺: M Mᵀ has two of them, one in each M",
             [this, S] { return S.rows() == S.cols() ? MatXX(U - W * S * W.transpose()) : U; }},
            {"5.2", "only one root of V⁺: M Mᵀ has two of them, one in each M",
             [this, S] { return S.rows() == S.cols() ? MatXX(U - W * S.transpose() * W.transpose()) : U; }},
            {"5.2", "U is changed twice: M Mᵀ is subtracted once", [this] { return MatXX(U - 2.0 * Subtracted()); }},
            {"5.2", "only one triangle of U is changed, its mirror image holds what was there before",
             [this] { return MatXX(U - MatXX(Subtracted().triangularView<Eigen::Upper>())); }},
            {"5.2", "only one triangle of U is changed, its mirror image holds what was there before",
             [this] { return MatXX(U - MatXX(Subtracted().triangularView<Eigen::Lower>())); }},
            {"5.2", "half of M Mᵀ is subtracted", [this] { return MatXX(U - 0.5 * Subtracted()); }}};
  }
  std::vector<Mistake> MistakesInB() const {
    const MatXX S = PseudoInverseSquareRoot(V);
    const auto minus = [this](const VecX& b) { return [=] { return MatXX(b_a - b); }; };
    std::vector<Mistake> mistakes{
        {"5.2", "b_a was not changed", minus(VecX::Zero(b_a.size()))},
        {"5.2", "the sign: M V_inv_sqrtᵀ b_b is added, not subtracted", minus(-W * (V_inverse * b_b))},
        {"5.2", "b_a is overwritten: it is `*b_a -= …`", [this] { return MatXX(-W * (V_inverse * b_b)); }},
        {"5.2", "V⁺ is missing: this is b_a − W b_b", minus(W * b_b)},
        {"5.2", "V stands where its inverse is meant", minus(W * (V * b_b))},
        {"5.2", "V⁺ is squared: M holds one root of it, V_inv_sqrtᵀ the other",
         minus(W * (V_inverse * (V_inverse * b_b)))},
        {"5.2", "b_a is changed twice: it is subtracted once", minus(2.0 * W * (V_inverse * b_b))},
        {"5.2", "b_a is overwritten: it is `*b_a -= …`", [this] { return MatXX(W * (V_inverse * b_b)); }}};
    if (S.rows() == S.cols()) {
      mistakes.push_back(
          {"5.2", "V_inv_sqrt acts once only, V_inv_sqrtᵀ b_b is meant: this is b_a − M b_b", minus(W * (S * b_b))});
      mistakes.push_back({"5.2",
                          "V_inv_sqrt acts once only, M = W V_inv_sqrt is missing: this is b_a − W V_inv_sqrtᵀ b_b",
                          minus(W * (S.transpose() * b_b))});
      mistakes.push_back(
          {"5.2", "the transpose is missing: M V_inv_sqrtᵀ b_b, not M V_inv_sqrt b_b", minus(W * (S * (S * b_b)))});
    }
    return mistakes;
  }
};

/// What follows from H and b₀, with OKVIS's letters: P⁻¹HP⁻¹ = U S Uᵀ.
struct Factored {
  MatXX H;
  VecX b0, p;
  MatXX U, S, S_sqrt, S_pinv_sqrt, P, P_inverse;

  Factored(const MatXX& H_given, const VecX& b0_given) : H(H_given), b0(b0_given), p(ScalingOf(H_given)) {
    const ScaledEigen eigen = DecomposeScaled(H, p.cwiseInverse());
    U = eigen.U;
    S_sqrt = eigen.S_sqrt.asDiagonal();
    S_pinv_sqrt = eigen.S_pinv_sqrt.asDiagonal();
    S = S_sqrt * S_sqrt;
    P = p.asDiagonal();
    P_inverse = p.cwiseInverse().asDiagonal();
  }

  struct Factor {
    std::string cause;  // "" if it is right
    MatXX A;
  };
  MatXX I() const { return MatXX::Identity(H.rows(), H.cols()); }

  /// As answers of JᵀJ, whatever rows J has.
  std::vector<Mistake> Mistakes() const {
    const auto gram = [](const MatXX& J) { return [J] { return MatXX(J.transpose() * J); }; };
    MatXX S_first = S_sqrt;  // as many of the first eigenvalues as are not zero
    S_first.diagonal().tail((S_sqrt.diagonal().array() == 0.0).count()).setZero();
    std::vector<Mistake> mistakes{
        {"5.3", "the transpose is missing: J = (P U S^½)ᵀ", gram(P * U * S_sqrt)},
        {"5.3", "U stands where Uᵀ is meant: J = S^½ Uᵀ P", gram(S_sqrt * U * P)},
        {"5.3", "P and S^½ have exchanged their places: J = (P U S^½)ᵀ", gram(P * U.transpose() * S_sqrt)},
        {"5.3", "J is H itself, not its root", gram(H)},
        {"5.3", "P acts on the rows of J, it belongs to the columns: J = S^½ Uᵀ P", gram(P * S_sqrt * U.transpose())},
        {"5.3", "the eigenvalues ascend: those that are not zero stand last", gram(S_first * U.transpose() * P)}};
    for (const Factor& first : {Factor{"", P},
                                {"P is missing: J = (P U S^½)ᵀ", I()},
                                {"P⁻¹ stands where P is meant", P_inverse},
                                {"P stands twice in J", MatXX(P * P)}}) {
      for (const Factor& last : {Factor{"", S_sqrt},
                                 {"S stands where its root is meant", S},
                                 {"the root is drawn twice: S_sqrt is S^½ already", S_sqrt.cwiseSqrt()},
                                 {"S^½ is missing: J = (P U S^½)ᵀ", I()},
                                 {"S^-½ stands where S^½ is meant", S_pinv_sqrt}}) {
        const std::string cause = first.cause.empty() ? last.cause : first.cause;
        if (!cause.empty()) mistakes.push_back({"5.3", cause, gram((first.A * U * last.A).transpose())});
      }
    }
    return mistakes;
  }
  /// As answers of Jᵀe₀.
  std::vector<Mistake> MistakesInE0() const {
    const MatXX Jt = P * U * S_sqrt;
    const auto e0 = [=](const MatXX& e) { return [Jt, e] { return MatXX(Jt * e); }; };
    std::vector<Mistake> mistakes{
        {"5.3", "e₀ is zero: it was not set", e0(VecX::Zero(b0.size()))},
        {"5.3", "e₀ is b₀ itself: (Jᵀ)⁺ is missing", e0(b0)},
        {"5.3", "e₀ is −b₀: (Jᵀ)⁺ is missing", e0(-b0)},
        {"5.3", "J stands where (Jᵀ)⁺ is meant", e0(-Jt.transpose() * b0)},
        {"5.3", "U stands where Uᵀ is meant", e0(-S_pinv_sqrt * U * P_inverse * b0)},
        {"5.3", "(Jᵀ)⁺ is transposed: it is S^-½ Uᵀ P⁻¹", e0(-P_inverse * U * S_pinv_sqrt * b0)}};
    for (const Factor& first : {Factor{"", S_pinv_sqrt},
                                {"S^½ stands where S^-½ is meant", S_sqrt},
                                {"S^-½ is missing in (Jᵀ)⁺ = S^-½ Uᵀ P⁻¹", I()},
                                {"S⁻¹ stands where S^-½ is meant", MatXX(S_pinv_sqrt * S_pinv_sqrt)}}) {
      for (const Factor& last : {Factor{"", P_inverse},
                                 {"P stands where P⁻¹ is meant", P},
                                 {"P⁻¹ is missing in (Jᵀ)⁺ = S^-½ Uᵀ P⁻¹", I()}}) {
        for (const Factor& sign : {Factor{"", -I()}, {"the sign: e₀ = −(Jᵀ)⁺ b₀", I()}}) {
          const std::string cause = first.cause.empty() ? (last.cause.empty() ? sign.cause : last.cause) : first.cause;
          if (!cause.empty()) mistakes.push_back({"5.3", cause, e0(first.A * U.transpose() * last.A * sign.A * b0)});
        }
      }
    }
    return mistakes;
  }
};

}  // namespace ch5::homework::stage_5
