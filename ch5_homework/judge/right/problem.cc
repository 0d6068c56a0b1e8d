/// Stages 1.2 and 2.

#include "ch5_homework/judge/right/formulas.h"

#include "ch5_backend/math/psd.h"

namespace ch5::homework::right {

using formula::Inverse;
using formula::Matrix;
using formula::Named;
using formula::Source;
using formula::Stack;
using formula::Value;
using formula::WrittenAt;

SchurSolve::SchurSolve(const System& system, const Ordering& ordering, double lambda, Damping damping) {
  const int p = ordering.dim_poses, n = ordering.Size(), m = n - p;
  const Damping other = damping == Damping::kIdentity ? Damping::kDiagonal : Damping::kIdentity;
  const MatXX damped = Damped(system.H, lambda, damping);
  const std::vector<Part> parts = PartsOf(ordering);
  const Source H("H", damped,
                 {{"1.2.without_lambda", system.H},
                  {"1.2.with_lambda_twice", 2.0 * damped - system.H},
                  {"1.2.with_other_damping", Damped(system.H, lambda, other)}},
                 parts);
  const Source rhs("b_", system.b, {}, parts);

  const Expression H_pp = H.Block("H_pp", 0, 0, p, p, "1.2b"), H_pm = H.Block("H_pm", 0, p, p, m, "1.2a"),
                   H_mp = H.Block("H_mp", p, 0, m, p, "1.2a"), H_mm = H.Block("H_mm", p, p, m, m, "1.2a"),
                   b_p = rhs.Segment("b_p", 0, p, "1.2a"), b_m = rhs.Segment("b_m", p, m, "1.2a");
  const Expression H_mm_inverse = WrittenAt("1.2d 1.2b", Inverse(H_mm, SizesOf(ordering.landmarks)));
  const Expression tempH = Named(H_pm * H_mm_inverse, "tempH");

  S = {WrittenAt("1.2b", H_pp - H_pm * H_mm_inverse * H_mp), {tempH, b_p}};
  b_S = {WrittenAt("1.2b", b_p - H_pm * H_mm_inverse * b_m)};
  S.rows = b_S.rows = {parts.begin(), parts.begin() + static_cast<ptrdiff_t>(ordering.poses.size())};

  const Expression x_p = Matrix("Δx_p", Solve(Value(S.right), Value(b_S.right)));
  const Expression of_landmarks =
      WrittenAt("1.2c", WrittenAt("1.2c", Inverse(H_mm, SizesOf(ordering.landmarks))) * (b_m - H_mp * x_p));
  const Expression dense = Inverse(H.Block("H", 0, 0, n, n, "1.2a")) * rhs.Segment("b_", 0, n, "1.2b");
  delta_x = {Stack({x_p, of_landmarks}), {b_p, Named(b_S.right, "b_pp_schur_"), H_pm, tempH}, {dense}};
}

Prior::Prior(const System& moved, const System& given, int dim) {
  const Eigen::Index m = dim, n = moved.H.rows() - m;
  const Source H_marg("H_marg", moved.H, {{"2.before_the_move", given.H}});
  const Source b_marg("b_marg", moved.b, {{"2.before_the_move", given.b}});

  const Expression A_rr = H_marg.Block("A_rr", 0, 0, n, n, "2c"), A_rm = H_marg.Block("A_rm", 0, n, n, m, "2c"),
                   A_mr = H_marg.Block("A_mr", n, 0, m, n, "2c"), A_mm = H_marg.Block("A_mm", n, n, m, m, "2e 2d"),
                   b_r = b_marg.Segment("b_r", 0, n), b_m = b_marg.Segment("b_m", n, m);
  const Expression A_mm_inverse = WrittenAt("2e 2d", Inverse(A_mm));
  const Expression tempB = Named(A_rm * A_mm_inverse, "tempB");

  H = {A_rr - A_rm * A_mm_inverse * A_mr,
       {tempB, Matrix("H_marg", moved.H), Matrix("(H⁻¹)_rr", PseudoInversePsd(moved.H).topLeftCorner(n, n))}};
  b = {b_r - A_rm * A_mm_inverse * b_m, {tempB, Matrix("b_marg", moved.b)}};
  b.beside.push_back(Named(Inverse(Named(H.right, "H_prior")) * b.right, "H_prior⁻¹ b_prior"));
}

}  // namespace ch5::homework::right
