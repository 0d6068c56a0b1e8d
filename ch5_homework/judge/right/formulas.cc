#include "ch5_homework/judge/right/formulas.h"

#include "ch5_backend/dense/dense_solvers.h"
#include "ch5_backend/marginalize/square_root.h"
#include "ch5_backend/math/psd.h"

namespace ch5::homework::right {

using formula::Assembly;
using formula::Inverse;
using formula::Matrix;
using formula::MistakenFor;
using formula::Named;
using formula::Seen;
using formula::Share;
using formula::Source;
using formula::Stack;
using formula::Transpose;
using formula::Value;
using formula::WrittenAt;

namespace {

std::vector<int> SizesOf(const std::vector<std::shared_ptr<Vertex>>& vertices) {
  std::vector<int> sizes;
  for (const auto& vertex : vertices) sizes.push_back(vertex->LocalDimension());
  return sizes;
}

}  // namespace

std::vector<Part> PartsOf(const Ordering& ordering, bool numbered) {
  std::vector<Part> parts;
  Eigen::Index begin = 0;
  for (const auto* vertices : {&ordering.poses, &ordering.landmarks}) {
    const char* const role = vertices == &ordering.poses ? "scene.pose" : "scene.landmark";
    for (size_t k = 0; k < vertices->size(); ++k) {
      const Vertex& vertex = *(*vertices)[k];
      parts.push_back({numbered ? Text(role, {{"n", Word(k)}}) : Word(vertex.Name()), begin, vertex.LocalDimension()});
      begin += vertex.LocalDimension();
    }
  }
  return parts;
}

MatXX Damped(const MatXX& H, double lambda, Damping damping) {
  MatXX damped = H;
  for (Eigen::Index i = 0; i < H.rows(); ++i) damped(i, i) += lambda * DampingEntry(damping, H(i, i));
  return damped;
}

VecX Solve(const MatXX& A, const VecX& b) {
  VecX x = VecX::Zero(b.size());
  if (b.size() > 0) SolveLdlt(A, b, &x);
  return x;
}

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
  const Source b_("b_", system.b, {}, parts);

  const Expression H_pp = H.Block("H_pp", 0, 0, p, p, "1.2b"), H_pm = H.Block("H_pm", 0, p, p, m, "1.2a"),
                   H_mp = H.Block("H_mp", p, 0, m, p, "1.2a"), H_mm = H.Block("H_mm", p, p, m, m, "1.2a"),
                   b_p = b_.Segment("b_p", 0, p, "1.2a"), b_m = b_.Segment("b_m", p, m, "1.2a");
  const Expression H_mm_inverse = WrittenAt("1.2d 1.2b", Inverse(H_mm, SizesOf(ordering.landmarks)));
  const Expression tempH = Named(H_pm * H_mm_inverse, "tempH");

  S = {WrittenAt("1.2b", H_pp - H_pm * H_mm_inverse * H_mp), {tempH, b_p}};
  b_S = {WrittenAt("1.2b", b_p - H_pm * H_mm_inverse * b_m)};
  S.rows = b_S.rows = {parts.begin(), parts.begin() + static_cast<ptrdiff_t>(ordering.poses.size())};

