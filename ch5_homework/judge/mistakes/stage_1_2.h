#pragma once
/// What typical mistakes in SolveLinearSystem make of S, of the reduced right-hand side and of Δx.

#include <algorithm>
#include <string>
#include <vector>

#include "ch5_backend/dense/dense_solvers.h"
#include "ch5_backend/math/psd.h"
#include "ch5_homework/judge/diagnosis.h"
#include "ch5_homework/judge/oracle.h"

namespace ch5::homework::stage_1_2 {

/// A damped system taken apart, and what follows from it.
struct Parts {
  MatXX H_pp, H_pm, H_mm, H_mm_inverse;
  VecX b_p, b_m;

  Parts(const MatXX& H, const VecX& b, int p) {
    const auto m = H.rows() - p;
    H_pp = H.topLeftCorner(p, p);
    H_pm = H.topRightCorner(p, m);
    H_mm = H.bottomRightCorner(m, m);
    H_mm_inverse = PseudoInversePsd(H_mm);
    b_p = b.head(p);
    b_m = b.tail(m);
  }
  MatXX Schur() const { return H_pp - H_pm * H_mm_inverse * H_pm.transpose(); }
  VecX Reduced() const { return b_p - H_pm * H_mm_inverse * b_m; }
};

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

/// Everything that can be asked about one call of SolveLinearSystem.
struct Case {
  System system;
  int p;  // dimension of the poses
  double lambda;
  Damping damping;

  MatXX Damped() const { return Damp(system.H, p, lambda, lambda, damping); }
  Parts Right() const { return Parts(Damped(), system.b, p); }

  std::vector<DampingMistake> DampingMistakes() const {
    const Damping other = damping == Damping::kIdentity ? Damping::kDiagonal : Damping::kIdentity;
    const auto damp = [&](double p_times, double m_times) {
      return Damp(system.H, p, p_times * lambda, m_times * lambda, damping);
    };
    return {{"1.2.lambda_missing", system.H},
            {"1.2.lambda_missing_landmarks", damp(1, 0)},
            {"1.2.lambda_missing_poses", damp(0, 1), "1.2b"},
            {"1.2.lambda_added_twice_poses", damp(2, 1), "1.2b"},
            {"1.2.lambda_added_twice", damp(2, 2)},
            {"1.2.lambda_added_twice_landmarks", damp(1, 2)},
            {damping == Damping::kIdentity ? "1.2.damping_diag_for_identity" : "1.2.damping_identity_for_diag",
             Damp(system.H, p, lambda, lambda, other)}};
  }

  /// segment(n, n) of b, as far as b reaches; otherwise zero.
  VecX StartingAtItsLength(Eigen::Index n) const {
    return 2 * n <= system.b.size() ? VecX(system.b.segment(n, n)) : VecX(VecX::Zero(n));
  }
  /// The landmarks' rows of b, from one row too early on.
  VecX OneRowEarly(Eigen::Index m) const { return m < system.b.size() ? VecX(system.b.segment(p - 1, m)) : system.b; }

