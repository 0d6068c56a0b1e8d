#pragma once
/// What typical mistakes in PlainBlockSolver::Solve make of S and of the reduced right-hand side (7d), and of Δx (7e).

#include <algorithm>
#include <functional>
#include <string>
#include <vector>

#include "ch5_backend/dense/dense_solvers.h"
#include "ch5_backend/graph/ordering.h"
#include "ch5_backend/math/psd.h"
#include "ch5_backend/solve/normal_equations.h"
#include "ch5_homework/judge/diagnosis.h"
#include "ch5_homework/judge/mistakes/elimination.h"
#include "ch5_homework/judge/mistakes/formula.h"
#include "ch5_homework/judge/oracle.h"

namespace ch5::homework::stage_7 {

/// A damped system, whose poses remain and whose landmarks go.
struct Case : PartedSystem {
  MatXX H_ll_undamped;
  std::vector<int> dims, rows;    // of the poses
  std::vector<int> l_dims, l_at;  // of the landmarks, rows of H_ll

  Case(const System& system, const Ordering& ordering, double lambda, Damping damping)
      : PartedSystem(Damped(system.H, lambda, damping), system.b, ordering.dim_poses),
        H_ll_undamped(system.H.bottomRightCorner(A_mm.rows(), A_mm.cols())) {
    for (const auto& pose : ordering.poses) {
      dims.push_back(pose->LocalDimension());
      rows.push_back(pose->OrderingId());
    }
    for (const auto& landmark : ordering.landmarks) {
      l_dims.push_back(landmark->LocalDimension());
      l_at.push_back(landmark->OrderingId() - ordering.dim_poses);
    }
  }
  static MatXX Damped(MatXX H, double lambda, Damping damping) {
    for (int i = 0; i < H.rows(); ++i) H(i, i) += lambda * DampingEntry(damping, H(i, i));
    return H;
  }
  VecX Step(const VecX& of_landmarks) const {
    VecX x(b_r.size() + of_landmarks.size());
    x << StepOfPoses(), of_landmarks;
    return x;
  }
  VecX StepOfPoses() const {
    VecX x = VecX::Zero(b_r.size());
    if (x.size() > 0) SolveLdlt(Schur(), Reduced(), &x);
    return x;
  }

