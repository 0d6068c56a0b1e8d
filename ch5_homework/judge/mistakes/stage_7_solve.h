#pragma once
/// What typical mistakes in PlainBlockSolver::Solve make of S and of the reduced right-hand side (7d), and of Δx (7e).

#include <algorithm>
#include <functional>
#include <string>
#include <vector>

#include "ch5_backend/graph/ordering.h"
#include "ch5_backend/linear/dense_solvers.h"
#include "ch5_backend/math/psd.h"
#include "ch5_backend/solve/normal_equations.h"
#include "ch5_homework/judge/narrate.h"
#include "ch5_homework/judge/scenes.h"

namespace ch5::homework::stage_7 {

/// A damped system, its Schur complement, and what typical mistakes make of them.
struct Case {
  int p;
  MatXX H_pp, H_pl, H_ll, H_ll_inverse, H_ll_undamped;
  VecX b_p, b_l;
  std::vector<int> dims, rows;    // of the poses
  std::vector<int> l_dims, l_at;  // of the landmarks, rows of H_ll

  Case(const System& system, const Ordering& ordering, double lambda, Damping damping) : p(ordering.dim_poses) {
    MatXX H = system.H;
    for (int i = 0; i < H.rows(); ++i) H(i, i) += lambda * DampingEntry(damping, H(i, i));
    const auto l = H.rows() - p;
    H_pp = H.topLeftCorner(p, p);
    H_pl = H.topRightCorner(p, l);
    H_ll = H.bottomRightCorner(l, l);
    H_ll_undamped = system.H.bottomRightCorner(l, l);
    H_ll_inverse = PseudoInversePsd(H_ll);
    b_p = system.b.head(p);
    b_l = system.b.tail(l);
    for (const auto& pose : ordering.poses) {
      dims.push_back(pose->LocalDimension());
      rows.push_back(pose->OrderingId());
    }
    for (const auto& landmark : ordering.landmarks) {
      l_dims.push_back(landmark->LocalDimension());
      l_at.push_back(landmark->OrderingId() - p);
    }
  }
  MatXX Subtrahend() const { return H_pl * H_ll_inverse * H_pl.transpose(); }
  MatXX Schur() const { return H_pp - Subtrahend(); }
  VecX Reduced() const { return b_p - H_pl * H_ll_inverse * b_l; }
  VecX Step(const VecX& of_landmarks) const {
    VecX x(p + of_landmarks.size());
    x << StepOfPoses(), of_landmarks;
    return x;
  }
  VecX StepOfPoses() const {
    VecX x = VecX::Zero(p);
    if (p > 0) SolveLdlt(Schur(), Reduced(), &x);
    return x;
  }
  VecX Rest(double sign) const { return b_l + sign * H_pl.transpose() * StepOfPoses(); }

