#pragma once
/// What typical mistakes in MarginalizationInfo's ConstructA (6c), SchurComplement (6d) and Factor (6e) give.

#include <functional>
#include <string>
#include <vector>

#include "ch5_backend/marginalize/square_root.h"
#include "ch5_homework/judge/narrate.h"
#include "ch5_homework/judge/stage_6_scene.h"

namespace ch5::homework::stage_6 {

// ---- 6c ConstructA --------------------------------------------------------------------------------------------------

struct WayMistake {
  std::string cause;
  FactorScene::Way way;
};

template <class Set>
FactorScene::Way Changed(const Set& set) {
  FactorScene::Way way;
  set(&way);
  return way;
}

inline std::vector<WayMistake> WrongWaysToA() {
  using Way = FactorScene::Way;
  const auto times = [](double diagonal, double first, double mirror) {
    return Changed([=](Way* way) {
      way->diagonal = diagonal;
      way->first = first;
      way->mirror = mirror;
    });
  };
  const auto weight = [](auto of) { return Changed([=](Way* way) { way->weight_A = of; }); };
  return {
      {"nothing is written to A_", times(0, 0, 0)},
      {"the loss is forgotten: W_rho, not edge.Information()",
       weight([](const Edge& edge, double, const MatXX&) { return MatXX(edge.Information()); })},
      {"ρ'W stands where W_ρ is meant: W_rho holds the second derivative too",
       weight([](const Edge& edge, double drho, const MatXX&) { return MatXX(drho * edge.Information()); })},
      {"the loss acts twice: W_rho has ρ' in it already",
       weight([](const Edge&, double drho, const MatXX& W_rho) { return MatXX(drho * W_rho); })},
      {"W is missing: JᵀW_ρJ, not JᵀJ", weight([](const Edge&, double, const MatXX& W_rho) {
         return MatXX(MatXX::Identity(W_rho.rows(), W_rho.cols()));
       })},
      {"= stands where += is meant: only the last residual's share is left",
       Changed([](Way* way) { way->last_only = true; })},
      {"the mirrored block is missing", times(1, 1, 0)},
      {"the block (i, j) is missing, only its mirror is there", times(1, 0, 1)},
      {"only the diagonal blocks arrive: each pair i < j has a block too", times(1, 0, 0)},
      {"the mirrored block is not transposed", Changed([](Way* way) { way->transpose = false; })},
      {"the places are exchanged: the block goes to rows idx_i and columns idx_j, its transpose to the mirror place",
       Changed([](Way* way) { way->exchanged = true; })},
      {"the diagonal blocks are doubled: the mirror is for j ≠ i only", times(2, 1, 1)},
      {"the blocks of two different vertices are added twice: j begins at i, not at 0", times(1, 2, 2)},
      {"the diagonal blocks are missing: j begins at i, not behind it", times(0, 1, 1)},
      {"what stands behind a fixed vertex is missing: continue, not break",
       Changed([](Way* way) { way->stops_at_fixed = true; })},
      {"the mirrored block is subtracted", times(1, 1, -1)},
      {"the mirrored block is added twice", times(1, 1, 2)},
      {"the block (i, j) is added twice, its mirror once", times(1, 2, 1)},
      {"the sign: A = +Σ JᵀW_ρJ", times(-1, -1, -1)}};
}

inline std::vector<Mistake> MistakesInA(const FactorScene& scene) {
  std::vector<Mistake> mistakes;
  for (const auto& one : WrongWaysToA()) {
    mistakes.push_back({"6c", one.cause, [&scene, one] { return scene.MatrixA(one.way); }});
  }
  return mistakes;
}

struct WeightMistake {
  std::string cause;  // "" if it is right
  decltype(FactorScene::Way::weight_b) of;
};

inline std::vector<WeightMistake> WeightsInB() {
  return {
      {"", nullptr},
      {"the loss is forgotten: ρ' is missing",
       [](const Edge& edge, double, const MatXX&) { return MatXX(edge.Information()); }},
      {"the loss acts twice",
       [](const Edge& edge, double drho, const MatXX&) { return MatXX(drho * drho * edge.Information()); }},
      {"W_ρ is for A; b takes ρ'W", [](const Edge&, double, const MatXX& W_rho) { return W_rho; }},
      {"W_ρ is for A; b takes ρ'W", [](const Edge&, double drho, const MatXX& W_rho) { return MatXX(drho * W_rho); }},
      {"W is missing: b takes ρ'Wr",
       [](const Edge&, double drho, const MatXX& W) { return MatXX(drho * MatXX::Identity(W.rows(), W.cols())); }}};
}

inline std::vector<Mistake> MistakesInB(const FactorScene& scene) {
  using Way = FactorScene::Way;
  std::vector<Mistake> mistakes{
      {"6c", "nothing is written to b_", [&scene] { return MatXX(0.0 * scene.VectorB({})); }}};
  for (const double sign : {1.0, -1.0}) {
    for (const auto& weight : WeightsInB()) {
      for (const bool last_only : {false, true}) {
        for (const double inner : {0.0, 1.0}) {
          std::string cause = weight.cause;
          if (cause.empty() && sign < 0.0) cause = "the sign: VINS' b is +Σ ρ'JᵀWr, that of A Δx = −b";
          if (cause.empty() && last_only) cause = "= stands where += is meant: only the last residual's share is left";
          if (cause.empty() && inner > 0.0) cause = "b_ is written in the loop over j too: vertex i has one share";
          if (cause.empty()) continue;
          Way way;
          way.weight_b = weight.of;
          way.last_only = last_only;
          way.with_each_j = inner;
          mistakes.push_back({"6c", cause, [=, &scene] { return MatXX(sign * scene.VectorB(way)); }});
        }
      }
    }
  }
  Way of_i, of_j;
  of_i.with_each_j = of_j.with_each_i = 1.0;
  for (const auto& [way, times] : {std::pair{of_i, -1.0}, std::pair{of_j, 0.0}, std::pair{of_j, 1.0}}) {
    mistakes.push_back({"6c", "b_ is written in the loop over j: vertex i has one share",
                        [&scene, w = way, t = times] { return MatXX(scene.VectorB(w) + t * scene.VectorB({})); }});
  }
  return mistakes;
}

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
  double LargestEigenvalue() const { return DecomposeSymmetric(A.topLeftCorner(m, m)).S.maxCoeff(); }
  MatXX Arr() const { return A.bottomRightCorner(n(), n()); }
  MatXX WithCorners(const MatXX& A_rm, const MatXX& A_mr) const { return Arr() - A_rm * mm_pinv * A_mr; }
  MatXX Schur(const MatXX& middle, double sign = -1.0) const {
    return A.bottomRightCorner(n(), n()) + sign * A.bottomLeftCorner(n(), m) * middle * A.topRightCorner(m, n());
  }
  VecX Reduced(const MatXX& middle, double sign = -1.0) const {
    return b.tail(n()) + sign * A.bottomLeftCorner(n(), m) * (middle * b.head(m));
  }
  std::vector<Mistake> Mistakes() const {
    std::vector<Mistake> mistakes = FormulaMistakes();
    for (const Mistake& mistake : CornerMistakes()) mistakes.push_back(mistake);
    return mistakes;
  }
  std::vector<Mistake> FormulaMistakes() const {
    const MatXX A_mm = A.topLeftCorner(m, m);
    return {
        {"6d", "nothing is subtracted: this is A_rr", [this] { return MatXX(A.bottomRightCorner(n(), n())); }},
        {"6d", "the sign: A_rm A_mm⁺ A_mr is added, not subtracted", [this] { return Schur(mm_pinv, 1.0); }},
        {"6d", "A_mm stands where A_mm⁺ is meant", [=] { return Schur(A_mm); }},
        {"6d", "A_mm⁺ is missing: this is A_rr − A_rm A_mr", [this] { return Schur(MatXX::Identity(m, m)); }},
        {"6d", "the eigenvalues up to kEps were inverted too: their S⁺ is 0", [this] { return Schur(Pinv(1e-300)); }},
        {"6d", "the eigenvalues are cut relative to the largest one: kEps itself is the limit",
         [this] { return Schur(Pinv(1e-8 * LargestEigenvalue())); }},
        {"6d", "the eigenvalues are cut relative to the largest one: kEps itself is the limit",
         [this] { return Schur(Pinv(1e-16 * LargestEigenvalue())); }},
        {"6d", "the eigenvalues are cut at another limit than kEps", [this] { return Schur(Pinv(1e-4)); }},
        {"6d", "the eigenvalues are cut at another limit than kEps", [this] { return Schur(Pinv(1e-6)); }},
        {"6d", "the eigenvalues are cut at another limit than kEps", [this] { return Schur(Pinv(1e-9)); }},
        {"6d", "A_rr is missing: this is −A_rm A_mm⁺ A_mr", [this] { return MatXX(Schur(mm_pinv) - Arr()); }},
        {"6d", "A_rr is missing: this is A_rm A_mm⁺ A_mr", [this] { return MatXX(Arr() - Schur(mm_pinv)); }},
        {"6d", "A_mm⁺ acts twice", [this] { return Schur(mm_pinv * mm_pinv); }},
        {"6d", "only the diagonal of A_mm is inverted",
         [=] { return Schur(A_mm.diagonal().cwiseInverse().asDiagonal()); }},
        {"6d", "the eigenvalues above kEps were set to 0, not those up to it",
         [=] { return Schur(Pinv(1e-300) - mm_pinv); }},
        {"6d", "the roots of 1/S stand in A_mm⁺: there S⁺ is 1/S itself",
         [this] {
           const SymmetricEigen mm = DecomposeSymmetric(A.topLeftCorner(m, m));
           const VecX root = (mm.S.array() > 1e-8).select(mm.S.cwiseInverse().cwiseAbs().cwiseSqrt(), 0.0);
           return Schur(mm.V * root.asDiagonal() * mm.V.transpose());
         }},
        {"6d", "Vᵀ S⁺ V instead of V S⁺ Vᵀ", [this] {
           const SymmetricEigen mm = DecomposeSymmetric(A.topLeftCorner(m, m));
           const VecX S = (mm.S.array() > 1e-8).select(mm.S.cwiseInverse(), 0.0);
           return Schur(mm.V.transpose() * S.asDiagonal() * mm.V);
         }}};
  }
  /// One corner of A stands where another is meant.
  std::vector<Mistake> CornerMistakes() const {
    const std::string
        rm = "A_rm is the wrong corner: it is the lower left one, n_ rows and m_ columns",
        mr = "A_mr is the wrong corner: it is the upper right one, m_ rows and n_ columns",
        both = "A_rm and A_mr are the wrong corners: the lower left and the upper right one",
        rr = "A_rr is the wrong corner: the dropped rows stand first, A_rr is the lower right corner, n_ × n_",
        all = "the corners are exchanged: the dropped rows stand first, A_rr is the lower right corner";
    const auto with = [this](const MatXX& A_rm, const MatXX& A_mr) { return [=] { return WithCorners(A_rm, A_mr); }; };
    const int n = this->n();
    return {{"6d", rr, [=] { return n <= A.rows() ? MatXX(A.topLeftCorner(n, n) - Arr() + Schur(mm_pinv)) : A; }},
            {"6d", rm, with(A.topLeftCorner(n, m), A.topRightCorner(m, n))},
            {"6d", rm, with(A.topRightCorner(n, m), A.topRightCorner(m, n))},
            {"6d", rm, with(A.bottomRightCorner(n, m), A.topRightCorner(m, n))},
            {"6d", both, with(A.topRightCorner(n, m), A.bottomLeftCorner(m, n))},
            {"6d", mr, with(A.bottomLeftCorner(n, m), A.topLeftCorner(m, n))},
            {"6d", mr, with(A.bottomLeftCorner(n, m), A.bottomLeftCorner(m, n))},
            {"6d", mr, with(A.bottomLeftCorner(n, m), A.bottomRightCorner(m, n))},
            {"6d", all, [=] { return Exchanged(mm_pinv); }},
            {"6d", all,
             [=] { return n == m ? Exchanged(A.bottomRightCorner(n, n).inverse()) : MatXX(MatXX::Zero(n, n)); }}};
  }
  // The other corner in A_rr's place, and in A_rm's and A_mr's.
  MatXX Exchanged(const MatXX& pinv) const {
    return A.topLeftCorner(n(), n()) - A.topRightCorner(n(), m) * pinv * A.bottomLeftCorner(m, n());
  }
  std::vector<Mistake> MistakesInB() const {
    return {
        {"6d", "b is not reduced: this is b_r", [this] { return VecX(b.tail(n())); }},
        {"6d", "the sign: A_rm A_mm⁺ b_m is added, not subtracted", [this] { return Reduced(mm_pinv, 1.0); }},
        {"6d", "A_mm⁺ is missing: this is b_r − A_rm b_m", [this] { return Reduced(MatXX::Identity(m, m)); }},
        {"6d", "A_mm stands where A_mm⁺ is meant", [this] { return Reduced(A.topLeftCorner(m, m)); }},
        {"6d", "A_mm⁺ acts twice", [this] { return Reduced(mm_pinv * mm_pinv); }},
        {"6d", "the eigenvalues up to kEps were inverted too: their S⁺ is 0", [this] { return Reduced(Pinv(1e-300)); }},
        {"6d", "b_r is missing: this is −A_rm A_mm⁺ b_m", [this] { return VecX(Reduced(mm_pinv) - b.tail(n())); }},
        {"6d", "b_r is missing: this is A_rm A_mm⁺ b_m", [this] { return VecX(b.tail(n()) - Reduced(mm_pinv)); }},
        {"6d", "b_r is the wrong part of b_: the dropped rows stand first, b_r is its tail",
         [this] { return VecX(b.head(n()) - b.tail(n()) + Reduced(mm_pinv)); }},
        {"6d", "b_m is the wrong part of b_: the dropped rows stand first, b_m is its head",
         [this] { return VecX(b.tail(n()) - A.bottomLeftCorner(n(), m) * mm_pinv * b.tail(m)); }},
        {"6d", "b_r and b_m are exchanged: b_m is the head of b_, b_r its tail",
         [this] { return VecX(b.head(n()) - A.bottomLeftCorner(n(), m) * mm_pinv * b.tail(m)); }},
        {"6d", "b_m is missing, its place holds b_r",
         [this] {
           return n() == m ? VecX(b.tail(n()) - A.bottomLeftCorner(n(), m) * mm_pinv * b.tail(n())) : VecX(b);
         }},
        {"6d", "head and tail of b_ are exchanged: b_m stands first",
         [this] { return n() == m ? VecX(b.head(n()) - A.bottomLeftCorner(n(), m) * mm_pinv * b.tail(m)) : VecX(b); }}};
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
  static MatXX Root(const MatXX& diagonal) { return diagonal.cwiseSqrt(); }
  MatXX RightJ() const { return Root(S) * V.transpose(); }

  std::vector<Mistake> Mistakes() const {
    const auto gram = [](const MatXX& J) { return [J] { return MatXX(J.transpose() * J); }; };
    return {{"6e", "V stands where Vᵀ is meant: J = S^½ Vᵀ", gram(Root(S) * V)},
            {"6e", "J is transposed: this is V S^½", gram(V * Root(S))},
            {"6e", "S stands where its root is meant", gram(S * V.transpose())},
            {"6e", "S^½ is missing: J = S^½ Vᵀ", gram(V.transpose())},
            {"6e", "S^-½ stands where S^½ is meant", gram(Root(S_pinv) * V.transpose())},
            {"6e", "eigenvalues up to kEps count in J: there S^½ is 0", gram(Root(S_uncut) * V.transpose())},
            {"6e", "the eigenvalues are cut relative to the largest one: kEps itself is the limit",
             gram(Root(CutAt(1e-8 * S.maxCoeff())) * V.transpose())},
            {"6e", "the eigenvalues are cut at another limit than kEps", gram(Root(CutAt(1e-6)) * V.transpose())},
            {"6e", "the eigenvalues are cut at another limit than kEps", gram(Root(CutAt(1e-9)) * V.transpose())},
            {"6e", "the eigenvalues are cut at another limit than kEps", gram(Root(CutAt(1e-12)) * V.transpose())},
            {"6e", "S stands where its root is meant, and V where Vᵀ is", gram(S * V)},
            {"6e", "J is A_r itself", gram(A)}};
  }
  /// As answers of Jᵀr₀.
  std::vector<Mistake> MistakesInR0() const {
    const MatXX Jt = RightJ().transpose();
    const auto r0 = [=](const MatXX& r) { return [Jt, r] { return MatXX(Jt * r); }; };
    return {{"6e", "the sign: VINS' b is +JᵀWr, so r₀ = +S^-½ Vᵀ b_r", r0(-Root(S_pinv) * V.transpose() * b)},
            {"6e", "r₀ is zero: it was not set", r0(VecX::Zero(b.size()))},
            {"6e", "r₀ is b_r itself", r0(b)},
            {"6e", "S^-½ is missing: this is Vᵀ b_r", r0(V.transpose() * b)},
            {"6e", "S^½ stands where S^-½ is meant", r0(Root(S) * V.transpose() * b)},
            {"6e", "1/S stands where its root is meant", r0(S_pinv * V.transpose() * b)},
            {"6e", "S stands where S^-½ is meant", r0(S * V.transpose() * b)},
            {"6e", "the sign, and S^½ stands where S^-½ is meant", r0(-Root(S) * V.transpose() * b)},
            {"6e", "the sign, and S^-½ is missing: this is −Vᵀ b_r", r0(-V.transpose() * b)},
            {"6e", "the sign, and r₀ is b_r itself", r0(-b)},
            {"6e", "V is missing: this is S^-½ b_r", r0(Root(S_pinv) * b)},
            {"6e", "V stands where Vᵀ is meant: r₀ = S^-½ Vᵀ b_r", r0(Root(S_pinv) * V * b)}};
  }
};

}  // namespace ch5::homework::stage_6