  std::vector<Mistake> SchurMistakes() const {
    const Parts r = Right();
    std::vector<Mistake> mistakes{
        {"1.2b", Text("formula.sign_added", {{"term", Word("H_pm H_mm⁻¹ H_mp")}}),
         [=] { return MatXX(r.H_pp + r.H_pm * r.H_mm_inverse * r.H_pm.transpose()); }},
        {"1.2b", "1.2.nothing_subtracted", [=] { return r.H_pp; }},
        {"1.2d 1.2b", Text("1.2.H_mminv_missing", {{"product", Word("H_pm H_mm⁻¹ H_mp")}}),
         [=] { return MatXX(r.H_pp - r.H_pm * r.H_pm.transpose()); }},
        {"1.2d 1.2b", Text("formula.inverse_meant", {{"matrix", Word("H_mm")}}),
         [=] { return MatXX(r.H_pp - r.H_pm * r.H_mm * r.H_pm.transpose()); }},
        {"1.2b", "1.2.H_mminv_acts_twice",
         [=] { return MatXX(r.H_pp - r.H_pm * r.H_mm_inverse * r.H_mm_inverse * r.H_pm.transpose()); }},
        {"1.2b", Text("formula.missing_leaves", {{"this", Word("H_pp")}, {"that", Word("−H_pm H_mm⁻¹ H_mp")}}),
         [=] { return MatXX(r.Schur() - r.H_pp); }},
        {"1.2b", Text("formula.missing_leaves", {{"this", Word("H_pp")}, {"that", Word("H_pm H_mm⁻¹ H_mp")}}),
         [=] { return MatXX(r.H_pp - r.Schur()); }},
        {"1.2d 1.2b", "1.2.H_mm_only_diagonal_inverted", [=] {
           const MatXX inverse = r.H_mm.diagonal().cwiseInverse().asDiagonal();
           return MatXX(r.H_pp - r.H_pm * inverse * r.H_pm.transpose());
         }}};
    mistakes.push_back({"1.2b", "1.2.only_diagonal_blocks_reduced", [=] {
                          MatXX S = r.H_pp;
                          for (Eigen::Index k = 0; k + 6 <= S.rows(); k += 6) {  // pose by pose
                            S.block(k, k, 6, 6) = r.Schur().block(k, k, 6, 6);
                          }
                          return S;
                        }});
    for (const Mistake& mistake : CornerMistakes(r)) mistakes.push_back(mistake);
    for (const DampingMistake& damping_mistake : DampingMistakes()) {
      const MatXX wrong = Parts(damping_mistake.H, system.b, p).Schur();
      mistakes.push_back({damping_mistake.todo, damping_mistake.cause, [=] { return wrong; }});
    }
    return mistakes;
  }

  /// One corner of H stands where another is meant.
  static std::vector<Mistake> CornerMistakes(const Parts& r) {
    std::vector<Mistake> mistakes{{"1.2a", "1.2.coupling_at_wrong_place",
                                   [=] {
                                     const MatXX corner = r.H_pp.leftCols(std::min(r.H_pp.cols(), r.H_pm.cols()));
                                     if (corner.cols() < r.H_pm.cols()) return r.H_pp;
                                     return MatXX(r.H_pp - r.H_pm * r.H_mm_inverse * corner.transpose());
                                   }},
                                  {"1.2a", "1.2.coupling_at_wrong_place", [=] {
                                     const MatXX corner = r.H_pp.leftCols(std::min(r.H_pp.cols(), r.H_pm.cols()));
                                     if (corner.cols() < r.H_pm.cols()) return r.H_pp;
                                     return MatXX(r.H_pp - corner * r.H_mm_inverse * r.H_pm.transpose());
                                   }}};
    if (r.H_pm.rows() == r.H_pm.cols()) {  // here an exchange of p and m goes unseen by Eigen
      const MatXX Q = r.H_pm.transpose();
      mistakes.push_back(
          {"1.2a", "1.2.H_pm_H_mp_exchanged", [=] { return MatXX(r.H_pp - Q * r.H_mm_inverse * r.H_pm); }});
      mistakes.push_back(
          {"1.2a", "1.2.H_mp_holds_H_pm", [=] { return MatXX(r.H_pp - r.H_pm * r.H_mm_inverse * r.H_pm); }});
      mistakes.push_back({"1.2a", "1.2.H_pm_holds_H_mp", [=] { return MatXX(r.H_pp - Q * r.H_mm_inverse * Q); }});
      mistakes.push_back(
          {"1.2d 1.2b", "1.2.H_pp_inverted", [=] { return MatXX(r.H_pp - r.H_pm * r.H_pp.inverse() * Q); }});
      const MatXX corner = r.H_pp.diagonal().cwiseInverse().asDiagonal();  // of inverse depths, block by block
      mistakes.push_back({"1.2a", "1.2.Hmm_at_wrong_corner", [=] { return MatXX(r.H_pp - r.H_pm * corner * Q); }});
      mistakes.push_back({"1.2b", "1.2.H_mm_for_H_pp", [=] { return MatXX(r.H_mm - r.H_pm * r.H_mm_inverse * Q); }});
    }
    return mistakes;
  }

