// Homework of chapter 5, stages 1.1, 1.2 and 2.  Handout: ch5_homework/README.md, README.zh.md.
#include "ch5_backend/dense/problem.h"

#include <Eigen/Dense>

#include "ch5_backend/dense/block_diagonal.h"
#include "ch5_backend/homework_missing.h"
#include "ch5_backend/math/psd.h"

namespace ch5 {

// ---- Stage 1.1:  H = Σ JᵀW_ρJ,  b = −Σ ρ'JᵀWr ------------------------------------------------------------------

void Problem::MakeHessian() {
  MatXX& H = Hessian_;
  VecX& b = b_;
  H.setZero(Size(), Size());
  b.setZero(Size());

  double drho;  // of one edge: ρ' of its loss function, 1 without one
  MatXX W_rho;  // W_ρ of its loss function, W without one
  for (const auto& edge : ordering_.edges) {
    edge->Linearize();  // r, J_0, J_1, …
    edge->RobustInfo(&drho, &W_rho);
    const VecX Wr = drho * (edge->Information() * edge->Residual());

    const auto& vertices = edge->Vertices();
    for (size_t i = 0; i < vertices.size(); ++i) {
      const auto& v_i = vertices[i];
      const int index_i = v_i->OrderingId();    // its first row in H and b
      const int dim_i = v_i->LocalDimension();  // how many rows it has
      if (index_i < 0) continue;                // a fixed vertex has no rows and columns in H

      for (size_t j = i; j < vertices.size(); ++j) {
        const auto& v_j = vertices[j];
        const int index_j = v_j->OrderingId();
        const int dim_j = v_j->LocalDimension();
        if (index_j < 0) continue;
        MatXX hessian;  // what the pair adds, dim_i × dim_j
        hessian = edge->Jacobian(i).transpose() * W_rho * edge->Jacobian(j);  // J_iᵀ W_ρ J_j

        // TODO:: home work 1.1a. Add `hessian` to the block of H that belongs to the pair (v_i, v_j).
        // H.block(?, ?, ?, ?).noalias() += hessian;
        throw HomeworkMissing("1.1a MakeHessian, the block (v_i, v_j)");
        if (j != i) {
          // TODO:: home work 1.1b. H is symmetric: add the transposed block at the mirror place, (v_j, v_i).
          // H.block(?, ?, ?, ?).noalias() += hessian.transpose();
          throw HomeworkMissing("1.1b MakeHessian, the mirrored block (v_j, v_i)");
        }
      }
      b.segment(index_i, dim_i) -= edge->Jacobian(i).transpose() * Wr;
    }
  }
}

// ---- Stage 1.2:  (H + λD) Δx = b  by the Schur complement of the landmarks --------------------------------------

bool Problem::SolveLinearSystem(double lambda, VecX* delta_x) {
  const MatXX& H = DampedHessian(lambda);     // every diagonal entry is damped, the landmarks' too
  const int reserve_size = ordering_poses_;   // p: the poses' rows come first
  const int marg_size = ordering_landmarks_;  // m: the landmarks' rows come last
  if (marg_size == 0) return SolveDense(H, b_, delta_x);

  // Step 1: take the system apart,  [H_pp H_pm; H_mp H_mm] [Δx_p; Δx_m] = [b_p; b_m].
  MatXX Hmm, Hpm, Hmp;
  VecX bpp, bmm;
  // TODO:: home work 1.2a. Take the blocks of H and the segments of b_.
  // Hmm = H.block(?, ?, ?, ?);
  // Hpm = H.block(?, ?, ?, ?);
  // Hmp = H.block(?, ?, ?, ?);
  // bpp = b_.segment(?, ?);
  // bmm = b_.segment(?, ?);
  throw HomeworkMissing("1.2a SolveLinearSystem, the blocks");

  // H_mm is block diagonal, one small block a landmark: its inverse is made of the blocks' inverses.
  BlockDiagonal Hmm_inv(marg_size);
  for (const auto& landmark : idx_landmark_vertices_) {
    const int idx = landmark.second->OrderingId() - reserve_size;
    const int size = landmark.second->LocalDimension();
    if (!Hmm_inv.SetInverse(idx, Hmm.block(idx, idx, size, size))) return false;
  }

  // Step 2: the Schur complement, a system of the poses alone.
  MatXX tempH;  // p × m
  tempH = Hpm * Hmm_inv;  // H_pm H_mm⁻¹
  // TODO:: home work 1.2b. H_pp − H_pm H_mm⁻¹ H_mp and b_p − H_pm H_mm⁻¹ b_m.
  // H_pp_schur_ = H.block(?, ?, ?, ?) - tempH * Hmp;
  // b_pp_schur_ = bpp - ? * ?;
  throw HomeworkMissing("1.2b SolveLinearSystem, the Schur complement");

  VecX delta_x_pp(reserve_size);
  if (!SolvePoses(&delta_x_pp)) return false;

  // Step 3: back to the landmarks,  H_mm Δx_m = b_m − H_mp Δx_p.
  VecX delta_x_ll(marg_size);
  // TODO:: home work 1.2c. Solve for the landmarks.
  // delta_x_ll = ???;
  throw HomeworkMissing("1.2c SolveLinearSystem, the landmarks");

  delta_x->resize(reserve_size + marg_size);
  delta_x->head(reserve_size) = delta_x_pp;
  delta_x->tail(marg_size) = delta_x_ll;
  return delta_x->allFinite();
}

// ---- Stage 2:  marginalization ----------------------------------------------------------------------------------

MarginalizeResult Problem::TestMarginalize(MatXX H_marg, VecX b_marg, int idx, int dim) {
  const int reserve_size = static_cast<int>(H_marg.rows());
  const int tail_size = reserve_size - idx - dim;  // the variables behind the marginalized one

  // Step 1: move the marginalized variable to the bottom right; the others keep their order.
  const MatXX temp_rows = H_marg.block(idx, 0, dim, reserve_size);
  const MatXX temp_botRows = H_marg.block(idx + dim, 0, tail_size, reserve_size);
  const VecX temp_b = b_marg.segment(idx, dim);
  const VecX temp_botb = b_marg.segment(idx + dim, tail_size);
  // TODO:: home work 2a. Move the rows of H_marg and the entries of b_marg.
  // H_marg.block(?, ?, ?, ?) = temp_botRows;
  // H_marg.block(?, ?, ?, ?) = temp_rows;
  // b_marg.segment(?, ?) = temp_botb;
  // b_marg.segment(?, ?) = temp_b;
  throw HomeworkMissing("2a TestMarginalize, moving the rows");

  const MatXX temp_cols = H_marg.block(0, idx, reserve_size, dim);
  const MatXX temp_rightCols = H_marg.block(0, idx + dim, reserve_size, tail_size);
  // TODO:: home work 2b. Move the columns of H_marg.
  // H_marg.block(?, ?, ?, ?) = temp_rightCols;
  // H_marg.block(?, ?, ?, ?) = temp_cols;
  throw HomeworkMissing("2b TestMarginalize, moving the columns");

  // Step 2: the Schur complement.  r = what remains, the first n2 rows;  m = what goes, the last m2 rows.
  const int m2 = dim;
  const int n2 = reserve_size - dim;
  MatXX Amm_inv;
  Amm_inv = PseudoInversePsd(H_marg.block(n2, n2, m2, m2));
  MatXX Arm, Amr, Arr;
  // TODO:: home work 2c. Take the three blocks of H_marg.
  // Arm = H_marg.block(?, ?, ?, ?);
  // Amr = H_marg.block(?, ?, ?, ?);
  // Arr = H_marg.block(?, ?, ?, ?);
  throw HomeworkMissing("2c TestMarginalize, the blocks");

  const MatXX tempB = Arm * Amm_inv;
  MatXX H_prior;
  VecX b_prior;
  // TODO:: home work 2d. A_rr − A_rm A_mm⁻¹ A_mr and b_r − A_rm A_mm⁻¹ b_m.
  // H_prior = ? - ? * ?;
  // b_prior = ? - ? * ?;
  throw HomeworkMissing("2d TestMarginalize, the Schur complement");
  return {H_marg, b_marg, H_prior, b_prior};
}

}  // namespace ch5
