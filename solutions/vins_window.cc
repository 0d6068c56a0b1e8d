// Homework of chapter 5, stage 6: VINS-Mono's window.  Handout: ch5_homework/handout/stage_6.md, .zh.md.
#include "ch5_backend/window/vins_window.h"

#include <algorithm>
#include <cmath>
#include <set>

#include "ch5_backend/homework_missing.h"
#include "ch5_backend/marginalize/marginalization_info.h"
#include "ch5_backend/marginalize/square_root.h"
#include "ch5_backend/window/landmarks.h"

namespace ch5 {

// ---- Stage 6, MarginalizationInfo:  residuals and the blocks to drop  →  one prior on the others -----------------

// Stage 6a, 6b: the residuals at the present states, and a place in A for each block

void MarginalizationInfo::PreMarginalize() {
  blocks_.clear();
  keep_.clear();
  m_ = n_ = 0;
  std::set<int> dropped;  // ids
  for (const auto& [edge, drop_set] : factors_) {
    const auto& vertices = edge->Vertices();
    // TODO:: home work 6a. Evaluate the residual and its Jacobians; note the id of each vertex that it drops; remember
    // each vertex that is not fixed, with its Parameters().
    // BEGIN SOLUTION 6a PreMarginalize, what each residual brings
    edge->Linearize();
    for (const int position : drop_set) dropped.insert(vertices[position]->Id());
    for (const auto& vertex : vertices) {
      if (!vertex->IsFixed()) blocks_.insert({vertex->Id(), {vertex, vertex->Parameters(), 0}});
    }
    // BLANK
    // edge->?;
    // for (const int position : drop_set) dropped.insert(?);
    // for (const auto& vertex : vertices) {
    //   if (?) blocks_.insert({vertex->Id(), {vertex, ?, 0}});
    // }
    // END SOLUTION
  }
  // TODO:: home work 6b. Give the dropped blocks their first rows from 0 on and count their m_ rows; then the others,
  // from m_ on, their n_ rows, and their ids in keep_.
  // BEGIN SOLUTION 6b PreMarginalize, the first row of each block
  for (auto& [id, block] : blocks_) {
    if (dropped.count(id) == 0) continue;
    block.idx = m_;
    m_ += block.vertex->LocalDimension();
  }
  for (auto& [id, block] : blocks_) {
    if (dropped.count(id) > 0) continue;
    block.idx = m_ + n_;
    n_ += block.vertex->LocalDimension();
    keep_.push_back(id);
  }
  // BLANK
  // for (auto& [id, block] : blocks_) {
  //   if (dropped.count(id) == 0) continue;
  //   block.idx = ?;
  //   m_ += ?;
  // }
  // for (auto& [id, block] : blocks_) {
  //   ?
  // }
  // END SOLUTION
}

// Stage 6c:  A = Σ JᵀW_ρJ,  b = Σ ρ'JᵀWr

void MarginalizationInfo::ConstructA() {
  A_ = MatXX::Zero(m_ + n_, m_ + n_);
  b_ = VecX::Zero(m_ + n_);
  for (const auto& factor : factors_) {
    const Edge& edge = *factor.edge;
    double drho;
    MatXX W_rho;
    edge.RobustInfo(&drho, &W_rho);  // ρ' and W_ρ
    const VecX Wr = edge.Information() * edge.Residual();
    const auto& vertices = edge.Vertices();
    for (size_t i = 0; i < vertices.size(); ++i) {
      if (vertices[i]->IsFixed()) continue;
      const int idx_i = blocks_.at(vertices[i]->Id()).idx, size_i = vertices[i]->LocalDimension();
      const MatXX J_i = edge.Jacobian(i);
      // TODO:: home work 6c. The rows of b_; then, with each vertex from the i-th on, a block of A_ and its mirror.
      // BEGIN SOLUTION 6c ConstructA, one residual's share of A and b
      b_.segment(idx_i, size_i) += drho * J_i.transpose() * Wr;
      for (size_t j = i; j < vertices.size(); ++j) {
        if (vertices[j]->IsFixed()) continue;
        const int idx_j = blocks_.at(vertices[j]->Id()).idx, size_j = vertices[j]->LocalDimension();
        const MatXX block = J_i.transpose() * W_rho * edge.Jacobian(j);
        A_.block(idx_i, idx_j, size_i, size_j) += block;
        if (j != i) A_.block(idx_j, idx_i, size_j, size_i) += block.transpose();
      }
      // BLANK
      // b_.segment(?, ?) += ?;
      // for (size_t j = i; j < vertices.size(); ++j) {
      //   if (vertices[j]->IsFixed()) continue;
      //   const int idx_j = ?, size_j = ?;
      //   const MatXX block = ?;
      //   A_.block(?, ?, ?, ?) += ?;
      //   if (j != i) A_.block(?, ?, ?, ?) += ?;
      // }
      // END SOLUTION
    }
  }
}

// Stage 6d: the dropped blocks go

MarginalizationInfo::KeptSystem MarginalizationInfo::SchurComplement() const {
  const SymmetricEigen mm = DecomposeSymmetric(A_.topLeftCorner(m_, m_));  // A_mm = V S Vᵀ
  KeptSystem kept;
  // TODO:: home work 6d. A_mm⁺ = V S⁺ Vᵀ, with 1/S where S > kEps, otherwise 0;
  // A_r = A_rr − A_rm A_mm⁺ A_mr,  b_r ← b_r − A_rm A_mm⁺ b_m.
  // BEGIN SOLUTION 6d SchurComplement
  const VecX S_pinv = (mm.S.array() > kEps).select(mm.S.array().inverse(), 0.0);
  const MatXX A_mm_pinv = mm.V * S_pinv.asDiagonal() * mm.V.transpose();
  const MatXX A_rm = A_.bottomLeftCorner(n_, m_), A_mr = A_.topRightCorner(m_, n_);
  kept.A = A_.bottomRightCorner(n_, n_) - A_rm * A_mm_pinv * A_mr;
  kept.b = b_.tail(n_) - A_rm * A_mm_pinv * b_.head(m_);
  // BLANK
  // const VecX S_pinv = (mm.S.array() > kEps).select(?, 0.0);
  // const MatXX A_mm_pinv = ?;
  // const MatXX A_rm = A_.block(?, ?, ?, ?), A_mr = A_.block(?, ?, ?, ?);
  // kept.A = ?;
  // kept.b = ?;
  // END SOLUTION
  return kept;
}

// Stage 6e: back to a residual

void MarginalizationInfo::Factor(const KeptSystem& kept) {
  const SymmetricEigen rr = DecomposeSymmetric(kept.A);  // A_r = V S Vᵀ
  // TODO:: home work 6e. J = S^½ Vᵀ and r₀ = S^-½ Vᵀ b_r; where S ≤ kEps, both S^½ and S^-½ are 0.
  // BEGIN SOLUTION 6e Factor, J and r₀
  const VecX S = (rr.S.array() > kEps).select(rr.S, 0.0);
  const VecX S_pinv = (rr.S.array() > kEps).select(rr.S.array().inverse(), 0.0);
  linearized_jacobians_ = S.cwiseSqrt().asDiagonal() * rr.V.transpose();
  linearized_residuals_ = S_pinv.cwiseSqrt().asDiagonal() * rr.V.transpose() * kept.b;
  // BLANK
  // const VecX S = (rr.S.array() > kEps).select(?, 0.0);
  // const VecX S_pinv = (rr.S.array() > kEps).select(?, 0.0);
  // linearized_jacobians_ = ?;
  // linearized_residuals_ = ?;
  // END SOLUTION
}

// Stage 6f: whose prior it is

Prior MarginalizationInfo::GetParameterBlocks(const std::map<int, std::shared_ptr<Vertex>>& shift) const {
  Prior prior;
  for (const int id : keep_) {
    const Block& block = blocks_.at(id);
    const auto shifted = shift.find(id);
    // TODO:: home work 6f. The vertex: shifted->second, if there is one; and the state at which A was made.
    // BEGIN SOLUTION 6f GetParameterBlocks, a kept vertex and its state
    prior.vertices.push_back(shifted == shift.end() ? block.vertex : shifted->second);
    prior.x0.push_back(block.x0);
    // BLANK
    // prior.vertices.push_back(?);
    // prior.x0.push_back(?);
    // END SOLUTION
  }
  prior.J = linearized_jacobians_;
  prior.r0 = linearized_residuals_;
  return prior;
}

// ---- Stage 6g, MARGIN_OLD: what goes with the oldest frame ---------------------------------------------------------

DropSet DropSetOfMarginOld(const Window& window) {
  DropSet drop;
  // TODO:: home work 6g. The oldest frame's pose, its speed and biases, each depth that it hosts; and the edges there.
  // BEGIN SOLUTION 6g DropSetOfMarginOld
  const Frame& oldest = window.frames.front();
  drop.vertices = {oldest.pose, oldest.speed_bias};
  for (const auto& [id, landmark] : window.landmarks) {
    if (landmark.inverse_depth && landmark.Host() == oldest.id) drop.vertices.push_back(landmark.inverse_depth);
  }
  drop.edges = EdgesAt(window.graph, drop.vertices);
  // BLANK
  // drop.vertices = {?, ?};
  // for (const auto& [id, landmark] : window.landmarks) {
  //   if (?) drop.vertices.push_back(landmark.inverse_depth);
  // }
  // drop.edges = EdgesAt(window.graph, ?);
  // END SOLUTION
  return drop;
}

// ---- Stage 6h, MARGIN_SECOND_NEW: what goes with the second newest -------------------------------------------------

DropSet DropSetOfMarginSecondNew(const Window& window) {
  DropSet drop;
  // TODO:: home work 6h. If there is a prior and it holds the second newest frame's pose: that edge, that pose.
  // BEGIN SOLUTION 6h DropSetOfMarginSecondNew
  const std::shared_ptr<Vertex> pose = window.frames[window.frames.size() - 2].pose;
  if (!window.prior) return drop;
  const auto& held = window.prior->Vertices();
  if (std::find(held.begin(), held.end(), pose) == held.end()) return drop;
  drop.edges = {window.prior};
  drop.vertices = {pose};
  // BLANK
  // const std::shared_ptr<Vertex> pose = window.frames[?].pose;
  // if (?) return drop;
  // const auto& held = window.prior->Vertices();
  // if (std::find(held.begin(), held.end(), pose) == held.end()) return drop;
  // drop.edges = {?};
  // drop.vertices = {?};
  // END SOLUTION
  return drop;
}

// ---- Stage 6i, slideWindow -----------------------------------------------------------------------------------------

void SlideWindow(MarginalizationFlag flag, Window* window) {
  auto& frames = window->frames;
  // A landmark whose host leaves needs its depth in its next host: p_W is the landmark, T_W_C that camera.
  const auto moved_depth = [](const Transform& T_W_C, const Vec3& p_W) -> double {
    // BEGIN DEEP 6k SlideWindow, the depth in the next host
    return (T_W_C.q.conjugate() * (p_W - T_W_C.p)).z();
    // BLANK
    // TODO:: home work 6k. The point in that camera; its depth is one of the three coordinates there.
    // END DEEP
  };
  // TODO:: home work 6i. Which frame leaves; forget its observations; the IMU of the frame after it; erase the frame.
  // BEGIN SOLUTION 6i SlideWindow
  const auto leaving = flag == MarginalizationFlag::kOld ? frames.begin() : frames.end() - 2;
  const auto next = leaving + 1;
  ForgetObservations(leaving->id, moved_depth, window);
  if (flag == MarginalizationFlag::kOld) {
    next->imu = nullptr;
  } else {
    leaving->imu->Append(*next->imu);
    next->imu = leaving->imu;
  }
  frames.erase(leaving);
  // BLANK
  // const auto leaving = flag == MarginalizationFlag::kOld ? ? : ?;
  // const auto next = leaving + 1;
  // ForgetObservations(?, moved_depth, window);
  // if (flag == MarginalizationFlag::kOld) {
  //   next->imu = ?;
  // } else {
  //   leaving->imu->Append(?);
  //   next->imu = ?;
  // }
  // frames.erase(?);
  // END SOLUTION
}

// ---- Stage 6j, failureDetection ------------------------------------------------------------------------------------

Failure DetectFailure(const Window& window, const Vec3& last_p) {
  const Frame& newest = window.frames.back();
  // TODO:: home work 6j. ‖b_a‖ > 2.5 m/s²; ‖b_g‖ > 1 rad/s; a step of more than 5 m; more than 1 m up or down.
  // BEGIN SOLUTION 6j DetectFailure
  if (newest.speed_bias->b_a().norm() > 2.5) return Failure::kAccelerometerBias;
  if (newest.speed_bias->b_g().norm() > 1.0) return Failure::kGyroscopeBias;
  const Vec3 step = newest.pose->p() - last_p;
  if (step.norm() > 5.0) return Failure::kPositionJump;
  if (std::abs(step.z()) > 1.0) return Failure::kHeightJump;
  // BLANK
  // if (newest.speed_bias->b_a().norm() ?) return Failure::kAccelerometerBias;
  // if (?) return Failure::kGyroscopeBias;
  // const Vec3 step = ?;
  // if (?) return Failure::kPositionJump;
  // if (?) return Failure::kHeightJump;
  // END SOLUTION
  return Failure::kNone;
}

}  // namespace ch5
