#include "ch5_backend/sparse/hessian_product.h"

#include "ch5_backend/sparse/kernels/landmark.h"

namespace ch5 {
namespace {

constexpr int kLandmarks = 64;  // a task's

template <int P, int L, typename Scalar>
struct PoseRow {
  using Signature = void(const Structure&, const Linearized&, int j, const double* v, double* product);
  template <SimdLevel>
  static CH5_INLINE void Run(const Structure& s, const Linearized& y, int j, const double* v, double* product) {
    kernels::LandmarkKernels<P, L, Scalar>::MultiplyPose(s, y, j, v, product);
  }
};

template <int P, int L, typename Scalar>
struct LandmarkRow {
  using Signature = void(const Structure&, const Linearized&, int l, const double* v, double* product);
  template <SimdLevel>
  static CH5_INLINE void Run(const Structure& s, const Linearized& y, int l, const double* v, double* product) {
    kernels::LandmarkKernels<P, L, Scalar>::MultiplyLandmark(s, y, l, v, product);
  }
};

}  // namespace

VecX MultiplyHessian(const Structure& s, const Linearized& y, const VecX& v, ThreadPool* pool) {
  const auto pose_row = Dispatch<PoseRow>(y.SizesFor(s));
  const auto landmark_row = Dispatch<LandmarkRow>(y.SizesFor(s));
  VecX product = VecX::Zero(s.Size());
  y.H_pp.Multiply(v.data(), product.data());
  pool->Run(s.NumPoses(), [&](int j) { pose_row(s, y, j, v.data(), product.data()); });
  ParallelFor(pool, s.NumLandmarks(), kLandmarks, [&](int begin, int end) {
    for (int l = begin; l < end; ++l) landmark_row(s, y, l, v.data(), product.data());
  });
  return product;
}

VecX HessianDiagonal(const Structure& s, const Linearized& y) {
  VecX diagonal(s.Size());
  diagonal.head(s.ordering.dim_poses) = y.H_pp.Diagonal();
  for (int l = 0; l < s.NumLandmarks(); ++l) {
    const int dim = s.landmark_dim[l];
    const double* H_ll = &y.H_ll[s.landmark_block[l]];
    for (int i = 0; i < dim; ++i) diagonal[s.landmark_offset[l] + i] = H_ll[i * dim + i];
  }
  return diagonal;
}

MatXX DenseHessian(const Structure& s, const Linearized& y) {
  MatXX H = MatXX::Zero(s.Size(), s.Size());
  H.topLeftCorner(s.ordering.dim_poses, s.ordering.dim_poses) = y.H_pp.Dense();
  for (int l = 0; l < s.NumLandmarks(); ++l) {
    const int dim = s.landmark_dim[l], row = s.landmark_offset[l];
    H.block(row, row, dim, dim) = Eigen::Map<const MatXX>(&y.H_ll[s.landmark_block[l]], dim, dim);
    for (int slot = s.landmark_slots[l]; slot < s.landmark_slots[l + 1]; ++slot) {
      const int pose = s.slot_pose[slot], pose_dim = s.pose_dim[pose];
      const MatXX H_pl = y.H_pl.Block(s.slot_block[slot], pose_dim, dim);
      H.block(s.pose_offset[pose], row, pose_dim, dim) = H_pl;
      H.block(row, s.pose_offset[pose], dim, pose_dim) = H_pl.transpose();
    }
  }
  return H;
}

}  // namespace ch5
