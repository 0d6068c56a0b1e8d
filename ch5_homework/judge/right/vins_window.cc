/// Stage 6.

#include "ch5_homework/judge/right/formulas.h"

#include "ch5_backend/marginalize/square_root.h"

namespace ch5::homework::right {

using formula::Inverse;
using formula::Matrix;
using formula::Named;
using formula::Seen;
using formula::Source;
using formula::Transpose;
using formula::Value;

namespace {

constexpr double kEps = 1e-8;  // eigenvalues up to it count as zero

Expression Diagonal(const char* name, const VecX& entries) { return Matrix(name, entries.asDiagonal()); }

/// A = V S Vᵀ, and S⁺.
struct CutEigen {
  MatXX V;
  VecX S, S_pinv;

  explicit CutEigen(const MatXX& A) {
    const SymmetricEigen eigen = DecomposeSymmetric(A);
    const auto counts = eigen.S.array() > kEps;
    V = eigen.V;
    S = counts.select(eigen.S, 0.0);
    S_pinv = counts.select(eigen.S.cwiseInverse(), 0.0);
  }
};

}  // namespace

KeptRows::KeptRows(const MatXX& A, const VecX& b, int m) {
  const Eigen::Index n = A.rows() - m;
  const Source all("A_", A), rhs("b_", b);
  const Expression A_rr = all.Block("A_rr", m, m, n, n), A_rm = all.Block("A_rm", m, 0, n, m),
                   A_mr = all.Block("A_mr", 0, m, m, n), A_mm = all.Block("A_mm", 0, 0, m, m),
                   b_r_given = rhs.Segment("b_r", m, n), b_m = rhs.Segment("b_m", 0, m);
  const CutEigen mm(Value(A_mm));
  const Expression V = Matrix("V", mm.V), A_mm_pinv = Named(V * Diagonal("S⁺", mm.S_pinv) * Transpose(V), "A_mm⁺");

  A_r = {A_rr - A_rm * A_mm_pinv * A_mr, {A_mm, Matrix("A_", A)}};
  b_r = {b_r_given - A_rm * A_mm_pinv * b_m, {A_mm, Matrix("b_", b)}};
  if ((mm.S.array() == 0.0).any()) return;  // there A_mm⁻¹ is another matrix
  A_r.as_well = {A_rr - A_rm * Inverse(A_mm) * A_mr};
  b_r.as_well = {b_r_given - A_rm * Inverse(A_mm) * b_m};
}

Factored::Factored(const MatXX& A, const VecX& b) {
  const CutEigen eigen(A);
  eigenvalues = eigen.S;
  cost = b.dot(eigen.V * eigen.S_pinv.asDiagonal() * eigen.V.transpose() * b);
  const Expression V = Matrix("V", eigen.V), S_sqrt = Diagonal("S^½", eigen.S.cwiseSqrt()),
                   S_pinv_sqrt = Diagonal("S^-½", eigen.S_pinv.cwiseSqrt()), A_r = Matrix("A_r", A),
                   S = Diagonal("S", eigen.S), J = Named(S_sqrt * Transpose(V), "J");
  const MatXX Jt = Value(J).transpose();

  JtJ = {Seen(J, [](const MatXX& any) { return MatXX(any.transpose() * any); }),
         {S, S_pinv_sqrt, A_r, Diagonal("S^¼", eigen.S.array().pow(0.25))}};
  Jtr0 = {Seen(S_pinv_sqrt * Transpose(V) * Matrix("b_r", b),
               [Jt](const MatXX& r0) { return r0.rows() == Jt.cols() ? MatXX(Jt * r0) : MatXX(); }),
          {S_sqrt, S, Diagonal("S⁻¹", eigen.S_pinv), Diagonal("S^-¼", eigen.S_pinv.array().pow(0.25)), J}};
}

}  // namespace ch5::homework::right