  // Blocks, by numbers.
  MatXX Pl(int i, int l) const { return H_pl.block(rows[i], l_at[l], dims[i], l_dims[l]); }
  MatXX Inverse(int l) const { return H_ll_inverse.block(l_at[l], l_at[l], l_dims[l], l_dims[l]); }
  VecX Bl(int l) const { return b_l.segment(l_at[l], l_dims[l]); }
  std::vector<int> Seeing(int l) const {
    std::vector<int> poses;
    for (size_t i = 0; i < dims.size(); ++i) {
      if (!Pl(static_cast<int>(i), l).isZero(0.0)) poses.push_back(static_cast<int>(i));
    }
    return poses;
  }
};

/// What is subtracted from S_(i, j), i ≥ j, for landmark l.
using Product = std::function<MatXX(const Case& c, int i, int j, int l)>;
/// What is subtracted from b_schur_ for pose i, landmark l and one j of the inner loop, and from whose rows.
struct Share {
  int row;
  VecX entries;
};
using ShareOf = std::function<Share(const Case& c, int i, int j, int l)>;

inline MatXX SchurWith(const Case& c, const Product& product) {
  MatXX S = c.H_pp;
  for (int l = 0; l < static_cast<int>(c.l_dims.size()); ++l) {
    for (const int i : c.Seeing(l)) {
      for (const int j : c.Seeing(l)) {
        if (i < j) continue;
        const MatXX block = product(c, i, j, l);
        if (block.rows() != c.dims[i] || block.cols() != c.dims[j]) continue;
        S.block(c.rows[i], c.rows[j], c.dims[i], c.dims[j]) -= block;
        if (i != j) S.block(c.rows[j], c.rows[i], c.dims[j], c.dims[i]) -= block.transpose();
      }
    }
  }
  return S;
}

inline VecX ReducedWith(const Case& c, const ShareOf& share_of) {
  VecX b = c.b_p;
  for (int l = 0; l < static_cast<int>(c.l_dims.size()); ++l) {
    for (const int i : c.Seeing(l)) {
      for (const int j : c.Seeing(l)) {
        const Share share = share_of(c, i, j, l);
        if (share.row >= 0 && share.row + share.entries.size() <= b.size()) {
          b.segment(share.row, share.entries.size()) -= share.entries;
        }
      }
    }
  }
  return b;
}

inline std::vector<Mistake> ReducedMistakes(const Case& c) {
  const auto is = [&c](const ShareOf& share) { return [&c, share] { return MatXX(ReducedWith(c, share)); }; };
  const std::string inner =
      "the line of b_schur_ stands in the inner loop: it is subtracted once for each j, and belongs to i alone";
  const std::string number = "the pose's number stands where its first row is meant: PoseRow(i)";
  const auto K_b = [](const Case& of, int i, int l) { return VecX(of.Pl(i, l) * of.Inverse(l) * of.Bl(l)); };
  return {{"7d", "the right-hand side is not reduced: K_il b_l is not subtracted", [&c] { return c.b_p; }},
          {"7d", "the sign: K_il b_l is added, not subtracted",
           [&c] { return VecX(c.b_p + c.H_pl * c.H_ll_inverse * c.b_l); }},
          {"7d", "H_ll⁻¹ is missing: use K_il, not H_pl_(i, l)", [&c] { return VecX(c.b_p - c.H_pl * c.b_l); }},
          {"7d", "H_ll stands where its inverse is meant", [&c] { return VecX(c.b_p - c.H_pl * c.H_ll * c.b_l); }},
          {"7d", "K_il b_l is subtracted twice", [&c] { return VecX(2.0 * c.Reduced() - c.b_p); }},
          {"7d", "b_p is lost: = stands where −= is meant", [&c] { return VecX(c.Reduced() - c.b_p); }},
          {"7d", "H_ll⁻¹ acts twice: K_il has it already",
           [&c] { return VecX(c.b_p - c.H_pl * c.H_ll_inverse * c.H_ll_inverse * c.b_l); }},
          {"7d", inner, is([=](const Case& of, int i, int, int l) {
             return Share{of.rows[i], K_b(of, i, l)};
           })},
          {"7d", inner, is([=](const Case& of, int i, int j, int l) {
             return Share{i >= j ? of.rows[i] : -1, K_b(of, i, l)};
           })},
          {"7d", inner, is([=](const Case& of, int i, int j, int l) {
             return Share{of.rows[j], K_b(of, i, l)};
           })},
          {"7d", inner, is([=](const Case& of, int i, int j, int l) {
             return Share{i >= j ? of.rows[j] : -1, K_b(of, i, l)};
           })},
          {"7d", inner, is([=](const Case& of, int i, int j, int l) {
             return Share{i > j ? of.rows[i] : -1, K_b(of, i, l)};
           })},
          {"7d", number, is([=](const Case& of, int i, int j, int l) {
             return Share{i == j ? i : -1, K_b(of, i, l)};
           })}};
}

/// S where each block is set, not added to: of H_pp and the landmarks only the last landmark's part is left.
inline MatXX SchurOfTheLastLandmark(const Case& c, double sign) {
  MatXX S = c.H_pp;
  for (int l = 0; l < static_cast<int>(c.l_dims.size()); ++l) {
    for (const int i : c.Seeing(l)) {
      for (const int j : c.Seeing(l)) {
        S.block(c.rows[i], c.rows[j], c.dims[i], c.dims[j]) = sign * c.Pl(i, l) * c.Inverse(l) * c.Pl(j, l).transpose();
      }
    }
  }
  return S;
}

inline std::vector<Mistake> SchurMistakes(const Case& c) {
  const auto is = [&c](const Product& product) { return [&c, product] { return SchurWith(c, product); }; };
  const auto right = [](const Case& of, int i, int j, int l) {
    return MatXX(of.Pl(i, l) * of.Inverse(l) * of.Pl(j, l).transpose());
  };
  const auto only = [right](bool diagonal) {
    return [=](const Case& of, int i, int j, int l) { return MatXX(((i == j) == diagonal) * right(of, i, j, l)); };
  };
  return {{"7d", "nothing is subtracted: S is H_pp alone", [&c] { return c.H_pp; }},
          {"7d", "the sign: K_il H_jlᵀ is added, not subtracted", [&c] { return MatXX(c.H_pp + c.Subtrahend()); }},
          {"7d", "only the diagonal blocks S(i, i) are reduced: j runs over all poses that see the landmark",
           is(only(true))},
          {"7d", "the diagonal blocks S(i, i) are not reduced: a pose makes a pair with itself too, i ≥ j",
           is(only(false))},
          {"7d", "H_ll⁻¹ is missing: use K_il, not H_pl_(i, l)",
           [&c] { return MatXX(c.H_pp - c.H_pl * c.H_pl.transpose()); }},
          {"7d", "H_ll stands where its inverse is meant",
           [&c] { return MatXX(c.H_pp - c.H_pl * c.H_ll * c.H_pl.transpose()); }},
          {"7d", "H_pp is lost: = stands where −= is meant", [&c] { return MatXX(-c.Subtrahend()); }},
          {"7d", "K_il H_jlᵀ is subtracted twice", [&c] { return MatXX(c.H_pp - 2.0 * c.Subtrahend()); }},
          {"7d", "H_il stands where H_jl is meant: S(i, j) takes K_il H_jlᵀ",
           is([right](const Case& of, int i, int, int l) { return right(of, i, i, l); })},
          {"7d", "H_jl stands where K_il is made of H_il: S(i, j) takes K_il H_jlᵀ",
           is([right](const Case& of, int, int j, int l) { return right(of, j, j, l); })},
          {"7d", "the block is transposed: S(i, j) takes K_il H_jlᵀ, rows of pose i",
           is([right](const Case& of, int i, int j, int l) { return right(of, j, i, l); })},
          {"7d", "H_ll⁻¹ acts twice: K_jl stands where H_jl is meant",
           [&c] { return MatXX(c.H_pp - c.H_pl * c.H_ll_inverse * c.H_ll_inverse * c.H_pl.transpose()); }},
          {"7d", "only the first landmark is taken into S",
           is([right](const Case& of, int i, int j, int l) { return MatXX((l == 0) * right(of, i, j, l)); })},
          {"7d", "= stands where −= is meant: only the last landmark's share is left",
           [&c] { return SchurOfTheLastLandmark(c, -1.0); }},
          {"7d", "= stands where −= is meant: only the last landmark's share is left",
           [&c] { return SchurOfTheLastLandmark(c, 1.0); }}};
}

// Which poses that see a landmark are taken.
enum class Which { kAll, kFirst, kLast };

// Σ_i H_ilᵀ Δx_i with another choice of rows of Δx, or of poses.
inline VecX SumOverPoses(const Case& c, const VecX& x, bool by_number, Which which) {
  VecX sum = VecX::Zero(c.b_l.size());
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
  VecX rest = c.b_l;
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
  const VecX x_p = c.StepOfPoses();
  const auto step = [&](const VecX& of_landmarks) {
    const VecX x = c.Step(of_landmarks);
    return std::function<MatXX()>([x] { return x; });
  };
  const MatXX& inverse = c.H_ll_inverse;
  const std::string one = "only one pose is taken from `rest`: every pose that sees the landmark has its share";
  const std::string in_loop = "H_ll⁻¹ acts once for each pose: it stands in the loop, and belongs behind it";
  std::vector<Mistake> mistakes{
      {"7e", "the landmarks do not hear of the poses: H_ilᵀ Δx_i is not subtracted", step(inverse * c.b_l)},
      {"7e", "the sign: it is b_l − Σ_i H_ilᵀ Δx_i, not +", step(inverse * c.Rest(+1.0))},
      {"7e", "H_ll⁻¹ is missing: this is b_l − Σ_i H_ilᵀ Δx_i", step(c.Rest(-1.0))},
      {"7e", "the landmarks do not move", step(VecX::Zero(c.b_l.size()))},
      {"7e", "b_l is missing: this is −H_ll⁻¹ Σ_i H_ilᵀ Δx_i", step(inverse * (c.Rest(-1.0) - c.b_l))},
      {"7e", "b_l is missing: this is H_ll⁻¹ Σ_i H_ilᵀ Δx_i", step(inverse * (c.b_l - c.Rest(-1.0)))},
      {"7e", "the sign of the whole landmark step is wrong", step(-inverse * c.Rest(-1.0))},
      {"7e", "the undamped H_ll is inverted here: H_ll_inverse_(l, l) has λ in it",
       step(PseudoInversePsd(c.H_ll_undamped) * c.Rest(-1.0))},
      {"7e", "H_ll stands where its inverse is meant", step(c.H_ll * c.Rest(-1.0))},
      {"7e", "the sum is subtracted twice", step(inverse * (2.0 * c.Rest(-1.0) - c.b_l))},
      {"7e", "H_ll⁻¹ acts on b_l only: first the whole difference, then the inverse",
       step(inverse * c.b_l + c.Rest(-1.0) - c.b_l)},
      {"7e", one, step(inverse * (c.b_l - SumOverPoses(c, x_p, false, Which::kFirst)))},
      {"7e", one, step(inverse * (c.b_l - SumOverPoses(c, x_p, false, Which::kLast)))},
      {"7e", "b_p stands where the poses' step Δx_i is meant", step(inverse * (c.b_l - c.H_pl.transpose() * c.b_p))},
      {"7e", in_loop, step(InvertedInTheLoop(c, x_p, false))},
      {"7e", in_loop, step(InvertedInTheLoop(c, x_p, true))}};
  bool fits = true;
  for (size_t i = 0; i < c.dims.size(); ++i) fits = fits && static_cast<int>(i) + c.dims[i] <= c.p;
  if (fits) {
    mistakes.push_back({"7e", "the pose's number stands where its first row is meant: PoseRow(i)",
                        step(inverse * (c.b_l - SumOverPoses(c, x_p, true, Which::kAll)))});
  }
  return mistakes;
}

}  // namespace ch5::homework::stage_7
