#include "ch5_backend/marginalize/marginalization_info.h"

#include "ch5_backend/marginalize/square_root.h"

namespace ch5 {
void MarginalizationInfo::Marginalize() {
  // A = Σ JᵀW_ρJ,  b = Σ ρ'JᵀWr
  A_ = MatXX::Zero(m_ + n_, m_ + n_);
  b_ = VecX::Zero(m_ + n_);
  for (const auto& [edge, drop_set] : factors_) {
    double drho;
    MatXX W;
    edge->RobustInfo(&drho, &W);
    const auto& vertices = edge->Vertices();
    for (size_t i = 0; i < vertices.size(); ++i) {
      if (vertices[i]->IsFixed()) continue;
      const int idx_i = blocks_.at(vertices[i]->Id()).idx, size_i = vertices[i]->LocalDimension();
      const MatXX JtW = edge->Jacobian(i).transpose() * W;
      for (size_t j = i; j < vertices.size(); ++j) {
        if (vertices[j]->IsFixed()) continue;
        const int idx_j = blocks_.at(vertices[j]->Id()).idx, size_j = vertices[j]->LocalDimension();
        const MatXX block = JtW * edge->Jacobian(j);
        A_.block(idx_i, idx_j, size_i, size_j) += block;
        if (j != i) A_.block(idx_j, idx_i, size_j, size_i) += block.transpose();
      }
      b_.segment(idx_i, size_i) += drho * edge->Jacobian(i).transpose() * edge->Information() * edge->Residual();
    }
  }

  // A_r = A_rr − A_rm A_mm⁺ A_mr,  b_r = b_r − A_rm A_mm⁺ b_m
  const MatXX A_mm = 0.5 * (A_.topLeftCorner(m_, m_) + A_.topLeftCorner(m_, m_).transpose());
  const MatXX A_mm_inv_sqrt = PseudoInverseSquareRoot(A_mm, EigenCut::Vins());
  const MatXX A_mm_inv = A_mm_inv_sqrt * A_mm_inv_sqrt.transpose();
  const MatXX A_rm_A_mm_inv = A_.bottomLeftCorner(n_, m_) * A_mm_inv;
  const MatXX A_r = A_.bottomRightCorner(n_, n_) - A_rm_A_mm_inv * A_.topRightCorner(m_, n_);
  const VecX b_r = b_.tail(n_) - A_rm_A_mm_inv * b_.head(m_);

  // A_r = V S Vᵀ,  J = S^½ Vᵀ,  r₀ = S^-½ Vᵀ b_r;  VINS' b is −b.
  SquareRootForm form = FactorNormalEquations(A_r, -b_r, EigenCut::Vins());
  linearized_jacobians_ = std::move(form.J);
  linearized_residuals_ = std::move(form.r0);
}

}  // namespace ch5
