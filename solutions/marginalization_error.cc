// Homework of chapter 5, stage 5: OKVIS's marginalization.  Handout: ch5_homework/handout/stage_5.md, .zh.md.
#include "ch5_backend/marginalize/marginalization_error.h"

#include "ch5_backend/homework_missing.h"
#include "ch5_backend/marginalize/square_root.h"

namespace ch5 {

// ---- Stage 5:  H δχ = b₀ − H Δχ,  which grows, shrinks and becomes a residual ------------------------------------

// Stage 5.1: room for a new block
//
//   pose:      | H_00   0   H_01 |          landmark:   | H_00  H_01   0  |
//              |  0    new   0   |                      | H_01ᵀ H_11   0  |
//              | H_01ᵀ  0   H_11 |                      |  0     0    new |

int MarginalizationError::InsertBlock(int dim, bool is_landmark) {
  const int size = static_cast<int>(H_.rows());
  const int idx = is_landmark ? size : dense_size_;  // the first row of the new block
  const int tail = size - idx;                       // how many rows have to make room
  MatXX H = MatXX::Zero(size + dim, size + dim);
  VecX b0 = VecX::Zero(size + dim);
  // TODO:: home work 5.1. Copy the four parts of H_ and the two parts of b0_ around the new, empty rows and columns.
  // BEGIN SOLUTION 5.1 InsertBlock, the parts around the new block
  H.block(0, 0, idx, idx) = H_.block(0, 0, idx, idx);
  H.block(0, idx + dim, idx, tail) = H_.block(0, idx, idx, tail);
  H.block(idx + dim, 0, tail, idx) = H_.block(idx, 0, tail, idx);
  H.block(idx + dim, idx + dim, tail, tail) = H_.block(idx, idx, tail, tail);
  b0.segment(0, idx) = b0_.segment(0, idx);
  b0.segment(idx + dim, tail) = b0_.segment(idx, tail);
  // BLANK
  // H.block(0, 0, idx, idx) = H_.block(?, ?, ?, ?);
  // H.block(?, ?, ?, ?) = H_.block(?, ?, ?, ?);
  // H.block(?, ?, ?, ?) = H_.block(?, ?, ?, ?);
  // H.block(?, ?, ?, ?) = H_.block(?, ?, ?, ?);
  // b0.segment(?, ?) = b0_.segment(?, ?);
  // b0.segment(?, ?) = b0_.segment(?, ?);
  // END SOLUTION
  H_ = H;
  b0_ = b0;
  return idx;
}

// Stage 5.2: the Schur complement

void MarginalizationError::SchurComplement(const MatXX& V, const MatXX& W, const VecX& b_b, MatXX* U, VecX* b_a) {
  MatXX V_inv_sqrt;  // V_inv_sqrt V_inv_sqrtᵀ stands for V⁻¹
  // BEGIN DEEP 5.5 SchurComplement, a root of the pseudo-inverse
  V_inv_sqrt = PseudoInverseSquareRoot(V);
  // BLANK
  // TODO:: home work 5.5. With V = E S Eᵀ of DecomposeSymmetric, whose .V is E: E S^-½, and 0 where S ≤ ε·m·S_max, with
  // the machine's ε and m = V.rows().
  // END DEEP
  // TODO:: home work 5.2. With M = W V_inv_sqrt:  U ← U − M Mᵀ,  b_a ← b_a − M V_inv_sqrtᵀ b_b.
  // BEGIN SOLUTION 5.2 SchurComplement
  const MatXX M = W * V_inv_sqrt;
  U->noalias() -= M * M.transpose();
  b_a->noalias() -= M * (V_inv_sqrt.transpose() * b_b);
  // BLANK
  // const MatXX M = ?;
  // *U -= ?;
  // *b_a -= ?;
  // END SOLUTION
}

// Stage 5.3: H = JᵀJ, e₀ = −(Jᵀ)⁺ b₀

void MarginalizationError::UpdateErrorComputation() {
  VecX p;  // P = diag(p)
  // BEGIN DEEP 5.6 UpdateErrorComputation, the scaling
  p = ScalingOf(H_);
  // BLANK
  // TODO:: home work 5.6. What makes the diagonal of P⁻¹ H P⁻¹ one; 1e-3 where H_ii ≤ 1e-9.
  // END DEEP
  const VecX p_inverse = p.cwiseInverse();
  // P⁻¹ H P⁻¹ = U S Uᵀ; the eigenvalues that are zero to rounding are zero in S_sqrt and in its pseudo-inverse.
  const ScaledEigen eigen = DecomposeScaled(H_, p_inverse);
  const MatXX& U = eigen.U;
  const VecX& S_sqrt = eigen.S_sqrt;
  VecX S_pinv_sqrt;
  // BEGIN DEEP 5.7 UpdateErrorComputation, the pseudo-inverse of S^½
  S_pinv_sqrt = eigen.S_pinv_sqrt;
  // BLANK
  // TODO:: home work 5.7. From S_sqrt alone: 1/S^½, and 0 where S^½ is 0.
  // END DEEP
  // TODO:: home work 5.3. J = (P U S^½)ᵀ,  (Jᵀ)⁺ = S^-½ Uᵀ P⁻¹,  e₀ = −(Jᵀ)⁺ b₀.
  // BEGIN SOLUTION 5.3 UpdateErrorComputation
  J_ = (p.asDiagonal() * U * S_sqrt.asDiagonal()).transpose();
  const MatXX J_pinv_T = S_pinv_sqrt.asDiagonal() * U.transpose() * p_inverse.asDiagonal();
  e0_ = -J_pinv_T * b0_;
  // BLANK
  // J_ = ?;
  // const MatXX J_pinv_T = ?;
  // e0_ = ?;
  // END SOLUTION
}

// Stage 5.4: the residual moves with the states

VecX MarginalizationError::Residual(const VecX& delta_chi) const {
  VecX e;
  // TODO:: home work 5.4. e = e₀ + J Δχ.
  // BEGIN SOLUTION 5.4 Residual
  e = e0_ + J_ * delta_chi;
  // BLANK
  // e = ?;
  // END SOLUTION
  return e;
}

}  // namespace ch5
