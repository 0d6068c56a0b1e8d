#pragma once
/// What typical mistakes in MarginalizationInfo's ConstructA (6c), SchurComplement (6d) and Factor (6e) give.

#include <functional>
#include <string>
#include <vector>

#include "ch5_backend/marginalize/square_root.h"
#include "ch5_homework/judge/diagnosis.h"
#include "ch5_homework/judge/stage_6_scene.h"

namespace ch5::homework::stage_6 {

// ---- 6c ConstructA --------------------------------------------------------------------------------------------------

struct WayMistake {
  Text cause;
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
  return {{Text("formula.nothing_written", {{"matrix", Word("A_")}}), times(0, 0, 0)},
          {"6.loss_forgotten_in_A",
           weight([](const Edge& edge, double, const MatXX&) { return MatXX(edge.Information()); })},
          {"6.first_order_loss",
           weight([](const Edge& edge, double drho, const MatXX&) { return MatXX(drho * edge.Information()); })},
          {"6.loss_acts_twice_in_A",
           weight([](const Edge&, double drho, const MatXX& W_rho) { return MatXX(drho * W_rho); })},
          {"6.W_missing_in_A", weight([](const Edge&, double, const MatXX& W_rho) {
             return MatXX(MatXX::Identity(W_rho.rows(), W_rho.cols()));
           })},
          {"6.last_residual_left", Changed([](Way* way) { way->last_only = true; })},
          {"6.mirrored_block_missing", times(1, 1, 0)},
          {"6.block_i_j_missing_only", times(1, 0, 1)},
          {"6.only_diagonal_blocks_arrive", times(1, 0, 0)},
          {"6.mirrored_block_not_transposed", Changed([](Way* way) { way->transpose = false; })},
          {"6.places_exchanged", Changed([](Way* way) { way->exchanged = true; })},
          {"6.idx_of_i_for_j", Changed([](Way* way) { way->idx_of_i = true; })},
          {"6.J_of_i_for_j", Changed([](Way* way) { way->J_of_i = true; })},
          {"6.diagonal_blocks_doubled", times(2, 1, 1)},
          {"6.off_diagonal_added_twice", times(1, 2, 2)},
          {"6.diagonal_blocks_missing", times(0, 1, 1)},
          {"6.break_at_fixed_vertex", Changed([](Way* way) { way->stops_at_fixed = true; })},
          {"formula.mirror_subtracted", times(1, 1, -1)},
          {"formula.mirror_added_twice", times(1, 1, 2)},
          {"6.block_i_j_added_twice", times(1, 2, 1)},
          {"6.sign_of_A", times(-1, -1, -1)}};
}

inline std::vector<Mistake> MistakesInA(const FactorScene& scene) {
  std::vector<Mistake> mistakes;
  for (const auto& one : WrongWaysToA()) {
    mistakes.push_back({"6c", one.cause, [&scene, one] { return scene.MatrixA(one.way); }});
  }
  return mistakes;
}

struct WeightMistake {
  Text cause;  // empty if it is right
  decltype(FactorScene::Way::weight_b) of;
};

inline std::vector<WeightMistake> WeightsInB() {
  const Text W_twice = {"formula.acts_twice", {{"this", Word("W")}, {"that", Word("Wr")}}};
  return {{{}, nullptr},
          {"6.loss_forgotten_in_b", [](const Edge& edge, double, const MatXX&) { return MatXX(edge.Information()); }},
          {"6.loss_acts_twice_in_b",
           [](const Edge& edge, double drho, const MatXX&) { return MatXX(drho * drho * edge.Information()); }},
          {"6.W_rho_in_b", [](const Edge&, double, const MatXX& W_rho) { return W_rho; }},
          {"6.W_rho_in_b", [](const Edge&, double drho, const MatXX& W_rho) { return MatXX(drho * W_rho); }},
          {W_twice, [](const Edge& edge, double drho,
                       const MatXX&) { return MatXX(drho * edge.Information() * edge.Information()); }},
          {W_twice, [](const Edge& edge, double, const MatXX& W) { return MatXX(W * edge.Information()); }},
          {W_twice, [](const Edge& edge, double drho, const MatXX& W) { return MatXX(drho * W * edge.Information()); }},
          {"6.W_missing_in_b",
           [](const Edge&, double drho, const MatXX& W) { return MatXX(drho * MatXX::Identity(W.rows(), W.cols())); }}};
}

inline std::vector<Mistake> MistakesInB(const FactorScene& scene) {
  using Way = FactorScene::Way;
  std::vector<Mistake> mistakes{{"6c", Text("formula.nothing_written", {{"matrix", Word("b_")}}),
                                 [&scene] { return MatXX(0.0 * scene.VectorB({})); }}};
  for (const double sign : {1.0, -1.0}) {
    for (const auto& weight : WeightsInB()) {
      for (const bool last_only : {false, true}) {
        for (const double inner : {0.0, 1.0}) {
          Text cause = weight.cause;
          if (cause.empty() && sign < 0.0) cause = "6.sign_of_b";
          if (cause.empty() && last_only) cause = "6.last_residual_left";
          if (cause.empty() && inner > 0.0) cause = "6.b_in_inner_loop_too";
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
    mistakes.push_back({"6c", "6.b_in_inner_loop",
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
        {"6d", "6.nothing_subtracted", [this] { return MatXX(A.bottomRightCorner(n(), n())); }},
        {"6d", Text("formula.as_large_as", {{"matrix", Word("A_")}}), [this] { return A; }},
        {"6d", Text("formula.sign_added", {{"term", Word("A_rm A_mm⁺ A_mr")}}), [this] { return Schur(mm_pinv, 1.0); }},
        {"6d", Text("formula.stands_for", {{"this", Word("A_mm")}, {"that", Word("A_mm⁺")}}),
         [=] { return Schur(A_mm); }},
        {"6d", Text("formula.missing_leaves", {{"this", Word("A_mm⁺")}, {"that", Word("A_rr − A_rm A_mr")}}),
         [this] { return Schur(MatXX::Identity(m, m)); }},
        {"6d", "6.eigenvalues_up_kEps_inverted", [this] { return Schur(Pinv(1e-300)); }},
        {"6d", "6.cut_relative_to_largest", [this] { return Schur(Pinv(1e-8 * LargestEigenvalue())); }},
        {"6d", "6.cut_at_another_limit", [this] { return Schur(Pinv(1e-4)); }},
        {"6d", "6.cut_at_another_limit", [this] { return Schur(Pinv(1e-6)); }},
        {"6d", Text("formula.missing_leaves", {{"this", Word("A_rr")}, {"that", Word("−A_rm A_mm⁺ A_mr")}}),
         [this] { return MatXX(Schur(mm_pinv) - Arr()); }},
        {"6d", Text("formula.missing_leaves", {{"this", Word("A_rr")}, {"that", Word("A_rm A_mm⁺ A_mr")}}),
         [this] { return MatXX(Arr() - Schur(mm_pinv)); }},
        {"6d", "6.A_mmpinv_acts_twice", [this] { return Schur(mm_pinv * mm_pinv); }},
        {"6d", "6.only_diagonal_A_mm_inverted", [=] { return Schur(A_mm.diagonal().cwiseInverse().asDiagonal()); }},
        {"6d", "6.eigenvalues_above_eps_cut", [=] { return Schur(Pinv(1e-300) - mm_pinv); }},
        {"6d", "6.root_of_pinv",
         [this] {
           const SymmetricEigen mm = DecomposeSymmetric(A.topLeftCorner(m, m));
           const VecX root = (mm.S.array() > 1e-8).select(mm.S.cwiseInverse().cwiseAbs().cwiseSqrt(), 0.0);
           return Schur(mm.V * root.asDiagonal() * mm.V.transpose());
         }},
        {"6d", "6.VT_missing_in_pinv",
         [this] {
           const SymmetricEigen mm = DecomposeSymmetric(A.topLeftCorner(m, m));
           const VecX S = (mm.S.array() > 1e-8).select(mm.S.cwiseInverse(), 0.0);
           return Schur(mm.V * S.asDiagonal() * mm.V);
         }},
        {"6d", "6.V_transposed_in_pinv", [this] {
           const SymmetricEigen mm = DecomposeSymmetric(A.topLeftCorner(m, m));
           const VecX S = (mm.S.array() > 1e-8).select(mm.S.cwiseInverse(), 0.0);
           return Schur(mm.V.transpose() * S.asDiagonal() * mm.V);
         }}};
  }
  /// One corner of A stands where another is meant.
  std::vector<Mistake> CornerMistakes() const {
    const Text rm = "6.A_rm_wrong_corner", mr = "6.A_mr_wrong_corner", both = "6.A_rm_A_mr_wrong_corners",
               rr = "6.A_rr_wrong_corner", all = "6.corners_exchanged";
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
    return {{"6d", "6.b_not_reduced", [this] { return VecX(b.tail(n())); }},
            {"6d", Text("formula.as_large_as", {{"matrix", Word("b_")}}), [this] { return b; }},
            {"6d", Text("formula.sign_added", {{"term", Word("A_rm A_mm⁺ b_m")}}),
             [this] { return Reduced(mm_pinv, 1.0); }},
            {"6d", Text("formula.missing_leaves", {{"this", Word("A_mm⁺")}, {"that", Word("b_r − A_rm b_m")}}),
             [this] { return Reduced(MatXX::Identity(m, m)); }},
            {"6d", Text("formula.stands_for", {{"this", Word("A_mm")}, {"that", Word("A_mm⁺")}}),
             [this] { return Reduced(A.topLeftCorner(m, m)); }},
            {"6d", "6.A_mmpinv_acts_twice", [this] { return Reduced(mm_pinv * mm_pinv); }},
            {"6d", "6.eigenvalues_up_kEps_inverted", [this] { return Reduced(Pinv(1e-300)); }},
            {"6d", Text("formula.missing_leaves", {{"this", Word("b_r")}, {"that", Word("−A_rm A_mm⁺ b_m")}}),
             [this] { return VecX(Reduced(mm_pinv) - b.tail(n())); }},
            {"6d", Text("formula.missing_leaves", {{"this", Word("b_r")}, {"that", Word("A_rm A_mm⁺ b_m")}}),
             [this] { return VecX(b.tail(n()) - Reduced(mm_pinv)); }},
            {"6d", "6.b_r_wrong_part_b", [this] { return VecX(b.head(n()) - b.tail(n()) + Reduced(mm_pinv)); }},
            {"6d", "6.b_m_wrong_part_b",
             [this] { return VecX(b.tail(n()) - A.bottomLeftCorner(n(), m) * mm_pinv * b.tail(m)); }},
            {"6d", "6.b_r_b_m_exchanged",
             [this] { return VecX(b.head(n()) - A.bottomLeftCorner(n(), m) * mm_pinv * b.tail(m)); }}};
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
    return {
        {"6e",
         Text("formula.stands_for_in", {{"this", Word("V")}, {"that", Word("Vᵀ")}, {"formula", Word("J = S^½ Vᵀ")}}),
         gram(Root(S) * V)},
        {"6e", "6.J_transposed", gram(V * Root(S))},
        {"6e", Text("formula.root_meant", {{"this", Word("S")}}), gram(S * V.transpose())},
        {"6e", Text("formula.missing_from", {{"this", Word("S^½")}, {"formula", Word("J = S^½ Vᵀ")}}),
         gram(V.transpose())},
        {"6e", Text("formula.stands_for", {{"this", Word("S^-½")}, {"that", Word("S^½")}}),
         gram(Root(S_pinv) * V.transpose())},
        {"6e", "6.eigenvalues_up_kEps_count_J", gram(Root(S_uncut) * V.transpose())},
        {"6e", "6.cut_at_another_limit", gram(Root(CutAt(1e-6)) * V.transpose())},
        {"6e", "6.S_for_root", gram(S * V)},
        {"6e", "6.J_A_r_itself", gram(A)}};
  }
  /// As answers of Jᵀr₀.
  std::vector<Mistake> MistakesInR0() const {
    const MatXX Jt = RightJ().transpose();
    const auto r0 = [=](const MatXX& r) { return [Jt, r] { return MatXX(Jt * r); }; };
    return {
        {"6e", "6.sign_of_r0", r0(-Root(S_pinv) * V.transpose() * b)},
        {"6e", "6.r0_zero", r0(VecX::Zero(b.size()))},
        {"6e", "6.r0_b_r_itself", r0(b)},
        {"6e", Text("formula.missing_leaves", {{"this", Word("S^-½")}, {"that", Word("Vᵀ b_r")}}),
         r0(V.transpose() * b)},
        {"6e", Text("formula.stands_for", {{"this", Word("S^½")}, {"that", Word("S^-½")}}),
         r0(Root(S) * V.transpose() * b)},
        {"6e", Text("formula.root_meant", {{"this", Word("1/S")}}), r0(S_pinv * V.transpose() * b)},
        {"6e", Text("formula.stands_for", {{"this", Word("S")}, {"that", Word("S^-½")}}), r0(S * V.transpose() * b)},
        {"6e", Text("6.sign_and_stands_for", {{"this", Word("S^½")}, {"that", Word("S^-½")}}),
         r0(-Root(S) * V.transpose() * b)},
        {"6e", "6.sign_and_S_isqrt_missing", r0(-V.transpose() * b)},
        {"6e", "6.sign_r0_b_r_itself", r0(-b)},
        {"6e", Text("formula.missing_leaves", {{"this", Word("V")}, {"that", Word("S^-½ b_r")}}), r0(Root(S_pinv) * b)},
        {"6e",
         Text("formula.stands_for_in",
              {{"this", Word("V")}, {"that", Word("Vᵀ")}, {"formula", Word("r₀ = S^-½ Vᵀ b_r")}}),
         r0(Root(S_pinv) * V * b)}};
  }
};

}  // namespace ch5::homework::stage_6
