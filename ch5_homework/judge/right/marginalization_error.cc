/// Stage 5.

#include "ch5_backend/marginalize/square_root.h"
#include "ch5_homework/judge/right/formulas.h"

namespace ch5::homework::right {

OpenedTerm::OpenedTerm(const MatXX& H_given, const VecX& b0_given, int idx, int dim) {
  const int size = static_cast<int>(b0_given.size()), tail = size - idx, end = idx + dim;
  const Source all("H", H_given), rhs("b0", b0_given);
  // What moves has made room at its new place; `unmoved` is where it came from, `exchanged` where its mirror image belongs.
  const auto copied = [](const Expression& x, const Place& place, const Place& unmoved, const Place& exchanged) {
    Share share{x, place, {}, {{"formula.entries_of", {{"block", Word(x->name)}}}}};
    share.elsewhere = {{"5.nothing_made_room", unmoved}, {"5.H_01_H_01T_exchanged", exchanged}};
    return share;
  };
  H = {Assembly("H", size + dim, size + dim,
                {copied(all.Block("H_00", 0, 0, idx, idx), {0, 0}, {0, 0}, {0, 0}),
                 copied(all.Block("H_01", 0, idx, idx, tail), {0, end}, {0, idx}, {end, 0}),
                 copied(all.Block("H_01ᵀ", idx, 0, tail, idx), {end, 0}, {idx, 0}, {0, end}),
                 copied(all.Block("H_11", idx, idx, tail, tail), {end, end}, {idx, idx}, {end, end})})};
  b = {Assembly("b0", size + dim, 1,
                {copied(rhs.Segment("b0_0", 0, idx), {0, 0}, {0, 0}, {0, 0}),
                 copied(rhs.Segment("b0_1", idx, tail), {end, 0}, {idx, 0}, {end, 0})})};
  H.beside = {Matrix("H", H_given)};
  b.beside = {Matrix("b0", b0_given)};
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

}  // namespace ch5::homework::right