  // Blocks, by numbers.
  MatXX Pl(int i, int l) const { return A_rm.block(rows[i], l_at[l], dims[i], l_dims[l]); }
  MatXX Inverse(int l) const { return A_mm_inverse.block(l_at[l], l_at[l], l_dims[l], l_dims[l]); }
  VecX Bl(int l) const { return b_m.segment(l_at[l], l_dims[l]); }
  std::vector<int> Seeing(int l) const {
    std::vector<int> poses;
    for (size_t i = 0; i < dims.size(); ++i) {
      if (!Pl(static_cast<int>(i), l).isZero(0.0)) poses.push_back(static_cast<int>(i));
    }
    return poses;
  }
};

/// `with(i, j, l)` for all pairs of poses that see landmark l.
template <typename With>
void ForEachPair(const Case& c, const With& with) {
  for (int l = 0; l < static_cast<int>(c.l_dims.size()); ++l) {
    for (const int i : c.Seeing(l)) {
      for (const int j : c.Seeing(l)) with(i, j, l);
    }
  }
}

/// That pose or landmark 0 is left out.
inline Text Zeroth(const char* what) { return {"7.number_0_left_out", {{"it", Text(what, {{"n", Word(0)}})}}}; }

inline Case WithoutPose0(Case c) {
  if (!c.dims.empty()) c.A_rm.topRows(c.dims[0]).setZero();
  return c;
}
inline Case WithoutLandmark0(Case c) {
  if (!c.l_dims.empty()) c.A_rm.leftCols(c.l_dims[0]).setZero();
  return c;
}

/// What is subtracted from S_(i, j), i ≥ j, for landmark l.
using Product = std::function<MatXX(int i, int j, int l)>;

inline MatXX SchurWith(const Case& c, const Product& product) {
  MatXX S = c.A_rr;
  ForEachPair(c, [&](int i, int j, int l) {
    const MatXX block = product(i, j, l);
    if (i < j || block.rows() != c.dims[i] || block.cols() != c.dims[j]) return;
    S.block(c.rows[i], c.rows[j], c.dims[i], c.dims[j]) -= block;
    if (i != j) S.block(c.rows[j], c.rows[i], c.dims[j], c.dims[i]) -= block.transpose();
  });
  return S;
}

/// K_il b_l subtracted for each pair (i, j), from this row on; negative: not.
using RowOfPair = int (*)(const Case& c, int i, int j);

inline VecX ReducedInTheInnerLoop(const Case& c, RowOfPair row_of) {
  VecX b = c.b_r;
  ForEachPair(c, [&](int i, int j, int l) {
    const int row = row_of(c, i, j);
    if (row < 0 || row + c.dims[i] > b.size()) return;
    b.segment(row, c.dims[i]) -= c.Pl(i, l) * c.Inverse(l) * c.Bl(l);
  });
  return b;
}

/// The reduced right-hand side where it is set, not added to: of b_p and the landmarks only the last landmark's part is left.
inline VecX ReducedOfTheLastLandmark(const Case& c, double sign) {
  VecX b = c.b_r;
  ForEachPair(c,
              [&](int i, int, int l) { b.segment(c.rows[i], c.dims[i]) = sign * c.Pl(i, l) * c.Inverse(l) * c.Bl(l); });
  return b;
}

inline std::vector<Mistake> ReducedMistakes(const Case& c) {
  std::vector<Mistake> mistakes = EliminationMistakesInReduced({"7d", "7d", "b_p", "K_il b_l", "H_ll⁻¹", "H_ll"}, c);
  mistakes.push_back({"7d", "7.undamped_H_ll_inverted", c.Reduced(PseudoInversePsd(c.H_ll_undamped))});
  const RowOfPair in_the_inner_loop[] = {[](const Case& of, int i, int) { return of.rows[i]; },
                                         [](const Case& of, int i, int j) { return i >= j ? of.rows[i] : -1; },
                                         [](const Case& of, int, int j) { return of.rows[j]; },
                                         [](const Case& of, int i, int j) { return i >= j ? of.rows[j] : -1; },
                                         [](const Case& of, int i, int j) { return i > j ? of.rows[i] : -1; }};
  mistakes.push_back({"7d", Zeroth("scene.pose"), WithoutPose0(c).Reduced()});
  mistakes.push_back({"7d", Zeroth("scene.landmark"), WithoutLandmark0(c).Reduced()});
  for (const RowOfPair row_of : in_the_inner_loop) {
    mistakes.push_back({"7d", "7.b_schur_in_inner_loop", ReducedInTheInnerLoop(c, row_of)});
  }
  const RowOfPair number = [](const Case&, int i, int j) { return i == j ? i : -1; };
  const RowOfPair six_rows_each = [](const Case&, int i, int j) { return i == j ? 6 * i : -1; };
  mistakes.push_back({"7d", "7.pose_number_for_row", ReducedInTheInnerLoop(c, number)});
  mistakes.push_back({"7d", "7.six_rows_each", ReducedInTheInnerLoop(c, six_rows_each)});
  for (const double sign : {-1.0, 1.0}) {
    mistakes.push_back({"7d", "7.last_landmark_left", ReducedOfTheLastLandmark(c, sign)});
  }
  return mistakes;
}

/// S where each block is set, not added to.
inline MatXX SchurOfTheLastLandmark(const Case& c, double sign) {
  MatXX S = c.A_rr;
  ForEachPair(c, [&](int i, int j, int l) {
    S.block(c.rows[i], c.rows[j], c.dims[i], c.dims[j]) = sign * c.Pl(i, l) * c.Inverse(l) * c.Pl(j, l).transpose();
  });
  return S;
}

inline std::vector<Mistake> SchurMistakes(const Case& c) {
  const auto right = [&](int i, int j, int l) { return MatXX(c.Pl(i, l) * c.Inverse(l) * c.Pl(j, l).transpose()); };
  const auto is = [&](const Product& product) { return SchurWith(c, product); };
  const auto times = [&](double diagonal, double others) {
    return is([=](int i, int j, int l) { return MatXX((i == j ? diagonal : others) * right(i, j, l)); });
  };
  std::vector<Mistake> mistakes{{"7d", "7.only_diagonal_blocks_reduced", times(1, 0)},
                                {"7d", "7.diagonal_blocks_not_reduced", times(0, 1)},
                                {"7d", "7.undamped_H_ll_inverted", c.Schur(PseudoInversePsd(c.H_ll_undamped))},
                                {"7d", "7.off_diagonal_twice", times(1, 2)},
                                {"7d", "7.H_il_for_H_jl", is([&](int i, int, int l) { return right(i, i, l); })},
                                {"7d", "7.H_jl_for_H_il", is([&](int, int j, int l) { return right(j, j, l); })},
                                {"7d", Zeroth("scene.pose"), WithoutPose0(c).Schur()},
                                {"7d", Zeroth("scene.pose"),  // as i, where it is in a diagonal block alone
                                 is([&](int i, int j, int l) { return MatXX((i > 0) * right(i, j, l)); })},
                                {"7d", Zeroth("scene.landmark"), WithoutLandmark0(c).Schur()},
                                {"7d", "7.block_transposed", is([&](int i, int j, int l) { return right(j, i, l); })},
                                {"7d", "7.only_first_landmark_taken_S",
                                 is([&](int i, int j, int l) { return MatXX((l == 0) * right(i, j, l)); })},
                                {"7d", "7.last_landmark_left", SchurOfTheLastLandmark(c, -1.0)},
                                {"7d", "7.last_landmark_left", SchurOfTheLastLandmark(c, 1.0)}};
  Append(EliminationMistakesInSchur({"7d", "7d", "H_pp", "K_il H_jlᵀ", "H_ll⁻¹", "H_ll"}, c), &mistakes);
  return mistakes;
}

// Which poses that see a landmark are taken.
enum class Which { kAll, kFirst, kLast };

// Σ_i H_ilᵀ Δx_i with another choice of rows of Δx, or of poses.
inline VecX SumOverPoses(const Case& c, const VecX& x, bool by_number, Which which) {
  VecX sum = VecX::Zero(c.b_m.size());
  for (int l = 0; l < static_cast<int>(c.l_dims.size()); ++l) {
    const std::vector<int> seeing = c.Seeing(l);
    for (const int i : seeing) {
      if (which == Which::kFirst && i != seeing.front()) continue;
      if (which == Which::kLast && i != seeing.back()) continue;
      sum.segment(c.l_at[l], c.l_dims[l]) += c.Pl(i, l).transpose() * x.segment(by_number ? i : c.rows[i], c.dims[i]);
    }
  }
  return sum;
}

// H_ll⁻¹ applied once for each pose, in one of two orders.
inline VecX InvertedInTheLoop(const Case& c, const VecX& x, bool backwards) {
  VecX rest = c.b_m;
  for (int l = 0; l < static_cast<int>(c.l_dims.size()); ++l) {
    auto own = rest.segment(c.l_at[l], c.l_dims[l]);
    std::vector<int> seeing = c.Seeing(l);
    if (backwards) std::reverse(seeing.begin(), seeing.end());
    for (const int i : seeing) {
      own = (c.Inverse(l) * (own - c.Pl(i, l).transpose() * x.segment(c.rows[i], c.dims[i]))).eval();
    }
  }
  return rest;
}

inline std::vector<Mistake> StepMistakes(const Case& c) {
  const VecX x_p = c.StepOfPoses(), rest = c.b_m - c.A_rm.transpose() * x_p;
  const auto step = [&](const VecX& of_landmarks) { return c.Step(of_landmarks); };
  const MatXX& inverse = c.A_mm_inverse;
  const Text in_loop = "7.H_llinv_acts_once_for_each_pose";
  std::vector<Mistake> mistakes{{"7e", "7.undamped_H_ll_inverted", step(PseudoInversePsd(c.H_ll_undamped) * rest)},
                                {"7e", in_loop, step(InvertedInTheLoop(c, x_p, false))},
                                {"7e", in_loop, step(InvertedInTheLoop(c, x_p, true))}};
  const auto times = [&](const VecX& x) { return VecX(c.A_rm.transpose() * x); };
  Append(LandmarkStepMistakes({"7e", "H_ll⁻¹", "H_ll", "b_l", "Σ_i H_ilᵀ Δx_i", "Δx_i", "K_ilᵀ"}, c.A_mm, inverse,
                              c.b_m, x_p, {c.b_r, c.Reduced()}, times, step),
         &mistakes);
  for (const Which which : {Which::kFirst, Which::kLast}) {
    const VecX part = inverse * SumOverPoses(c, x_p, false, which);
    mistakes.push_back({"7e", "7.only_one_pose_taken_rest", step(inverse * c.b_m - part)});
    mistakes.push_back({"7e", "7.last_pose_left", step(part)});
    mistakes.push_back({"7e", "7.last_pose_left", step(-part)});
  }
  mistakes.push_back({"7e", Zeroth("scene.pose"), step(inverse * (c.b_m - WithoutPose0(c).A_rm.transpose() * x_p))});
  bool fits = true;
  for (size_t i = 0; i < c.dims.size(); ++i) fits = fits && static_cast<int>(i) + c.dims[i] <= c.b_r.size();
  if (fits) {
    mistakes.push_back(
        {"7e", "7.pose_number_for_row", step(inverse * (c.b_m - SumOverPoses(c, x_p, true, Which::kAll)))});
  }
  return mistakes;
}

}  // namespace ch5::homework::stage_7