  std::vector<Mistake> ReducedMistakes() const {
    const Parts r = Right();
    std::vector<Mistake> mistakes{
        {"1.2b", "1.2.b_not_reduced", [=] { return r.b_p; }},
        {"1.2b", Text("formula.sign_added", {{"term", Word("H_pm H_mm⁻¹ b_m")}}),
         [=] { return VecX(r.b_p + r.H_pm * r.H_mm_inverse * r.b_m); }},
        {"1.2b", Text("1.2.H_mminv_missing", {{"product", Word("H_pm H_mm⁻¹ b_m")}}),
         [=] { return VecX(r.b_p - r.H_pm * r.b_m); }},
        {"1.2b", Text("formula.missing_leaves", {{"this", Word("b_p")}, {"that", Word("−H_pm H_mm⁻¹ b_m")}}),
         [=] { return VecX(r.Reduced() - r.b_p); }},
        {"1.2b", Text("formula.missing_leaves", {{"this", Word("b_p")}, {"that", Word("H_pm H_mm⁻¹ b_m")}}),
         [=] { return VecX(r.b_p - r.Reduced()); }},
        {"1.2b", "1.2.H_mminv_acts_twice",
         [=] { return VecX(r.b_p - r.H_pm * r.H_mm_inverse * r.H_mm_inverse * r.b_m); }},
        {"1.2a", "1.2.bpp_starts_own_length",
         [=] { return VecX(StartingAtItsLength(r.b_p.size()) - r.H_pm * r.H_mm_inverse * r.b_m); }},
        {"1.2a", "1.2.bmm_starts_own_length",
         [=] { return VecX(r.b_p - r.H_pm * r.H_mm_inverse * StartingAtItsLength(r.b_m.size())); }},
        {"1.2a", "1.2.bpp_bmm_start_own_lengths",
         [=] {
           return VecX(StartingAtItsLength(r.b_p.size()) - r.H_pm * r.H_mm_inverse * StartingAtItsLength(r.b_m.size()));
         }},
        {"1.2a", "1.2.b_m_at_wrong_place",
         [=] { return VecX(r.b_p - r.H_pm * r.H_mm_inverse * OneRowEarly(r.b_m.size())); }},
        {"1.2a", "1.2.signs_both_segments", [=] { return VecX(-r.Reduced()); }},
        {"1.2a", "1.2.poses_b_for_b_m",
         [=] { return VecX(r.b_p - r.H_pm * r.H_mm_inverse * system.b.head(r.b_m.size())); }}};
    if (r.b_p.size() == r.b_m.size()) {
      mistakes.push_back(
          {"1.2a", "1.2.b_p_b_m_exchanged", [=] { return VecX(r.b_m - r.H_pm * r.H_mm_inverse * r.b_p); }});
    }
    return mistakes;
  }

  static std::function<MatXX()> Step(const VecX& x_p, const VecX& x_m) {
    VecX x(x_p.size() + x_m.size());
    x << x_p, x_m;
    return [x] { return x; };
  }

  std::vector<Mistake> StepMistakes() const {
    const Parts r = Right();
    const VecX x_p = Solve(r.Schur(), r.Reduced());
    std::vector<Mistake> mistakes = LandmarkMistakes(r, x_p);
    for (const DampingMistake& damping_mistake : DampingMistakes()) {
      const VecX wrong = Solve(damping_mistake.H, system.b);
      mistakes.push_back({damping_mistake.todo, damping_mistake.cause, [=] { return wrong; }});
      const MatXX H_mm_inverse = Parts(damping_mistake.H, system.b, p).H_mm_inverse;
      mistakes.push_back({"1.2c", Text("1.2.right_for_poses", {{"cause", damping_mistake.cause}}),
                          Step(x_p, H_mm_inverse * (r.b_m - r.H_pm.transpose() * x_p))});
    }
    return mistakes;
  }

