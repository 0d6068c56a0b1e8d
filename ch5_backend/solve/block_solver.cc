#include "ch5_backend/solve/block_solver.h"

#include <algorithm>
#include <atomic>

#include "ch5_backend/solve/block_kernels.h"
#include "ch5_backend/solve/linear_parts.h"

namespace ch5 {
namespace {

constexpr int kLandmarks = 64;  // a task
constexpr int kEdges = 64;

using kernels::Pick;

}  // namespace

// ---- H and b: landmark by landmark, then the poses' blocks column by column ------------------------------------

template <int P, int L>
void BlockSolver<P, L>::MakeHessian() {
  const BlockStructure& s = structure_;
  ThreadPool one_thread;
  ThreadPool* pool = linearize_in_parallel_ ? &pool_ : &one_thread;
  ParallelFor(pool, static_cast<int>(s.landmarks.size()), kLandmarks, [&](int begin, int end) {
    for (int l = begin; l < end; ++l) LinearizeLandmark(l);
  });
  ParallelFor(pool, s.num_active_edges - s.num_landmark_edges, kEdges, [&](int begin, int end) {
    for (int e = begin; e < end; ++e) WriteLinearParts(s, s.edges[s.num_landmark_edges + e], linear_.data());
  });
  pool_.Run(static_cast<int>(s.poses.size()), [&](int j) { SumColumn(j); });
}

// H_ll = Σ J̃_lᵀJ̃_l,  H_pl = Σ J̃_pᵀJ̃_l,  b_l = −Σ J̃_lᵀr̃  over the landmark's edges.
template <int P, int L>
void BlockSolver<P, L>::LinearizeLandmark(int l) {
  const BlockStructure& s = structure_;
  const int dim = Pick<L>(s.landmark_dim[l]);
  double* b_l = b_.data() + s.landmark_offset[l];
  std::fill_n(b_l, dim, 0.0);
  const int slots_begin = s.landmark_slots[l], slots_end = s.landmark_slots[l + 1];
  for (int slot = slots_begin; slot < slots_end; ++slot) {
    std::fill_n(H_pm_.data() + s.slot_block[slot], Stride(Pick<P>(s.pose_dim[s.slot_pose[slot]])) * dim, 0.0);
  }

  std::array<double, L == Eigen::Dynamic ? 1 : Stride(L) * L> fixed_size{};
  thread_local std::vector<double> any_size;
  double* H_ll = fixed_size.data();  // with padding, unlike its final place
  if constexpr (L == Eigen::Dynamic) {
    any_size.assign(static_cast<size_t>(Stride(dim) * dim), 0.0);
    H_ll = any_size.data();
  }

  for (int e = s.landmark_edges[l]; e < s.landmark_edges[l + 1]; ++e) {
    const EdgeRecord& record = s.edges[e];
    WriteLinearParts(s, record, linear_.data());
    const double* J_l = linear_.data() + record.landmark.jacobian;
    kernels::AddTransposeProduct<L, L>(J_l, J_l, record.rows, dim, dim, H_ll);
    kernels::AddTransposeVector<L>(J_l, linear_.data() + record.residual, record.rows, dim, -1.0, b_l);
    for (int t = record.terms_begin; t < record.terms_end; ++t) {
      const EdgeTerm& term = s.terms[t];
      kernels::AddTransposeProduct<P, L>(linear_.data() + term.jacobian, J_l, record.rows, s.pose_dim[term.block], dim,
                                         H_pm_.data() + s.slot_block[term.slot]);
    }
  }
  for (int c = 0; c < dim; ++c) std::copy_n(H_ll + c * Stride(dim), dim, H_mm_.data() + s.landmark_block[l] + c * dim);
}

// H_ij = Σ J̃_iᵀJ̃_j for all i ≥ j,  b_j = −Σ J̃_jᵀr̃.
template <int P, int L>
void BlockSolver<P, L>::SumColumn(int j) {
  const BlockStructure& s = structure_;
  const int dim = Pick<P>(s.pose_dim[j]);
  double* b_j = b_.data() + s.pose_offset[j];
  std::fill_n(b_j, dim, 0.0);
  for (int block = H_pp_.ColumnBegin(j); block < H_pp_.ColumnBegin(j + 1); ++block) {
    const int rows = Pick<P>(s.pose_dim[H_pp_.Row(block)]);
    double* H_ij = H_pp_.Values(block);
    std::fill_n(H_ij, Stride(rows) * dim, 0.0);
    for (int k = s.products_begin[block]; k < s.products_begin[block + 1]; ++k) {
      const Product& product = s.products[k];
      const double *A = linear_.data() + product.jacobian_a, *B = linear_.data() + product.jacobian_b;
      kernels::AddTransposeProduct<P, P>(A, B, product.rows, rows, dim, H_ij);
      if (block == H_pp_.ColumnBegin(j)) {
        kernels::AddTransposeVector<P>(A, linear_.data() + product.residual, product.rows, dim, -1.0, b_j);
      }
    }
  }
}

// ---- (H + λD) Δx = b -------------------------------------------------------------------------------------------

template <int P, int L>
bool BlockSolver<P, L>::SolveLinearSystem(double lambda, VecX* delta_x) {
  const BlockStructure& s = structure_;
  if (!InvertLandmarks(lambda)) return false;
  pool_.Run(static_cast<int>(s.poses.size()), [&](int j) { SchurColumn(j, lambda); });
  if (!s.poses.empty() && !reduced_solver_->Solve(S_, b_schur_, pose_scale_, &delta_poses_)) return false;
  delta_x->resize(s.Size());
  delta_x->head(s.ordering.dim_poses) = delta_poses_;
  ParallelFor(&pool_, static_cast<int>(s.landmarks.size()), kLandmarks, [&](int begin, int end) {
    for (int l = begin; l < end; ++l) SolveLandmark(l, delta_x);
  });
  return delta_x->allFinite();
}

// (H_ll + λD)⁻¹ and its product with b_l: the damping comes before the inverse.
template <int P, int L>
bool BlockSolver<P, L>::InvertLandmarks(double lambda) {
  const BlockStructure& s = structure_;
  std::atomic<bool> ok{true};
  ParallelFor(&pool_, static_cast<int>(s.landmarks.size()), kLandmarks, [&](int begin, int end) {
    for (int l = begin; l < end; ++l) {
      const int dim = Pick<L>(s.landmark_dim[l]), first = s.landmark_offset[l];
      double* damped = H_mm_factor_.data() + s.landmark_block[l];
      double* inverse = H_mm_inverse_.data() + s.landmark_block[l];
      std::copy_n(H_mm_.data() + s.landmark_block[l], dim * dim, damped);
      for (int i = 0; i < dim; ++i) damped[i * dim + i] += lambda * DampingEntry(damped[i * dim + i]);
      if (!kernels::InvertSymmetric<L>(damped, dim, inverse)) ok = false;
      double* product = H_mm_inverse_b_.data() + first - s.ordering.dim_poses;
      std::fill_n(product, dim, 0.0);
      kernels::AddSymmetric<L>(inverse, b_.data() + first, dim, product);
    }
  });
  return ok;
}

// Column j of  S = H_pp + λD − Σ_l H_pl H_ll⁻¹ H_plᵀ  and rows j of  b_p − Σ_l H_pl H_ll⁻¹ b_l.
template <int P, int L>
void BlockSolver<P, L>::SchurColumn(int j, double lambda) {
  const BlockStructure& s = structure_;
  const int dim = Pick<P>(s.pose_dim[j]), offset = s.pose_offset[j];
  thread_local std::vector<int> block_of_row;  // the number of S's block (i, j)
  block_of_row.resize(s.poses.size());
  for (int block = S_.ColumnBegin(j); block < S_.ColumnBegin(j + 1); ++block) block_of_row[S_.Row(block)] = block;
  double* column = S_.Values(S_.ColumnBegin(j));
  double* column_end = j + 1 < S_.NumColumns() ? S_.Values(S_.ColumnBegin(j + 1)) : S_.Data() + S_.NumValues();
  std::fill(column, column_end, 0.0);
  for (int block = H_pp_.ColumnBegin(j); block < H_pp_.ColumnBegin(j + 1); ++block) {
    const int i = H_pp_.Row(block);
    std::copy_n(H_pp_.Values(block), Stride(Pick<P>(s.pose_dim[i])) * dim, S_.Values(block_of_row[i]));
  }
  for (int c = 0; c < dim; ++c) {
    double& diagonal = column[c * Stride(dim) + c];
    diagonal += lambda * DampingEntry(diagonal);
    pose_scale_[offset + c] = diagonal;
    b_schur_[offset + c] = b_[offset + c];
  }

  std::array<double, P == Eigen::Dynamic || L == Eigen::Dynamic ? 1 : Stride(P) * L> fixed_size;
  thread_local std::vector<double> any_size;
  for (int k = s.pose_slots_begin[j]; k < s.pose_slots_begin[j + 1]; ++k) {
    const int slot = s.pose_slots[k], l = s.slot_landmark[slot], landmark_dim = Pick<L>(s.landmark_dim[l]);
    double* Y = fixed_size.data();  // H_jl H_ll⁻¹
    if constexpr (P == Eigen::Dynamic || L == Eigen::Dynamic) {
      any_size.resize(static_cast<size_t>(Stride(dim) * landmark_dim));
      Y = any_size.data();
    }
    const double* W_j = H_pm_.data() + s.slot_block[slot];
    kernels::Multiply<P, L>(W_j, H_mm_inverse_.data() + s.landmark_block[l], dim, landmark_dim, Y);
    kernels::AddProduct<P, L>(W_j, H_mm_inverse_b_.data() + s.landmark_offset[l] - s.ordering.dim_poses, dim,
                              landmark_dim, -1.0, b_schur_.data() + offset);
    for (int other = slot; other < s.landmark_slots[l + 1]; ++other) {
      const int i = s.slot_pose[other];
      kernels::SubtractProduct<P, P, L>(H_pm_.data() + s.slot_block[other], Y, s.pose_dim[i], dim, landmark_dim,
                                        S_.Values(block_of_row[i]));
    }
  }
}

// Δx_l = H_ll⁻¹ (b_l − Σ_p H_plᵀ Δx_p)
template <int P, int L>
void BlockSolver<P, L>::SolveLandmark(int l, VecX* delta_x) const {
  const BlockStructure& s = structure_;
  const int dim = Pick<L>(s.landmark_dim[l]), first = s.landmark_offset[l];
  std::array<double, L == Eigen::Dynamic ? 1 : L> fixed_size;
  thread_local std::vector<double> any_size;
  double* rest = fixed_size.data();
  if constexpr (L == Eigen::Dynamic) {
    any_size.resize(static_cast<size_t>(dim));
    rest = any_size.data();
  }
  std::copy_n(b_.data() + first, dim, rest);
  for (int slot = s.landmark_slots[l]; slot < s.landmark_slots[l + 1]; ++slot) {
    const int pose = s.slot_pose[slot];
    kernels::AddTransposed<P, L>(H_pm_.data() + s.slot_block[slot], delta_x->data() + s.pose_offset[pose],
                                 s.pose_dim[pose], dim, -1.0, rest);
  }
  std::fill_n(delta_x->data() + first, dim, 0.0);
  kernels::AddSymmetric<L>(H_mm_inverse_.data() + s.landmark_block[l], rest, dim, delta_x->data() + first);
}

// ---- H v -------------------------------------------------------------------------------------------------------

template <int P, int L>
VecX BlockSolver<P, L>::MultiplyHessian(const VecX& v) const {
  const BlockStructure& s = structure_;
  VecX y = VecX::Zero(s.Size());
  H_pp_.Multiply(v.data(), y.data());
  pool_.Run(static_cast<int>(s.poses.size()), [&](int j) {
    for (int k = s.pose_slots_begin[j]; k < s.pose_slots_begin[j + 1]; ++k) {
      const int slot = s.pose_slots[k], l = s.slot_landmark[slot];
      kernels::AddProduct<P, L>(H_pm_.data() + s.slot_block[slot], v.data() + s.landmark_offset[l], s.pose_dim[j],
                                s.landmark_dim[l], 1.0, y.data() + s.pose_offset[j]);
    }
  });
  ParallelFor(&pool_, static_cast<int>(s.landmarks.size()), kLandmarks, [&](int begin, int end) {
    for (int l = begin; l < end; ++l) {
      double* y_l = y.data() + s.landmark_offset[l];
      kernels::AddSymmetric<L>(H_mm_.data() + s.landmark_block[l], v.data() + s.landmark_offset[l], s.landmark_dim[l],
                               y_l);
      for (int slot = s.landmark_slots[l]; slot < s.landmark_slots[l + 1]; ++slot) {
        const int pose = s.slot_pose[slot];
        kernels::AddTransposed<P, L>(H_pm_.data() + s.slot_block[slot], v.data() + s.pose_offset[pose],
                                     s.pose_dim[pose], s.landmark_dim[l], 1.0, y_l);
      }
    }
  });
  return y;
}

template class BlockSolver<6, 1>;
template class BlockSolver<6, 3>;
template class BlockSolver<9, 3>;
template class BlockSolver<Eigen::Dynamic, Eigen::Dynamic>;

}  // namespace ch5