  const Expression x_p = Matrix("Δx_p", Solve(Value(S.right), Value(b_S.right)));
  const Expression of_landmarks =
      WrittenAt("1.2c", WrittenAt("1.2c", Inverse(H_mm, SizesOf(ordering.landmarks))) * (b_m - H_mp * x_p));
  const Expression dense = Inverse(H.Block("H", 0, 0, n, n, "1.2a")) * b_.Segment("b_", 0, n, "1.2b");
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

SchurUpdate::SchurUpdate(const MatXX& V_given, const MatXX& W_given, const VecX& b_b_given, const MatXX& U_given,
                         const VecX& b_a_given) {
  const Expression V = Matrix("V", V_given), W = Matrix("W", W_given), b_b = Matrix("b_b", b_b_given),
                   U_before = Matrix("U", U_given), b_a_before = Matrix("b_a", b_a_given);
  const Expression V_inv_sqrt = Matrix("V_inv_sqrt", PseudoInverseSquareRoot(V_given), "5.5 5.2");
  const Expression M = Named(W * V_inv_sqrt, "M"), V_inverse = WrittenAt("5.5 5.2", Inverse(V));
  const Expression L_inverse = Matrix("L⁻¹", MatXX(V_given.llt().matrixL()).inverse());

  U = {U_before - M * Transpose(M), {V, Named(V_inverse, "V⁻¹"), L_inverse}, {U_before - W * V_inverse * Transpose(W)}};
  b_a = {b_a_before - M * Transpose(V_inv_sqrt) * b_b, {V, b_a_before}, {b_a_before - W * V_inverse * b_b}};
}

SquareRoot::SquareRoot(const MatXX& H, const VecX& b0) : p(ScalingOf(H)) {
  const ScaledEigen eigen = DecomposeScaled(H, p.cwiseInverse());
  const auto diagonal = [](const char* name, const VecX& entries) { return Matrix(name, entries.asDiagonal()); };
  const Expression P = diagonal("P", p), P_inverse = diagonal("P⁻¹", p.cwiseInverse()), U = Matrix("U", eigen.U),
                   S_sqrt = diagonal("S^½", eigen.S_sqrt), S_pinv_sqrt = diagonal("S^-½", eigen.S_pinv_sqrt),
                   S = diagonal("S", eigen.S_sqrt.cwiseAbs2()), S_pinv = diagonal("S⁻¹", eigen.S_pinv_sqrt.cwiseAbs2());
  const Expression J = Named(Transpose(P * U * S_sqrt), "J"),
                   J_pinv_T = Named(S_pinv_sqrt * Transpose(U) * P_inverse, "(Jᵀ)⁺");

  const MatXX scale = p.cwiseInverse().asDiagonal();
  JtJ.right = Seen(J, [scale](const MatXX& any) { return MatXX(scale * any.transpose() * any * scale); });
  JtJ.beside = {P_inverse,
                S_pinv_sqrt,
                S,
                Matrix("H", H),
                diagonal("P^½", p.cwiseSqrt()),
                diagonal("S^¼", eigen.S_sqrt.cwiseSqrt())};
  const MatXX scaled_Jt = scale * Value(J).transpose();
  Jte0.right = Seen(-(J_pinv_T * Matrix("b₀", b0)), [scaled_Jt](const MatXX& e0) {
    return e0.rows() == scaled_Jt.cols() ? MatXX(scaled_Jt * e0) : MatXX();
  });
  Jte0.beside = {P, S_sqrt, S_pinv, J};
}

Formula Residual(const MatXX& J, const VecX& e0, const VecX& delta_chi) {
  return {Matrix("e₀", e0) + Matrix("J", J) * Matrix("Δχ", delta_chi)};
}

namespace {

/// Which poses see which landmarks, and the blocks of both.
struct Sights {
  const MatXX &damped, &undamped;
  const VecX& b;
  const Ordering& ordering;

  MatXX Block(const MatXX& H, const Vertex& a, const Vertex& c) const {
    return H.block(a.OrderingId(), c.OrderingId(), a.LocalDimension(), c.LocalDimension());
  }
  bool Sees(const Vertex& pose, const Vertex& landmark) const { return !Block(damped, pose, landmark).isZero(0.0); }

  /// The factors of the pair (i, j), by the names of the loop.
  struct Factors {
    Expression H_il, H_jl, H_ll_inverse, b_l;
  };
  Factors Of(const Vertex& i, const Vertex& j, const Vertex& l) const {
    const Expression H_il = Matrix("H_il", Block(damped, i, l)), H_jl = Matrix("H_jl", Block(damped, j, l)),
                     H_ll = Matrix("H_ll", Block(damped, l, l)),
                     undamped_H_ll = Matrix("H_ll (λ = 0)", Block(undamped, l, l));
    return {MistakenFor(H_il, {H_jl}), MistakenFor(H_jl, {H_il}), Inverse(MistakenFor(H_ll, {undamped_H_ll})),
            Matrix("b_l", b.segment(l.OrderingId(), l.LocalDimension()))};
  }