  /// Where the poses' step is right.
  std::vector<Mistake> LandmarkMistakes(const Parts& r, const VecX& x_p) const {
    const VecX H_mp_x = r.H_pm.transpose() * x_p;
    const auto step = [x_p](const VecX& x_m) { return Step(x_p, x_m); };
    std::vector<Mistake> mistakes{
        {"1.2c", "1.2.landmarks_not_hear_poses", step(r.H_mm_inverse * r.b_m)},
        {"1.2c", "1.2.sign_in_landmark_step", step(r.H_mm_inverse * (r.b_m + H_mp_x))},
        {"1.2c", "formula.sign_of_landmark_step", step(-r.H_mm_inverse * (r.b_m - H_mp_x))},
        {"1.2c", Text("formula.missing_leaves", {{"this", Word("H_mm⁻¹")}, {"that", Word("b_m − H_mp Δx_p")}}),
         step(r.b_m - H_mp_x)},
        {"1.2c", Text("formula.inverse_meant", {{"matrix", Word("H_mm")}}), step(r.H_mm * (r.b_m - H_mp_x))},
        {"1.2c", Text("formula.missing_leaves", {{"this", Word("b_m")}, {"that", Word("−H_mm⁻¹ H_mp Δx_p")}}),
         step(-r.H_mm_inverse * H_mp_x)},
        {"1.2c", "1.2.H_mminv_applied_b_m_only", step(r.H_mm_inverse * r.b_m - H_mp_x)},
        {"1.2c", "1.2.landmarks_not_move", step(VecX::Zero(r.b_m.size()))},
        {"1.2c", "1.2.sign_b_m", step(r.H_mm_inverse * (-r.b_m - H_mp_x))},
        {"1.2c", Text("formula.b_p_for_step", {{"step", Word("Δx_p")}}),
         step(r.H_mm_inverse * (r.b_m - r.H_pm.transpose() * r.b_p))},
        {"1.2c", "1.2.poses_reduced_b_for_step_dx_p",
         step(r.H_mm_inverse * (r.b_m - r.H_pm.transpose() * r.Reduced()))},
        {"1.2c", "1.2.H_mminv_acts_once_more_b_m", step(r.H_mm_inverse * (r.H_mm_inverse * r.b_m - H_mp_x))},
        {"1.2c", "1.2.H_mminv_acts_once_more_step", step(r.H_mm_inverse * (r.b_m - r.H_mm_inverse * H_mp_x))},
        {"1.2c", "1.2.H_mminv_applied_to_product_only", step(r.b_m - r.H_mm_inverse * H_mp_x)},
        {"1.2c", "1.2.H_mminv_acts_twice_on_step", step(r.H_mm_inverse * (r.H_mm_inverse * (r.b_m - H_mp_x)))},
        {"1.2c", "1.2.H_mm_only_diagonal_inverted",
         step(r.H_mm.diagonal().cwiseInverse().cwiseProduct(r.b_m - H_mp_x))},
        {"1.2c", "1.2.b_m_at_wrong_place", step(r.H_mm_inverse * (system.b.head(r.b_m.size()) - H_mp_x))},
        {"1.2c", "1.2.b_m_at_wrong_place", step(r.H_mm_inverse * (StartingAtItsLength(r.b_m.size()) - H_mp_x))}};
    if (r.b_p.size() == r.b_m.size()) {  // here Eigen does not see it
      mistakes.push_back({"1.2c", "1.2.H_pm_for_H_mp", step(r.H_mm_inverse * (r.b_m - r.H_pm * x_p))});
      mistakes.push_back(
          {"1.2c", "1.2.poses_reduced_b_for_landmarks_b_m", step(r.H_mm_inverse * (r.Reduced() - H_mp_x))});
    }
    return mistakes;
  }
};

}  // namespace ch5::homework::stage_1_2
