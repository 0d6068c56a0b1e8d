#include "ch5_backend/marginalize/marginalization_info.h"

#include "ch5_backend/marginalize/square_root.h"

namespace ch5 {
namespace {

// The pseudo-inverse of VINS: eigenvalues ≤ eps count as zero. V S⁺ Vᵀ = (S^½Vᵀ)⁺ ((S^½Vᵀ)⁺)ᵀ
MatXX PseudoInverse(const MatXX& A, double eps) {
  const EigenPairs eigen = DecomposeSymmetric(A);
  const VecX S_inverse = (eigen.S.array() > eps).select(eigen.S.array().inverse(), 0.0);
  return eigen.V * S_inverse.asDiagonal() * eigen.V.transpose();
}

}  // namespace

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
  const MatXX A_mm_inv = PseudoInverse(A_mm, kEps);
  const MatXX A_rm_A_mm_inv = A_.bottomLeftCorner(n_, m_) * A_mm_inv;
  const MatXX A_r = A_.bottomRightCorner(n_, n_) - A_rm_A_mm_inv * A_.topRightCorner(m_, n_);
  const VecX b_r = b_.tail(n_) - A_rm_A_mm_inv * b_.head(m_);

  // A_r = V S Vᵀ,  J = S^½ Vᵀ,  r₀ = S^-½ Vᵀ b_r
  const EigenPairs eigen = DecomposeSymmetric(A_r);
  const auto kept = eigen.S.array() > kEps;
  const VecX S_sqrt = kept.select(eigen.S.array().max(0.0).sqrt(), 0.0);
  const VecX S_inv_sqrt = kept.select(eigen.S.array().max(kEps).rsqrt(), 0.0);
  linearized_jacobians_ = S_sqrt.asDiagonal() * eigen.V.transpose();
  linearized_residuals_ = S_inv_sqrt.asDiagonal() * (eigen.V.transpose() * b_r);
}

}  // namespace ch5
