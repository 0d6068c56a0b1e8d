#pragma once
/// What typical mistakes in MarginalizationInfo's SchurComplement (6d) and Factor (6e) give.

#include <string>
#include <vector>

#include "ch5_backend/marginalize/square_root.h"
#include "ch5_homework/judge/diagnosis.h"
#include "ch5_homework/judge/mistakes/elimination.h"
#include "ch5_homework/judge/mistakes/formula.h"
#include "ch5_homework/judge/stage_6_scene.h"

namespace ch5::homework::stage_6 {

// ---- 6d SchurComplement -------------------------------------------------------------------------------------------

/// A and b with the dropped rows first, and what typical mistakes make of them.
struct SchurCase {
  MatXX A;
  VecX b;
  int m;
  MatXX mm_pinv;

  SchurCase(const MatXX& A_given, const VecX& b_given, int dropped) : A(A_given), b(b_given), m(dropped) {
    mm_pinv = Pinv(1e-8);
  }
  int n() const { return static_cast<int>(A.rows()) - m; }
  MatXX Pinv(double eps) const {
    const SymmetricEigen mm = DecomposeSymmetric(A.topLeftCorner(m, m));
    const VecX S = (mm.S.array() > eps).select(mm.S.cwiseInverse(), 0.0);
    return mm.V * S.asDiagonal() * mm.V.transpose();
  }
  MatXX Arr() const { return A.bottomRightCorner(n(), n()); }
  /// With something in place of A_mm⁺.
  MatXX Schur(const MatXX& middle) const {
    return Arr() - A.bottomLeftCorner(n(), m) * middle * A.topRightCorner(m, n());
  }
  VecX Reduced(const MatXX& middle) const { return Reduced(middle, b.tail(n()), b.head(m)); }
  VecX Reduced(const MatXX& middle, const VecX& b_r, const VecX& b_m) const {
    return b_r - A.bottomLeftCorner(n(), m) * (middle * b_m);
  }
  std::vector<Mistake> InA() const {
    std::vector<Mistake> mistakes = FormulaMistakes();
    Append(EliminationMistakes({"6d", "6d", "A_rr", "A_rm A_mm⁺ A_mr", "A_mm⁺", "A_mm"}, Arr(), A.topLeftCorner(m, m),
                               mm_pinv, [this](const MatXX& middle) { return Schur(middle); }),
           &mistakes);
    Append(CornerMistakes(), &mistakes);
    return mistakes;
  }
  std::vector<Mistake> FormulaMistakes() const {
    const MatXX A_mm = A.topLeftCorner(m, m), uncut = Pinv(1e-300);
    const SymmetricEigen mm = DecomposeSymmetric(A_mm);
    const VecX S = (mm.S.array() > 1e-8).select(mm.S.cwiseInverse(), 0.0);
    return {{"6d", AsLargeAs("A_"), A},
            {"6d", "6.eigenvalues_up_kEps_inverted", Schur(uncut)},
            {"6d", "6.cut_relative_to_largest", Schur(Pinv(1e-8 * mm.S.maxCoeff()))},
            {"6d", "6.cut_at_another_limit", Schur(Pinv(1e-4))},
            {"6d", "6.cut_at_another_limit", Schur(Pinv(1e-6))},
            {"6d", "6.eigenvalues_above_eps_cut", Schur(uncut - mm_pinv)},
            {"6d", MissingFrom("V", "A_mm⁺ = V S⁺ Vᵀ"), Schur(S.asDiagonal())},
            {"6d", "6.VT_missing_in_pinv", Schur(mm.V * S.asDiagonal() * mm.V)},
            {"6d", "6.V_transposed_in_pinv", Schur(mm.V.transpose() * S.asDiagonal() * mm.V)}};
  }
  /// One corner of A stands where another is meant.
  std::vector<Mistake> CornerMistakes() const {
    const Text rm = "6.A_rm_wrong_corner", mr = "6.A_mr_wrong_corner", both = "6.A_rm_A_mr_wrong_corners",
               all = "6.corners_exchanged";
    const auto with = [this](const MatXX& A_rm, const MatXX& A_mr) { return MatXX(Arr() - A_rm * mm_pinv * A_mr); };
    const int n = this->n();
    const MatXX A_rm = A.bottomLeftCorner(n, m), A_mr = A.topRightCorner(m, n), other_rm = A.topRightCorner(n, m),
                other_mr = A.bottomLeftCorner(m, n);
    std::vector<Mistake> mistakes{{"6d", "6.A_rr_wrong_corner", A.topLeftCorner(n, n) - Arr() + Schur(mm_pinv)},
                                  {"6d", rm, with(A.topLeftCorner(n, m), A_mr)},
                                  {"6d", rm, with(other_rm, A_mr)},
                                  {"6d", rm, with(A.bottomRightCorner(n, m), A_mr)},
                                  {"6d", both, with(other_rm, other_mr)},
                                  {"6d", mr, with(A_rm, A.topLeftCorner(m, n))},
                                  {"6d", mr, with(A_rm, other_mr)},
                                  {"6d", mr, with(A_rm, A.bottomRightCorner(m, n))},
                                  {"6d", all, A.topLeftCorner(n, n) - other_rm * mm_pinv * other_mr}};
    if (n == m) mistakes.push_back({"6d", all, A.topLeftCorner(n, n) - other_rm * Arr().inverse() * other_mr});
    return mistakes;
  }
  std::vector<Mistake> InB() const {
    const VecX b_r = b.tail(n()), b_m = b.head(m);
    std::vector<Mistake> mistakes{{"6d", AsLargeAs("b_"), b},
                                  {"6d", "6.eigenvalues_up_kEps_inverted", Reduced(Pinv(1e-300))},
                                  {"6d", "6.b_r_wrong_part_b", Reduced(mm_pinv, b.head(n()), b_m)},
                                  {"6d", "6.b_m_wrong_part_b", Reduced(mm_pinv, b_r, b.tail(m))},
                                  {"6d", "6.b_r_b_m_exchanged", Reduced(mm_pinv, b.head(n()), b.tail(m))}};
    Append(EliminationMistakes({"6d", "6d", "b_r", "A_rm A_mm⁺ b_m", "A_mm⁺", "A_mm"}, b_r, A.topLeftCorner(m, m),
                               mm_pinv, [this](const MatXX& middle) { return Reduced(middle); }),
           &mistakes);
    return mistakes;
  }
};

// ---- 6e Factor ----------------------------------------------------------------------------------------------------

struct FactorCase {
  MatXX A;
  VecX b;
  MatXX V, S, S_pinv, S_uncut;  // A_r = V S Vᵀ, diagonal matrices

