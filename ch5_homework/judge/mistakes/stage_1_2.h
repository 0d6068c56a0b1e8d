#pragma once
/// What typical mistakes in SolveLinearSystem make of S, of the reduced right-hand side and of Δx.

#include <algorithm>
#include <string>
#include <vector>

#include "ch5_backend/dense/dense_solvers.h"
#include "ch5_backend/math/psd.h"
#include "ch5_homework/judge/diagnosis.h"
#include "ch5_homework/judge/mistakes/elimination.h"
#include "ch5_homework/judge/mistakes/formula.h"
#include "ch5_homework/judge/oracle.h"

namespace ch5::homework::stage_1_2 {

inline VecX Solve(const MatXX& A, const VecX& b) {
  VecX x = VecX::Zero(b.size());
  SolveLdlt(A, b, &x);
  return x;
}

// H with λ_p D on the poses' diagonal and λ_m D on the landmarks'.
inline MatXX Damp(const MatXX& H, int p, double lambda_p, double lambda_m, Damping damping) {
  const VecX D = damping == Damping::kIdentity ? VecX::Ones(H.rows()) : VecX(H.diagonal());
  MatXX damped = H;
  damped.diagonal().head(p) += lambda_p * D.head(p);
  damped.diagonal().tail(H.rows() - p) += lambda_m * D.tail(H.rows() - p);
  return damped;
}

struct DampingMistake {
  Text cause;
  MatXX H;
  const char* todo = "1.2a";
};

/// Everything that can be asked about one call of SolveLinearSystem. The poses remain, the landmarks go.
struct Case {
  System system;
  int p;  // dimension of the poses
  double lambda;
  Damping damping;

  MatXX Damped() const { return Damp(system.H, p, lambda, lambda, damping); }
  PartedSystem Right() const { return PartedSystem(Damped(), system.b, p); }

  std::vector<DampingMistake> DampingMistakes() const {
    const Damping other = damping == Damping::kIdentity ? Damping::kDiagonal : Damping::kIdentity;
    const auto damp = [&](double p_times, double m_times) {
      return Damp(system.H, p, p_times * lambda, m_times * lambda, damping);
    };
    const Text of_other =
        damping == Damping::kIdentity ? "1.2.damping_diag_for_identity" : "1.2.damping_identity_for_diag";
    return {{"1.2.lambda_missing", system.H},
            {"1.2.lambda_missing_landmarks", damp(1, 0)},
            {"1.2.lambda_missing_poses", damp(0, 1), "1.2b"},
            {"1.2.lambda_added_twice_poses", damp(2, 1), "1.2b"},
            {"1.2.lambda_added_twice", damp(2, 2)},
            {"1.2.lambda_added_twice_landmarks", damp(1, 2)},
            {of_other, Damp(system.H, p, lambda, lambda, other)},
            {of_other, Damp(damp(0, 1), p, lambda, 0, other), "1.2b"},
            {of_other, Damp(damp(1, 0), p, 0, lambda, other)}};
  }

  /// segment(n, n) of b, as far as b reaches; otherwise no numbers.
  VecX StartingAtItsLength(Eigen::Index n) const {
    return 2 * n <= system.b.size() ? VecX(system.b.segment(n, n)) : VecX(VecX::Constant(n, std::nan("")));
  }
  /// The landmarks' rows of b, from one row too early on.
  VecX OneRowEarly(Eigen::Index m) const { return m < system.b.size() ? VecX(system.b.segment(p - 1, m)) : system.b; }

