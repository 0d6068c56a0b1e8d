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
  // H.block(0, 0, idx, idx) = H_.block(?, ?, ?, ?);
  // H.block(?, ?, ?, ?) = H_.block(?, ?, ?, ?);
  // H.block(?, ?, ?, ?) = H_.block(?, ?, ?, ?);
  // H.block(?, ?, ?, ?) = H_.block(?, ?, ?, ?);
  // b0.segment(?, ?) = b0_.segment(?, ?);
  // b0.segment(?, ?) = b0_.segment(?, ?);
  throw HomeworkMissing("5.1 InsertBlock, the parts around the new block");
  H_ = H;
  b0_ = b0;
  return idx;
}

// Stage 5.2: the Schur complement

void MarginalizationError::SchurComplement(const MatXX& V, const MatXX& W, const VecX& b_b, MatXX* U, VecX* b_a) {
  MatXX V_inv_sqrt;  // V_inv_sqrt V_inv_sqrtᵀ stands for V⁻¹
  V_inv_sqrt = PseudoInverseSquareRoot(V);
  // TODO:: home work 5.2. With M = W V_inv_sqrt:  U ← U − M Mᵀ,  b_a ← b_a − M V_inv_sqrtᵀ b_b.
  // const MatXX M = ?;
  // *U -= ?;
  // *b_a -= ?;
  throw HomeworkMissing("5.2 SchurComplement");
}

// Stage 5.3: H = JᵀJ, e₀ = −(Jᵀ)⁺ b₀

void MarginalizationError::UpdateErrorComputation() {
  VecX p;  // P = diag(p)
  p = ScalingOf(H_);
  const VecX p_inverse = p.cwiseInverse();
  // P⁻¹ H P⁻¹ = U S Uᵀ; the eigenvalues that are zero to rounding are zero in S_sqrt and in its pseudo-inverse.
  const ScaledEigen eigen = DecomposeScaled(H_, p_inverse);
  const MatXX& U = eigen.U;
  const VecX& S_sqrt = eigen.S_sqrt;
  VecX S_pinv_sqrt;
  S_pinv_sqrt = eigen.S_pinv_sqrt;
  // TODO:: home work 5.3. J = (P U S^½)ᵀ,  (Jᵀ)⁺ = S^-½ Uᵀ P⁻¹,  e₀ = −(Jᵀ)⁺ b₀.
  // J_ = ?;
  // const MatXX J_pinv_T = ?;
  // e0_ = ?;
  throw HomeworkMissing("5.3 UpdateErrorComputation");
}

// Stage 5.4: the residual moves with the states

VecX MarginalizationError::Residual(const VecX& delta_chi) const {
  VecX e;
  // TODO:: home work 5.4. e = e₀ + J Δχ.
  // e = ?;
  throw HomeworkMissing("5.4 Residual");
  return e;
}

}  // namespace ch5
