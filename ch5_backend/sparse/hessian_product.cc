// H as a whole: products with it, its diagonal, and all of it for small problems.

#include "ch5_backend/sparse/sparse_solver.h"

namespace ch5 {
namespace {

constexpr int kLandmarks = 64;  // a task's

// (H v)_j += Σ_l H_jl v_l
template <int P, int L>
struct PoseRow {
  using Signature = void(const Structure&, const Linearized&, int j, const double* v, double* product);
  template <SimdLevel>
  static CH5_INLINE void Run(const Structure& s, const Linearized& y, int j, const double* v, double* product) {
    const int dim = kernels::Pick<P>(s.pose_dim[j]);
    alignas(64) double expanded[kernels::BlockSize(P, L)];
    for (const int slot : s.pose_slots[j]) {
      const int l = s.slot_landmark[slot];
      const double* H_jl = kernels::Block<P, L>(y.Slots(s, l), slot, expanded);
      for (int m = 0; m < kernels::Pick<L>(s.landmark_dim[l]); ++m, H_jl += dim) {
        for (int i = 0; i < dim; ++i) product[s.pose_offset[j] + i] += H_jl[i] * v[s.landmark_offset[l] + m];
      }
    }
  }
};

// (H v)_l = H_ll v_l + Σ_p H_plᵀ v_p
template <int P, int L>
struct LandmarkRow {
  using Signature = void(const Structure&, const Linearized&, int l, const double* v, double* product);
  template <SimdLevel>
  static CH5_INLINE void Run(const Structure& s, const Linearized& y, int l, const double* v, double* product) {
    const int dim = kernels::Pick<L>(s.landmark_dim[l]);
    double* product_l = product + s.landmark_offset[l];
    kernels::AddSymmetric<L>(&y.H_ll[s.landmark_block[l]], v + s.landmark_offset[l], dim, product_l);
    kernels::SumOverPoses<P, L>(y.Slots(s, l), dim, v, product_l);
  }
};

}  // namespace

VecX SparseSolver::MultiplyHessian(const VecX& v) const {
  const Structure& s = structure_;
  const auto pose_row = Dispatch<PoseRow>(s.sizes);
  const auto landmark_row = Dispatch<LandmarkRow>(s.sizes);
  VecX product = VecX::Zero(s.Size());
  linearized_.H_pp.Multiply(v.data(), product.data());
  pool_.Run(s.NumPoses(), [&](int j) { pose_row(s, linearized_, j, v.data(), product.data()); });
  ParallelFor(&pool_, s.NumLandmarks(), kLandmarks, [&](int begin, int end) {
    for (int l = begin; l < end; ++l) landmark_row(s, linearized_, l, v.data(), product.data());
  });
  return product;
}

VecX SparseSolver::HessianDiagonal() const {
  const Structure& s = structure_;
  const Linearized& y = linearized_;
  VecX diagonal(s.Size());
  diagonal.head(s.ordering.dim_poses) = y.H_pp.Diagonal();
  for (int l = 0; l < s.NumLandmarks(); ++l) {
    const int dim = s.landmark_dim[l];
    const double* H_ll = &y.H_ll[s.landmark_block[l]];
    for (int i = 0; i < dim; ++i) diagonal[s.landmark_offset[l] + i] = H_ll[i * dim + i];
  }
  return diagonal;
}

MatXX SparseSolver::DenseHessian() const {
  MatXX H = MatXX::Zero(structure_.Size(), structure_.Size());
  linearized_.ForEachBlock(structure_, [&](int row, int column, const auto& block) {
    H.block(row, column, block.rows(), block.cols()) = block;
    if (row != column) H.block(column, row, block.cols(), block.rows()) = block.transpose();
  });
  return H;
}

}  // namespace ch5
