#pragma once
/// What typical mistakes in OKVIS's InsertBlock (5.1), SchurComplement (5.2) and UpdateErrorComputation (5.3) give.

#include <string>
#include <vector>

#include "ch5_backend/marginalize/square_root.h"
#include "ch5_backend/math/psd.h"
#include "ch5_homework/judge/diagnosis.h"
#include "ch5_homework/judge/mistakes/elimination.h"
#include "ch5_homework/judge/mistakes/formula.h"
#include "ch5_homework/judge/oracle.h"

namespace ch5::homework::stage_5 {

/// H and b₀ before, and where the new block goes.
struct Insertion {
  MatXX H;
  VecX b0;
  int idx, dim;

  int Tail() const { return static_cast<int>(H.rows()) - idx; }

  /// What stands in one of the four parts: nothing, the right block of H at its place or at another, or another block.
  enum Part { kRight, kMissing, kNotMoved, kWrongSource };
  MatXX Opened(Part H_00 = kRight, Part H_01 = kRight, Part H_10 = kRight, Part H_11 = kRight) const {
    const int tail = Tail(), end = idx + dim;
    MatXX opened = MatXX::Zero(H.rows() + dim, H.rows() + dim);
    const auto copy = [&](Part part, int row, int column, int rows, int columns, int moved_row, int moved_column,
                          int other_row, int other_column) {
      if (part == kMissing) return;
      const bool fits = other_row + rows <= H.rows() && other_column + columns <= H.cols();
      const MatXX source = part == kWrongSource && fits ? H.block(other_row, other_column, rows, columns)
                                                        : H.block(row, column, rows, columns);
      if (part == kNotMoved) {
        opened.block(row, column, rows, columns) = source;
      } else {
        opened.block(moved_row, moved_column, rows, columns) = source;
      }
    };
    copy(H_00, 0, 0, idx, idx, 0, 0, 0, 0);
    copy(H_01, 0, idx, idx, tail, 0, end, idx, 0);
    copy(H_10, idx, 0, tail, idx, end, 0, 0, idx);
    copy(H_11, idx, idx, tail, tail, end, end, 0, 0);
    return opened;
  }

  std::vector<Mistake> InH() const {
    const auto is = [this](Part a, Part b, Part c, Part d) { return Opened(a, b, c, d); };
    const Part no = kMissing, ok = kRight;
    std::vector<Mistake> mistakes{{"5.1", "5.nothing_copied", is(no, no, no, no)},
                                  {"5.1", "5.H_as_before", H},
                                  {"5.1", "5.H_00_alone_copied", is(ok, no, no, no)},
                                  {"5.1", "5.nothing_made_room", is(ok, kNotMoved, kNotMoved, kNotMoved)},
                                  {"5.1", "5.H_01_H_01T_missing", is(ok, no, no, ok)},
                                  {"5.1", "5.H_01_H_01T_exchanged", is(ok, kWrongSource, kWrongSource, ok)}};
    const std::vector<Text> of_00{{}, "5.H_00_dense_part_missing"},
        of_01{{}, "5.H_01_right_new_columns_missing", "5.H_01_made_no_room", "5.H_01_holds_transpose"},
        of_10{{}, "5.H_01T_below_new_rows_missing", "5.H_01T_made_no_room", "5.H_01T_holds_H_01"},
        of_11{{}, "5.tails_corner_H_11_missing", "5.tails_corner_made_no_room", "5.tails_corner_holds_H_00"};
    for (size_t a = 0; a < of_00.size(); ++a) {
      for (size_t b = 0; b < of_01.size(); ++b) {
        for (size_t c = 0; c < of_10.size(); ++c) {
          for (size_t d = 0; d < of_11.size(); ++d) {
            const Text& cause = a ? of_00[a] : (b ? of_01[b] : (c ? of_10[c] : of_11[d]));
            if (!cause.empty()) mistakes.push_back({"5.1", cause, is(Part(a), Part(b), Part(c), Part(d))});
          }
        }
      }
    }
    MatXX late = MatXX::Zero(H.rows() + dim, H.cols() + dim), known = Opened();
    const auto moved = [this](Eigen::Index row) { return row <= idx ? row : row + dim; };
    for (Eigen::Index i = 0; i < H.rows(); ++i) {
      for (Eigen::Index j = 0; j < H.cols(); ++j) late(moved(i), moved(j)) = H(i, j);
    }
    mistakes.push_back({"5.1", "5.row_idx_made_no_room", late});
    known.block(idx, idx, dim, dim).setIdentity();
    mistakes.push_back({"5.1", "5.new_block_holds_identity", known});
    return mistakes;
  }

  VecX OpenedB() const {
    VecX b = VecX::Zero(b0.size() + dim);
    b.head(idx) = b0.head(idx);
    b.tail(Tail()) = b0.tail(Tail());
    return b;
  }