  std::vector<Mistake> SchurMistakes() const {
    const PartedSystem r = Right();
    const MatXX S = r.Schur();
    MatXX diagonal_blocks = r.A_rr;
    std::vector<Mistake> mistakes;
    for (Eigen::Index k = 0; k + 6 <= S.rows(); k += 6) {  // pose by pose
      MatXX rows = r.A_rr, block = r.A_rr;
      rows.middleRows(k, 6) = S.middleRows(k, 6);
      block.block(k, k, 6, 6) = diagonal_blocks.block(k, k, 6, 6) = S.block(k, k, 6, 6);
      for (const MatXX& answer : {rows, MatXX(rows.transpose()), block}) {
        mistakes.push_back({"1.2b", "1.2.only_one_pose_reduced", answer});
      }
    }
    mistakes.push_back({"1.2b", "1.2.only_diagonal_blocks_reduced", diagonal_blocks});
    Append(EliminationMistakesInSchur({"1.2b", "1.2d 1.2b", "H_pp", "H_pm H_mm⁻¹ H_mp", "H_mm⁻¹", "H_mm"}, r),
           &mistakes);
    Append(CornerMistakes(r), &mistakes);
    for (const auto& [cause, H, todo] : DampingMistakes()) {
      mistakes.push_back({todo, cause, PartedSystem(H, system.b, p).Schur()});
    }
    return mistakes;
  }

  /// One corner of H stands where another is meant.
  std::vector<Mistake> CornerMistakes(const PartedSystem& r) const {
    const MatXX &P = r.A_rm, Q = r.A_rm.transpose(), &inverse = r.A_mm_inverse;
    const MatXX H = Damped();
    const auto m = static_cast<int>(P.cols());
    std::vector<Mistake> mistakes;
    for (const int start : {p - 1, 0, m}) {  // in place of p
      if (start < 0 || start == p || start + m > H.cols()) continue;
      const MatXX other = H.block(0, start, p, m);
      const VecX depths = H.diagonal().segment(start, m).cwiseInverse();  // if the landmarks are inverse depths
      mistakes.push_back({"1.2a", "1.2.coupling_at_wrong_place", r.A_rr - P * inverse * other.transpose()});
      mistakes.push_back({"1.2a", "1.2.coupling_at_wrong_place", r.A_rr - other * inverse * Q});
      mistakes.push_back({"1.2a", "1.2.coupling_at_wrong_place", r.A_rr - other * inverse * other.transpose()});
      mistakes.push_back({"1.2a", "1.2.Hmm_at_wrong_corner", r.Schur(depths.asDiagonal())});
    }
    if (P.rows() != P.cols()) return mistakes;
    // Here an exchange of p and m goes unseen by Eigen.
    const std::vector<Mistake> exchanges{{"1.2a", "1.2.H_pm_H_mp_exchanged", r.A_rr - Q * inverse * P},
                                         {"1.2a", "1.2.H_pm_for_H_mp", r.A_rr - P * inverse * P},
                                         {"1.2a", "1.2.H_pm_holds_H_mp", r.A_rr - Q * inverse * Q},
                                         {"1.2d 1.2b", "1.2.H_pp_inverted", r.Schur(r.A_rr.inverse())},
                                         {"1.2d 1.2b", "1.2.H_mminv_on_the_left", r.A_rr - inverse * P * Q},
                                         {"1.2b", "1.2.tempH_transposed", r.A_rr - inverse * Q * Q},
                                         {"1.2b", "1.2.H_mm_for_H_pp", r.A_mm - P * inverse * Q}};
    mistakes.insert(mistakes.end(), exchanges.begin(), exchanges.end());
    return mistakes;
  }

  std::vector<Mistake> ReducedMistakes() const {
    const PartedSystem r = Right();
    const MatXX& inverse = r.A_mm_inverse;
    const VecX b_p = StartingAtItsLength(r.b_r.size()), b_m = StartingAtItsLength(r.b_m.size());
    const auto with = [&](const VecX& other_b_m) { return MatXX(r.b_r - r.A_rm * inverse * other_b_m); };
    std::vector<Mistake> mistakes{{"1.2a", "1.2.bpp_starts_own_length", b_p - r.b_r + r.Reduced()},
                                  {"1.2a", "1.2.bmm_starts_own_length", with(b_m)},
                                  {"1.2a", "1.2.bpp_bmm_start_own_lengths", b_p - r.b_r + with(b_m)},
                                  {"1.2a", "1.2.b_m_at_wrong_place", with(OneRowEarly(r.b_m.size()))},
                                  {"1.2a", "1.2.signs_both_segments", -r.Reduced()},
                                  {"1.2a", "1.2.poses_b_for_b_m", with(system.b.head(r.b_m.size()))}};
    for (Eigen::Index k = 0; k + 6 <= r.b_r.size(); k += 6) {
      VecX of_one_pose = r.b_r;
      of_one_pose.segment(k, 6) = r.Reduced().segment(k, 6);
      mistakes.push_back({"1.2b", "1.2.only_one_pose_reduced", of_one_pose});
    }
    Append(EliminationMistakesInReduced({"1.2b", "1.2b", "b_p", "H_pm H_mm⁻¹ b_m", "H_mm⁻¹", "H_mm"}, r), &mistakes);
    if (r.b_r.size() == r.b_m.size()) {
      mistakes.push_back({"1.2a", "1.2.b_p_b_m_exchanged", r.b_m - r.b_r + with(r.b_r)});
      mistakes.push_back({"1.2b", "1.2.tempH_transposed", r.b_r - inverse * r.A_rm.transpose() * r.b_m});
    }
    return mistakes;
  }

