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
    // edge->?;
    // for (const int position : drop_set) dropped.insert(?);
    // for (const auto& vertex : vertices) {
    //   if (?) blocks_.insert({vertex->Id(), {vertex, ?, 0}});
    // }
    throw HomeworkMissing("6a PreMarginalize, what each residual brings");
  }
  // TODO:: home work 6b. Give the dropped blocks their first rows from 0 on and count their m_ rows; then the others,
  // from m_ on, their n_ rows, and their ids in keep_.
  // for (auto& [id, block] : blocks_) {
  //   if (dropped.count(id) == 0) continue;
  //   block.idx = ?;
  //   m_ += ?;
  // }
  // for (auto& [id, block] : blocks_) {
  //   ?
  // }
  throw HomeworkMissing("6b PreMarginalize, the first row of each block");
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
      // b_.segment(?, ?) += ?;
      // for (size_t j = i; j < vertices.size(); ++j) {
      //   if (vertices[j]->IsFixed()) continue;
      //   const int idx_j = ?, size_j = ?;
      //   const MatXX block = ?;
      //   A_.block(?, ?, ?, ?) += ?;
      //   if (j != i) A_.block(?, ?, ?, ?) += ?;
      // }
      throw HomeworkMissing("6c ConstructA, one residual's share of A and b");
    }
  }
}

// Stage 6d: the dropped blocks go

MarginalizationInfo::KeptSystem MarginalizationInfo::SchurComplement() const {
  const SymmetricEigen mm = DecomposeSymmetric(A_.topLeftCorner(m_, m_));  // A_mm = V S Vᵀ
  KeptSystem kept;
  // TODO:: home work 6d. A_mm⁺ = V S⁺ Vᵀ, with 1/S where S > kEps, otherwise 0;
  // A_r = A_rr − A_rm A_mm⁺ A_mr,  b_r ← b_r − A_rm A_mm⁺ b_m.
  // const VecX S_pinv = (mm.S.array() > kEps).select(?, 0.0);
  // const MatXX A_mm_pinv = ?;
  // const MatXX A_rm = A_.block(?, ?, ?, ?), A_mr = A_.block(?, ?, ?, ?);
  // kept.A = ?;
  // kept.b = ?;
  throw HomeworkMissing("6d SchurComplement");
  return kept;
}

// Stage 6e: back to a residual

void MarginalizationInfo::Factor(const KeptSystem& kept) {
  const SymmetricEigen rr = DecomposeSymmetric(kept.A);  // A_r = V S Vᵀ
  // TODO:: home work 6e. J = S^½ Vᵀ and r₀ = S^-½ Vᵀ b_r; where S ≤ kEps, both S^½ and S^-½ are 0.
  // const VecX S = (rr.S.array() > kEps).select(?, 0.0);
  // const VecX S_pinv = (rr.S.array() > kEps).select(?, 0.0);
  // linearized_jacobians_ = ?;
  // linearized_residuals_ = ?;
  throw HomeworkMissing("6e Factor, J and r₀");
}

// Stage 6f: whose prior it is

Prior MarginalizationInfo::GetParameterBlocks(const std::map<int, std::shared_ptr<Vertex>>& shift) const {
  Prior prior;
  for (const int id : keep_) {
    const Block& block = blocks_.at(id);
    const auto shifted = shift.find(id);
    // TODO:: home work 6f. The vertex: shifted->second, if there is one; and the state at which A was made.
    // prior.vertices.push_back(?);
    // prior.x0.push_back(?);
    throw HomeworkMissing("6f GetParameterBlocks, a kept vertex and its state");
  }
  prior.J = linearized_jacobians_;
  prior.r0 = linearized_residuals_;
  return prior;
}

// ---- Stage 6g, MARGIN_OLD: what goes with the oldest frame ---------------------------------------------------------

DropSet DropSetOfMarginOld(const Window& window) {
  DropSet drop;
  // TODO:: home work 6g. The oldest frame's pose, its speed and biases, each depth that it hosts; and the edges there.
  // drop.vertices = {?, ?};
  // for (const auto& [id, landmark] : window.landmarks) {
  //   if (?) drop.vertices.push_back(landmark.inverse_depth);
  // }
  // drop.edges = EdgesAt(window.graph, ?);
  throw HomeworkMissing("6g DropSetOfMarginOld");
  return drop;
}

// ---- Stage 6h, MARGIN_SECOND_NEW: what goes with the second newest -------------------------------------------------

DropSet DropSetOfMarginSecondNew(const Window& window) {
  DropSet drop;
  // TODO:: home work 6h. If there is a prior and it holds the second newest frame's pose: that edge, that pose.
  // const std::shared_ptr<Vertex> pose = window.frames[?].pose;
  // if (?) return drop;
  // const auto& held = window.prior->Vertices();
  // if (std::find(held.begin(), held.end(), pose) == held.end()) return drop;
  // drop.edges = {?};
  // drop.vertices = {?};
  throw HomeworkMissing("6h DropSetOfMarginSecondNew");
  return drop;
}

// ---- Stage 6i, slideWindow -----------------------------------------------------------------------------------------

void SlideWindow(MarginalizationFlag flag, Window* window) {
  auto& frames = window->frames;
  // A landmark whose host leaves needs its depth in its next host: p_W is the landmark, T_W_C that camera.
  const auto moved_depth = [](const Transform& T_W_C, const Vec3& p_W) -> double {
    return (T_W_C.q.conjugate() * (p_W - T_W_C.p)).z();
  };
  // TODO:: home work 6i. Which frame leaves; forget its observations; the IMU of the frame after it; erase the frame.
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
  throw HomeworkMissing("6i SlideWindow");
}

// ---- Stage 6j, failureDetection ------------------------------------------------------------------------------------

Failure DetectFailure(const Window& window, const Vec3& last_p) {
  const Frame& newest = window.frames.back();
  // TODO:: home work 6j. ‖b_a‖ > 2.5 m/s²; ‖b_g‖ > 1 rad/s; a step of more than 5 m; more than 1 m up or down.
  // if (newest.speed_bias->b_a().norm() ?) return Failure::kAccelerometerBias;
  // if (?) return Failure::kGyroscopeBias;
  // const Vec3 step = ?;
  // if (?) return Failure::kPositionJump;
  // if (?) return Failure::kHeightJump;
  throw HomeworkMissing("6j DetectFailure");
  return Failure::kNone;
}

}  // namespace ch5