  std::vector<Mistake> InB() const {
    const auto changed = [this](int at, const VecX& part) {
      VecX b = VecX::Zero(b0.size() + dim);
      b.head(idx) = b0.head(idx);
      b.segment(at, part.size()) = part;
      return b;
    };
    VecX without_beginning = OpenedB();
    without_beginning.head(idx).setZero();
    return {{"5.1", "5.b0_not_copied", VecX::Zero(OpenedB().size())},
            {"5.1", "5.tail_b0_missing", changed(0, b0.head(idx))},
            {"5.1", "5.beginning_b0_missing", without_beginning},
            {"5.1", "5.b0_made_no_room", changed(idx, b0.tail(Tail()))},
            {"5.1", "5.b0s_tail_holds_beginning", Tail() <= idx ? changed(idx + dim, b0.head(Tail())) : OpenedB()}};
  }
};

struct SchurCase {
  MatXX V, W, U, V_inverse;
  VecX b_b, b_a;

  /// @param unit  of what goes: the smaller, the smaller are V, W and b_b
  SchurCase(int stays, int goes, double unit, Random* random)
      : V(unit * unit * RandomPositiveDefinite(goes, random)),
        W(unit * RandomMatrix(stays, goes, random)),
        b_b(unit * RandomMatrix(goes, 1, random)),
        b_a(RandomMatrix(stays, 1, random)) {
    V_inverse = PseudoInversePsd(V);
    U = RandomPositiveDefinite(stays, random) + W * V_inverse * W.transpose();
  }

  /// With something in place of V⁺.
  MatXX Schur(const MatXX& middle) const { return U - W * middle * W.transpose(); }
  VecX Reduced(const MatXX& middle) const { return b_a - W * middle * b_b; }