  FactorCase(const MatXX& A_given, const VecX& b_given) : A(A_given), b(b_given) {
    const SymmetricEigen eigen = DecomposeSymmetric(A);
    const auto known = eigen.S.array() > 1e-8;
    V = eigen.V;
    S = VecX(known.select(eigen.S, 0.0)).asDiagonal();
    S_pinv = VecX(known.select(eigen.S.cwiseInverse(), 0.0)).asDiagonal();
    S_uncut = VecX(eigen.S.cwiseMax(0.0)).asDiagonal();
  }
  MatXX CutAt(double eps) const {
    const VecX uncut = S_uncut.diagonal();
    return VecX((uncut.array() > eps).select(uncut, 0.0)).asDiagonal();
  }
  MatXX CutRelatively() const { return CutAt(1e-8 * S_uncut.maxCoeff()); }
  static MatXX Root(const MatXX& diagonal) { return diagonal.cwiseSqrt(); }
  MatXX RightJ() const { return Root(S) * V.transpose(); }

  std::vector<Mistake> InJ() const {
    const auto gram = [](const MatXX& J) { return MatXX(J.transpose() * J); };
    return {{"6e", StandsFor("V", "Vᵀ", "J = S^½ Vᵀ"), gram(Root(S) * V)},
            {"6e", "6.J_transposed", gram(V * Root(S))},
            {"6e", RootMeant("S"), gram(S * V.transpose())},
            {"6e", RootTwice("S"), gram(Root(Root(S)) * V.transpose())},
            {"6e", MissingFrom("S^½", "J = S^½ Vᵀ"), gram(V.transpose())},
            {"6e", StandsFor("S^-½", "S^½"), gram(Root(S_pinv) * V.transpose())},
            {"6e", "6.eigenvalues_up_kEps_count_J", gram(Root(S_uncut) * V.transpose())},
            {"6e", "6.cut_relative_to_largest", gram(Root(CutRelatively()) * V.transpose())},
            {"6e", "6.cut_at_another_limit", gram(Root(CutAt(1e-6)) * V.transpose())},
            {"6e", "6.S_for_root", gram(S * V)},
            {"6e", "6.J_A_r_itself", gram(A)}};
  }
  /// As answers of Jᵀr₀.
  std::vector<Mistake> InR0() const {
    const MatXX Jt = RightJ().transpose();
    const auto r0 = [=](const MatXX& r) { return MatXX(Jt * r); };
    return {{"6e", "6.sign_of_r0", r0(-Root(S_pinv) * V.transpose() * b)},
            {"6e", "6.r0_zero", r0(VecX::Zero(b.size()))},
            {"6e", "6.cut_relative_to_largest",
             r0((CutRelatively().array() > 0.0).select(Root(S_pinv), 0.0) * V.transpose() * b)},
            {"6e", "6.r0_b_r_itself", r0(b)},
            {"6e", Missing("S^-½", "Vᵀ b_r"), r0(V.transpose() * b)},
            {"6e", StandsFor("S^½", "S^-½"), r0(Root(S) * V.transpose() * b)},
            {"6e", RootMeant("1/S"), r0(S_pinv * V.transpose() * b)},
            {"6e", RootTwice("1/S"), r0(Root(Root(S_pinv)) * V.transpose() * b)},
            {"6e", StandsFor("Jᵀ", "S^-½ Vᵀ"), r0(Jt * b)},
            {"6e", StandsFor("S", "S^-½"), r0(S * V.transpose() * b)},
            {"6e", Text("6.sign_and_stands_for", {{"this", Word("S^½")}, {"that", Word("S^-½")}}),
             r0(-Root(S) * V.transpose() * b)},
            {"6e", "6.sign_and_S_isqrt_missing", r0(-V.transpose() * b)},
            {"6e", "6.sign_r0_b_r_itself", r0(-b)},
            {"6e", Missing("V", "S^-½ b_r"), r0(Root(S_pinv) * b)},
            {"6e", StandsFor("V", "Vᵀ", "r₀ = S^-½ Vᵀ b_r"), r0(Root(S_pinv) * V * b)}};
  }
};

}  // namespace ch5::homework::stage_6
