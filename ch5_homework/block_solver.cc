// Homework of chapter 5, stage 7.  Handout: ch5_homework/handout/stage_7.md, .zh.md.
#include <Eigen/Dense>

#include "ch5_backend/dense/blocks/plain_block_solver.h"
#include "ch5_backend/homework_missing.h"

namespace ch5 {

// ---- Stage 7:  H and S in blocks, as g2o's BlockSolver has them --------------------------------------------------

void PlainBlockSolver::BuildStructure() {
  // H has a block wherever an edge has two free vertices; S begins with the blocks of H_pp.
  MakeHessianBlocks();

  // Eliminating a landmark connects all poses that see it.
  // TODO:: home work 7a. Add the blocks (i, j), i ≥ j, that S has on top of those of H_pp.
  // for (int l = 0; l < NumLandmarks(); ++l) {
  //   for (const int i : PosesThatSee(?)) {
  //     for (const int j : PosesThatSee(?)) {
  //       if (?) AddSchurBlock(i, j);
  //     }
  //   }
  // }
  throw HomeworkMissing("7a BuildStructure, the pattern of S");
}

void PlainBlockSolver::BuildSystem() {
  SetSystemToZero();
  for (const auto& edge : ordering_.edges) {
    edge->Linearize();         // its residual and its Jacobians
    double drho;               // ρ' of the loss function, 1 without one
    MatXX robust_information;  // W_ρ of the loss function, W without one
    edge->RobustInfo(&drho, &robust_information);
    const VecX Wr = drho * (edge->Information() * edge->Residual());

    const auto& vertices = edge->Vertices();
    for (size_t i = 0; i < vertices.size(); ++i) {
      if (vertices[i]->OrderingId() < 0) continue;      // a fixed vertex has no rows and columns in H
      const BlockIndex a = BlockIndexOf(*vertices[i]);  // a.is_landmark, a.number
      const MatXX J_a = edge->Jacobian(i);
      const MatXX JtW = J_a.transpose() * robust_information;
      // TODO:: home work 7b. Subtract J_aᵀ W r from the rows of b that belong to the vertex.
      // b_.segment(?, ?) -= ?;
      throw HomeworkMissing("7b BuildSystem, the right-hand side");

      for (size_t k = 0; k < vertices.size(); ++k) {
        if (vertices[k]->OrderingId() < 0) continue;
        const BlockIndex c = BlockIndexOf(*vertices[k]);
        if (a.is_landmark && !c.is_landmark) continue;  // the mirror image of a block of H_pl is not stored
        const MatXX block = JtW * edge->Jacobian(k);
        // TODO:: home work 7c. Add `block` to H_pp_, H_pl_ or H_ll_. Of H_pp_ only the blocks (i, j), i ≥ j, exist.
        // if (?) H_pp_(?, ?) += block;
        // if (?) H_pl_(?, ?) += block;
        // if (?) H_ll_(?, ?) += block;
        throw HomeworkMissing("7c BuildSystem, the blocks of H");
      }
    }
  }
}

bool PlainBlockSolver::Solve(double lambda, VecX* delta_x) {
  // Step 1: H_ll_inverse_(l, l) of every landmark, damped before it is inverted.
  if (!InvertLandmarks(lambda)) return false;

  // Step 2: S = H_pp − Σ_l H_pl H_ll⁻¹ H_plᵀ and b_p − Σ_l H_pl H_ll⁻¹ b_l, landmark by landmark.
  BeginSchurComplement(lambda);  // S_ = H_pp, damped, and b_schur_ = b_p
  for (int l = 0; l < NumLandmarks(); ++l) {
    const VecX b_l = LandmarkPart(&b_, l);
    for (const int i : PosesThatSee(l)) {
      const MatXX K_il = H_pl_(i, l) * H_ll_inverse_(l, l);
      // TODO:: home work 7d. Subtract landmark l's contribution from the rows of pose i in b_schur_, and from S_(i, j).
      // b_schur_.segment(PoseRow(i), PoseDimension(i)) -= ?;
      // for (const int j : PosesThatSee(l)) {
      //   if (?) S_(i, j) -= ?;
      // }
      throw HomeworkMissing("7d Solve, the Schur complement");
    }
  }
  if (!SolvePoses(delta_x)) return false;

  // Step 3: back to the landmarks, one by one:  H_ll Δx_l = b_l − Σ_i H_ilᵀ Δx_i.
  for (int l = 0; l < NumLandmarks(); ++l) {
    VecX rest = LandmarkPart(&b_, l);
    // TODO:: home work 7e. Subtract the poses' part from `rest`, and solve for Δx_l.
    // for (const int i : PosesThatSee(l)) {
    //   rest -= ? * delta_x->segment(PoseRow(i), PoseDimension(i));
    // }
    // LandmarkPart(delta_x, l) = ?;
    throw HomeworkMissing("7e Solve, the landmarks");
  }
  return delta_x->allFinite();
}

}  // namespace ch5