  std::vector<Mistake> InU() const {
    const MatXX S = PseudoInverseSquareRoot(V), M = W * S, subtracted = U - Schur(V_inverse);
    const MatXX upper = subtracted.triangularView<Eigen::Upper>(), lower = subtracted.triangularView<Eigen::Lower>();
    std::vector<Mistake> mistakes{{"5.2", "5.only_one_triangle_U_changed", U - upper},
                                  {"5.2", "5.only_one_triangle_U_changed", U - lower}};
    const auto with = [this](const MatXX& middle) { return Schur(middle); };
    Append(CutMistakes("5.5 5.2", "V", V, with), &mistakes);
    Append(EliminationMistakes({"5.2", "5.5 5.2", "U", "M Mᵀ", "V⁺", "V"}, U, V, V_inverse, with), &mistakes);
    const MatXX L_inverse = MatXX(V.llt().matrixL()).inverse();
    mistakes.push_back({"5.5 5.2", StandsFor("L⁻¹", "L⁻ᵀ", "V⁻¹ = L⁻ᵀ L⁻¹"), Schur(L_inverse * L_inverse.transpose())});
    if (S.rows() == S.cols()) {
      mistakes.push_back({"5.5 5.2", "5.V_inv_sqrt_not_symmetric", Schur(S.transpose() * S)});
      mistakes.push_back({"5.5 5.2", "5.only_one_root", Schur(S)});
      mistakes.push_back({"5.5 5.2", "5.only_one_root", Schur(S.transpose())});
    }
    mistakes.push_back({"5.2", StandsFor("V", "V_inv_sqrt"), Schur(V * V)});
    if (M.rows() == M.cols()) {
      mistakes.push_back({"5.2", "5.MTM_for_MMT", U - M.transpose() * M});
      mistakes.push_back({"5.2", "5.factors_of_M_exchanged", U - S * W.transpose() * W * S.transpose()});
    }
    return mistakes;
  }
  std::vector<Mistake> InB() const {
    const MatXX S = PseudoInverseSquareRoot(V);
    std::vector<Mistake> mistakes{{"5.2", StandsFor("b_a", "b_b"), b_a - W * V_inverse * W.transpose() * b_a}};
    Append(EliminationMistakes({"5.2", "5.5 5.2", "b_a", "M V_inv_sqrtᵀ b_b", "V⁺", "V"}, b_a, V, V_inverse,
                               [this](const MatXX& middle) { return Reduced(middle); }),
           &mistakes);
    if (S.rows() == S.cols()) {
      mistakes.push_back({"5.2", "5.root_acts_once", Reduced(S)});
      mistakes.push_back({"5.2", "5.M_missing", Reduced(S.transpose())});
      mistakes.push_back({"5.2", "5.transpose_of_root_missing", Reduced(S * S)});
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
    Text cause;  // empty if it is right
    MatXX A;
  };
  MatXX I() const { return MatXX::Identity(H.rows(), H.cols()); }

  /// As answers of JᵀJ, whatever rows J has.
  std::vector<Mistake> Mistakes() const {
    const auto gram = [](const MatXX& J) { return MatXX(J.transpose() * J); };
    MatXX S_first = S_sqrt;  // as many of the first eigenvalues as are not zero
    S_first.diagonal().tail((S_sqrt.diagonal().array() == 0.0).count()).setZero();
    std::vector<Mistake> mistakes{{"5.3", "5.transpose_of_J_missing", gram(P * U * S_sqrt)},
                                  {"5.3", StandsFor("U", "Uᵀ", "J = S^½ Uᵀ P"), gram(S_sqrt * U * P)},
                                  {"5.3", "5.P_S_sqrt_exchanged_places", gram(P * U.transpose() * S_sqrt)},
                                  {"5.3", "5.J_H_itself", gram(H)},
                                  {"5.3", "5.P_on_the_rows", gram(P * S_sqrt * U.transpose())},
                                  {"5.3", "5.eigenvalues_ascend", gram(S_first * U.transpose() * P)},
                                  {"5.6 5.3", "5.diagonal_for_its_root", GramScaledBy(H.diagonal())},
                                  {"5.6 5.3", "5.no_scaling", GramScaledBy(VecX::Ones(H.rows()))}};
    MatXX S_cut = S_sqrt;  // without the smallest eigenvalues
    for (Eigen::Index k = 0; k + 1 < S_cut.rows(); ++k) {
      S_cut(k, k) = 0.0;
      mistakes.push_back({"5.7 5.3", DirectionCut("H"), gram(S_cut * U.transpose() * P)});
    }
    for (const Factor& first : {Factor{{}, P},
                                {MissingFrom("P", "J = (P U S^½)ᵀ"), I()},
                                {StandsFor("P⁻¹", "P"), P_inverse},
                                {"5.root_of_P_drawn", MatXX(P.cwiseSqrt())},
                                {"5.P_stands_twice_J", MatXX(P * P)}}) {
      for (const Factor& last : {Factor{{}, S_sqrt},
                                 {RootMeant("S"), S},
                                 {RootTwice("S"), S_sqrt.cwiseSqrt()},
                                 {MissingFrom("S^½", "J = (P U S^½)ᵀ"), I()},
                                 {StandsFor("S^-½", "S^½"), S_pinv_sqrt}}) {
        const Text cause = first.cause.empty() ? last.cause : first.cause;
        if (!cause.empty()) mistakes.push_back({"5.3", cause, gram((first.A * U * last.A).transpose())});
      }
    }
    return mistakes;
  }
  /// JᵀJ with another P: H again, but for the eigenvalues that then count as zero.
  MatXX GramScaledBy(const VecX& other_p) const {
    const ScaledEigen eigen = DecomposeScaled(H, other_p.cwiseInverse());
    const MatXX J = eigen.S_sqrt.asDiagonal() * eigen.U.transpose() * other_p.asDiagonal();
    return J.transpose() * J;
  }
  /// As answers of Jᵀe₀.
  std::vector<Mistake> MistakesInE0() const {
    const MatXX Jt = P * U * S_sqrt;
    const auto e0 = [=](const MatXX& e) { return MatXX(Jt * e); };
    std::vector<Mistake> mistakes{{"5.3", "5.e0_zero", e0(VecX::Zero(b0.size()))},
                                  {"5.3", "5.e0_is_b0", e0(b0)},
                                  {"5.3", "5.e0_is_minus_b0", e0(-b0)},
                                  {"5.3", StandsFor("J", "(Jᵀ)⁺"), e0(-Jt.transpose() * b0)},
                                  {"5.3", StandsFor("Jᵀ", "(Jᵀ)⁺"), e0(-Jt * b0)},
                                  {"5.3", StandsFor("U", "Uᵀ"), e0(-S_pinv_sqrt * U * P_inverse * b0)},
                                  {"5.3", "5.JT_pinv_transposed", e0(-P_inverse * U * S_pinv_sqrt * b0)}};
    for (const Factor& first : {Factor{{}, S_pinv_sqrt},
                                {StandsFor("S^½", "S^-½"), S_sqrt},
                                {MissingIn("S^-½", "(Jᵀ)⁺ = S^-½ Uᵀ P⁻¹"), I()},
                                {StandsFor("S⁻¹", "S^-½"), MatXX(S_pinv_sqrt * S_pinv_sqrt)}}) {
      for (const Factor& last :
           {Factor{{}, P_inverse}, {StandsFor("P", "P⁻¹"), P}, {MissingIn("P⁻¹", "(Jᵀ)⁺ = S^-½ Uᵀ P⁻¹"), I()}}) {
        for (const Factor& sign : {Factor{{}, -I()}, {"5.sign_of_e0", I()}}) {
          const Text cause = first.cause.empty() ? (last.cause.empty() ? sign.cause : last.cause) : first.cause;
          if (!cause.empty()) mistakes.push_back({"5.3", cause, e0(first.A * U.transpose() * last.A * sign.A * b0)});
        }
      }
    }
    return mistakes;
  }
};

}  // namespace ch5::homework::stage_5
