#pragma once
/// What typical mistakes in SolveLinearSystem make of S, of the reduced right-hand side and of Δx.

#include <algorithm>
#include <string>
#include <vector>

#include "ch5_backend/linear/dense_solvers.h"
#include "ch5_backend/math/psd.h"
#include "ch5_homework/judge/narrate.h"
#include "ch5_homework/judge/scenes.h"

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
  const char* cause;
  MatXX H;
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
    return {{"λ is missing: the blocks come from the undamped Hessian_ instead of H", system.H},
            {"λ is missing on the landmarks: H_mm must be damped before it is inverted (take it from H)", damp(1, 0)},
            {"λ is missing on the poses: the corner H_pp comes from the undamped Hessian_ instead of H", damp(0, 1)},
            {"λ is added twice to the poses: H is damped already", damp(2, 1)},
            {"λ is added twice: H is damped already", damp(2, 2)},
            {"λ is added twice to the landmarks: H is damped already", damp(1, 2)},
            {damping == Damping::kIdentity ? "the damping is λ·diag(H), but λ·I was asked: use DampedHessian"
                                           : "the damping is λ·I, but λ·diag(H) was asked: use DampedHessian",
             Damp(system.H, p, lambda, lambda, other)}};
  }

  /// segment(n, n) of b, as far as b reaches; otherwise zero.
  VecX StartingAtItsLength(Eigen::Index n) const {
    return 2 * n <= system.b.size() ? VecX(system.b.segment(n, n)) : VecX(VecX::Zero(n));
  }

  std::vector<Mistake> SchurMistakes() const {
    const Parts r = Right();
    std::vector<Mistake> mistakes{
        {"1.2b", "the sign: H_pm H_mm⁻¹ H_mp is added, not subtracted",
         [=] { return MatXX(r.H_pp + r.H_pm * r.H_mm_inverse * r.H_pm.transpose()); }},
        {"1.2b", "nothing is subtracted: this is H_pp alone", [=] { return r.H_pp; }},
        {"1.2b", "H_mm⁻¹ is missing in H_pm H_mm⁻¹ H_mp", [=] { return MatXX(r.H_pp - r.H_pm * r.H_pm.transpose()); }},
        {"1.2b", "H_mm stands where its inverse is meant",
         [=] { return MatXX(r.H_pp - r.H_pm * r.H_mm * r.H_pm.transpose()); }},
        {"1.2b", "H_mm⁻¹ acts twice: tempH is H_pm H_mm⁻¹ already",
         [=] { return MatXX(r.H_pp - r.H_pm * r.H_mm_inverse * r.H_mm_inverse * r.H_pm.transpose()); }},
        {"1.2b", "H_pp is missing: this is −H_pm H_mm⁻¹ H_mp alone", [=] { return MatXX(r.Schur() - r.H_pp); }},
        {"1.2b", "H_pp is missing: this is H_pm H_mm⁻¹ H_mp alone", [=] { return MatXX(r.H_pp - r.Schur()); }},
        {"1.2b", "of H_mm only the diagonal is inverted: its blocks are larger where landmarks are points", [=] {
           const MatXX inverse = r.H_mm.diagonal().cwiseInverse().asDiagonal();
           return MatXX(r.H_pp - r.H_pm * inverse * r.H_pm.transpose());
         }}};
    for (const Mistake& mistake : CornerMistakes(r)) mistakes.push_back(mistake);
    for (const DampingMistake& damping_mistake : DampingMistakes()) {
      const MatXX wrong = Parts(damping_mistake.H, system.b, p).Schur();
      mistakes.push_back({"1.2a", damping_mistake.cause, [=] { return wrong; }});
    }
    return mistakes;
  }

  /// One corner of H stands where another is meant.
  static std::vector<Mistake> CornerMistakes(const Parts& r) {
    std::vector<Mistake> mistakes{
        {"1.2a", "Hpm (or Hmp) starts at the wrong row or column: it is read from the poses' own corner of H",
         [=] {
           const MatXX corner = r.H_pp.leftCols(std::min(r.H_pp.cols(), r.H_pm.cols()));
           if (corner.cols() < r.H_pm.cols()) return r.H_pp;
           return MatXX(r.H_pp - r.H_pm * r.H_mm_inverse * corner.transpose());
         }},
        {"1.2a", "Hpm (or Hmp) starts at the wrong row or column: it is read from the poses' own corner of H", [=] {
           const MatXX corner = r.H_pp.leftCols(std::min(r.H_pp.cols(), r.H_pm.cols()));
           if (corner.cols() < r.H_pm.cols()) return r.H_pp;
           return MatXX(r.H_pp - corner * r.H_mm_inverse * r.H_pm.transpose());
         }}};
    if (r.H_pm.rows() == r.H_pm.cols()) {  // here an exchange of p and m goes unseen by Eigen
      const MatXX Q = r.H_pm.transpose();
      mistakes.push_back({"1.2a", "H_pm and H_mp are exchanged: H_pm is at the top right, rows of poses",
                          [=] { return MatXX(r.H_pp - Q * r.H_mm_inverse * r.H_pm); }});
      mistakes.push_back({"1.2a", "H_mp holds H_pm: H_mp is at the bottom left, rows of landmarks",
                          [=] { return MatXX(r.H_pp - r.H_pm * r.H_mm_inverse * r.H_pm); }});
      mistakes.push_back({"1.2a", "H_pm holds H_mp: H_pm is at the top right, rows of poses",
                          [=] { return MatXX(r.H_pp - Q * r.H_mm_inverse * Q); }});
      mistakes.push_back({"1.2b", "the corner of the landmarks, H_mm, stands where the poses' H_pp is meant",
                          [=] { return MatXX(r.H_mm - r.H_pm * r.H_mm_inverse * Q); }});
    }
    return mistakes;
  }

  std::vector<Mistake> ReducedMistakes() const {
    const Parts r = Right();
    std::vector<Mistake> mistakes{
        {"1.2b", "the right-hand side is not reduced: H_pm H_mm⁻¹ b_m is not subtracted", [=] { return r.b_p; }},
        {"1.2b", "the sign: H_pm H_mm⁻¹ b_m is added, not subtracted",
         [=] { return VecX(r.b_p + r.H_pm * r.H_mm_inverse * r.b_m); }},
        {"1.2b", "H_mm⁻¹ is missing in H_pm H_mm⁻¹ b_m", [=] { return VecX(r.b_p - r.H_pm * r.b_m); }},
        {"1.2b", "b_p is missing: this is −H_pm H_mm⁻¹ b_m alone", [=] { return VecX(r.Reduced() - r.b_p); }},
        {"1.2b", "b_p is missing: this is H_pm H_mm⁻¹ b_m alone", [=] { return VecX(r.b_p - r.Reduced()); }},
        {"1.2b", "H_mm⁻¹ acts twice: tempH is H_pm H_mm⁻¹ already",
         [=] { return VecX(r.b_p - r.H_pm * r.H_mm_inverse * r.H_mm_inverse * r.b_m); }},
        {"1.2a", "bpp starts at its own length: segment(where it starts, how long it is), and b_p starts at 0",
         [=] { return VecX(StartingAtItsLength(r.b_p.size()) - r.H_pm * r.H_mm_inverse * r.b_m); }},
        {"1.2a",
         "bmm starts at its own length: segment(where it starts, how long it is), and b_m starts at reserve_size",
         [=] { return VecX(r.b_p - r.H_pm * r.H_mm_inverse * StartingAtItsLength(r.b_m.size())); }},
        {"1.2a", "bpp and bmm start at their own lengths: segment(where it starts, how long it is)",
         [=] {
           return VecX(StartingAtItsLength(r.b_p.size()) - r.H_pm * r.H_mm_inverse * StartingAtItsLength(r.b_m.size()));
         }},
        {"1.2a", "the signs of both segments: b_p and b_m are those of b_ as they are",
         [=] { return VecX(-r.Reduced()); }},
        {"1.2a",
         "the beginning of b, the poses' part, stands where the landmarks' is meant; that starts at reserve_size",
         [=] { return VecX(r.b_p - r.H_pm * r.H_mm_inverse * system.b.head(r.b_m.size())); }}};
    if (r.b_p.size() == r.b_m.size()) {
      mistakes.push_back(
          {"1.2a", "b_p and b_m are exchanged", [=] { return VecX(r.b_m - r.H_pm * r.H_mm_inverse * r.b_p); }});
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
      mistakes.push_back({"1.2a", damping_mistake.cause, [=] { return wrong; }});
      const MatXX H_mm_inverse = Parts(damping_mistake.H, system.b, p).H_mm_inverse;
      mistakes.push_back({"1.2c", "the poses are right; for the landmarks " + std::string(damping_mistake.cause),
                          Step(x_p, H_mm_inverse * (r.b_m - r.H_pm.transpose() * x_p))});
    }
    return mistakes;
  }

  /// Where the poses' step is right.
  std::vector<Mistake> LandmarkMistakes(const Parts& r, const VecX& x_p) const {
    const VecX H_mp_x = r.H_pm.transpose() * x_p;
    const auto step = [x_p](const VecX& x_m) { return Step(x_p, x_m); };
    std::vector<Mistake> mistakes{
        {"1.2c", "the landmarks do not hear of the poses: − H_mp Δx_p is missing before H_mm⁻¹ is applied",
         step(r.H_mm_inverse * r.b_m)},
        {"1.2c", "the sign: it is b_m − H_mp Δx_p, not +", step(r.H_mm_inverse * (r.b_m + H_mp_x))},
        {"1.2c", "the sign of the whole landmark step is wrong", step(-r.H_mm_inverse * (r.b_m - H_mp_x))},
        {"1.2c", "H_mm⁻¹ is missing: this is b_m − H_mp Δx_p", step(r.b_m - H_mp_x)},
        {"1.2c", "H_mm stands where its inverse is meant", step(r.H_mm * (r.b_m - H_mp_x))},
        {"1.2c", "b_m is missing: this is −H_mm⁻¹ H_mp Δx_p", step(-r.H_mm_inverse * H_mp_x)},
        {"1.2c", "H_mm⁻¹ is applied to b_m only: the brackets around b_m − H_mp Δx_p are missing",
         step(r.H_mm_inverse * r.b_m - H_mp_x)},
        {"1.2c", "the landmarks do not move: delta_x_ll is zero", step(VecX::Zero(r.b_m.size()))},
        {"1.2c", "the sign of b_m: it is b_m − H_mp Δx_p, with b_m as it is in b_",
         step(r.H_mm_inverse * (-r.b_m - H_mp_x))},
        {"1.2c", "b_p stands where the poses' step Δx_p is meant",
         step(r.H_mm_inverse * (r.b_m - r.H_pm.transpose() * r.b_p))},
        {"1.2c", "the poses' reduced b stands where their step Δx_p is meant",
         step(r.H_mm_inverse * (r.b_m - r.H_pm.transpose() * r.Reduced()))},
        {"1.2c", "H_mm⁻¹ acts once more on b_m: Hmm_inv * (bmm − …), once",
         step(r.H_mm_inverse * (r.H_mm_inverse * r.b_m - H_mp_x))},
        {"1.2c", "the brackets: H_mm⁻¹ is applied to H_mp Δx_p only", step(r.b_m - r.H_mm_inverse * H_mp_x)},
        {"1.2c", "H_mm⁻¹ acts twice", step(r.H_mm_inverse * (r.H_mm_inverse * (r.b_m - H_mp_x)))},
        {"1.2c", "of H_mm only the diagonal is inverted: its blocks are larger where landmarks are points",
         step(r.H_mm.diagonal().cwiseInverse().cwiseProduct(r.b_m - H_mp_x))},
        {"1.2c", "b_m is taken at another place of b_: it starts at reserve_size",
         step(r.H_mm_inverse * (system.b.head(r.b_m.size()) - H_mp_x))},
        {"1.2c", "b_m is taken at another place of b_: it starts at reserve_size",
         step(r.H_mm_inverse * (StartingAtItsLength(r.b_m.size()) - H_mp_x))}};
    if (r.b_p.size() == r.b_m.size()) {  // here Eigen does not see it
      mistakes.push_back({"1.2c", "H_pm stands where H_mp is meant: H_mp has the landmarks' rows",
                          step(r.H_mm_inverse * (r.b_m - r.H_pm * x_p))});
      mistakes.push_back(
          {"1.2c", "the poses' b_p stands where the landmarks' b_m is meant", step(r.H_mm_inverse * (r.b_p - H_mp_x))});
      mistakes.push_back({"1.2c", "the poses' reduced b stands where the landmarks' b_m is meant",
                          step(r.H_mm_inverse * (r.Reduced() - H_mp_x))});
    }
    return mistakes;
  }
};

}  // namespace ch5::homework::stage_1_2