  static MatXX Step(const VecX& x_p, const VecX& x_m) {
    VecX x(x_p.size() + x_m.size());
    x << x_p, x_m;
    return x;
  }

  std::vector<Mistake> StepMistakes() const {
    const PartedSystem r = Right();
    const VecX x_p = Solve(r.Schur(), r.Reduced());
    std::vector<Mistake> mistakes = LandmarkMistakes(r, x_p);
    for (const auto& [cause, H, todo] : DampingMistakes()) {
      mistakes.push_back({todo, cause, Solve(H, system.b)});
      mistakes.push_back({"1.2c", Text("1.2.right_for_poses", {{"cause", cause}}),
                          Step(x_p, PartedSystem(H, system.b, p).A_mm_inverse * (r.b_m - r.A_rm.transpose() * x_p))});
    }
    return mistakes;
  }

  /// Where the poses' step is right.
  std::vector<Mistake> LandmarkMistakes(const PartedSystem& r, const VecX& x_p) const {
    const VecX H_mp_x = r.A_rm.transpose() * x_p;
    const auto step = [x_p](const VecX& x_m) { return Step(x_p, x_m); };
    std::vector<Mistake> mistakes{
        {"1.2c", "1.2.H_mminv_acts_once_more_b_m", step(r.A_mm_inverse * (r.A_mm_inverse * r.b_m - H_mp_x))},
        {"1.2c", "1.2.b_m_at_wrong_place", step(r.A_mm_inverse * (system.b.head(r.b_m.size()) - H_mp_x))},
        {"1.2c", "1.2.b_m_at_wrong_place", step(r.A_mm_inverse * (StartingAtItsLength(r.b_m.size()) - H_mp_x))}};
    const auto times = [&](const VecX& x) { return VecX(r.A_rm.transpose() * x); };
    if (x_p.size() > 6) {
      const VecX of_first = r.A_rm.topRows(6).transpose() * x_p.head(6);
      mistakes.push_back({"1.2c", "1.2.first_pose_alone", step(r.A_mm_inverse * (r.b_m - of_first))});
    }
    Append(
        LandmarkStepMistakes({"1.2c", "H_mm⁻¹", "H_mm", "b_m", "H_mp Δx_p", "Δx_p", "tempHᵀ"}, r.A_mm, r.A_mm_inverse,
                             r.b_m, x_p, {r.b_r, r.Reduced()}, times, [&](const VecX& x_m) { return VecX(step(x_m)); }),
        &mistakes);
    if (r.b_r.size() == r.b_m.size()) {  // here Eigen does not see it
      mistakes.push_back({"1.2c", "1.2.H_pm_for_H_mp", step(r.A_mm_inverse * (r.b_m - r.A_rm * x_p))});
      mistakes.push_back(
          {"1.2c", StandsFor("tempH", "Hmp"), step(r.A_mm_inverse * (r.b_m - r.A_rm * r.A_mm_inverse * x_p))});
      mistakes.push_back(
          {"1.2c", "1.2.poses_reduced_b_for_landmarks_b_m", step(r.A_mm_inverse * (r.Reduced() - H_mp_x))});
    }
    return mistakes;
  }
};

}  // namespace ch5::homework::stage_1_2