  /// with(i, pose, l, landmark)
  template <typename Do>
  void ForEach(const Do& with) const {
    for (size_t l = 0; l < ordering.landmarks.size(); ++l) {
      for (size_t i = 0; i < ordering.poses.size(); ++i) {
        const Vertex &pose = *ordering.poses[i], &landmark = *ordering.landmarks[l];
        if (Sees(pose, landmark)) with(i, pose, l, landmark);
      }
    }
  }
};

std::vector<Text> NumberZero(size_t i, size_t l) {
  std::vector<Text> kinds;
  if (i == 0) kinds.push_back({"7.products_of", {{"it", {"scene.pose", {{"n", Word(0)}}}}}});
  if (l == 0) kinds.push_back({"7.products_of", {{"it", {"scene.landmark", {{"n", Word(0)}}}}}});
  return kinds;
}

Expression SchurLoop(const Sights& sights, const MatXX& H_pp) {
  std::vector<Share> shares{{Matrix("H_pp", H_pp), {0, 0}}};
  sights.ForEach([&](size_t i, const Vertex& pose, size_t l, const Vertex& landmark) {
    for (size_t j = 0; j <= i; ++j) {
      const Vertex& other = *sights.ordering.poses[j];
      if (!sights.Sees(other, landmark)) continue;
      const auto of = sights.Of(pose, other, landmark);
      const Expression product = -(of.H_il * of.H_ll_inverse * Transpose(of.H_jl));
      std::vector<Text> kinds = NumberZero(i, l);
      kinds.insert(kinds.begin(), i == j ? "7.products_on_the_diagonal" : "7.products_off_the_diagonal");
      shares.push_back({product, {pose.OrderingId(), other.OrderingId()}, {}, kinds});
      if (i != j) shares.push_back({Transpose(product), {other.OrderingId(), pose.OrderingId()}, {}, kinds});
    }
  });
  return Assembly("S", H_pp.rows(), H_pp.cols(), shares);
}

Expression ReducedLoop(const Sights& sights, const VecX& b_p) {
  std::vector<Share> shares{{Matrix("b_p", b_p), {0, 0}}};
  sights.ForEach([&](size_t i, const Vertex& pose, size_t l, const Vertex& landmark) {
    const auto of = sights.Of(pose, pose, landmark);
    const int number = static_cast<int>(i);
    shares.push_back({-(of.H_il * of.H_ll_inverse * of.b_l),
                      {pose.OrderingId(), 0},
                      {},
                      NumberZero(i, l),
                      {{"7.pose_number_for_row", {number, 0}}, {"7.six_rows_each", {6 * number, 0}}}});
  });
  return Assembly("b_schur_", b_p.size(), 1, shares);
}

}  // namespace

BlockSolve::BlockSolve(const System& system, const Ordering& ordering, double lambda, Damping damping) {
  const int p = ordering.dim_poses, m = ordering.Size() - p;
  const MatXX damped = Damped(system.H, lambda, damping);
  const std::vector<Part> parts = PartsOf(ordering, true);
  const std::vector<int> sizes = SizesOf(ordering.landmarks);
  const Source H("H", damped, {{"7.without_lambda", system.H}}, parts), b_("b_", system.b, {}, parts);

  const Expression H_pp = H.Block("H_pp", 0, 0, p, p), H_pl = H.Block("H_pl", 0, p, p, m),
                   H_lp = H.Block("H_plᵀ", p, 0, m, p), H_ll = H.Block("H_ll", p, p, m, m),
                   b_p = b_.Segment("b_p", 0, p), b_l = b_.Segment("b_l", p, m);
  const Sights sights{damped, system.H, system.b, ordering};
  S = {H_pp - H_pl * Inverse(H_ll, sizes) * H_lp, {}, {SchurLoop(sights, Value(H_pp))}};
  b_S = {b_p - H_pl * Inverse(H_ll, sizes) * b_l, {}, {ReducedLoop(sights, Value(b_p))}};
  S.rows = b_S.rows = {parts.begin(), parts.begin() + static_cast<ptrdiff_t>(ordering.poses.size())};

  const Expression x_p = Matrix("Δx_p", Solve(Value(S.right), Value(b_S.right)));
  const Expression K_transposed = Named(Inverse(H_ll, sizes) * H_lp, "K_ilᵀ");
  delta_x = {Stack({x_p, Inverse(H_ll, sizes) * (b_l - H_lp * x_p)}),
             {b_p, Named(b_S.right, "b_schur_"), K_transposed}};
}

}  // namespace ch5::homework::right
