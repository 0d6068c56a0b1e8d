#include "ch5_backend/sparse/steps/back_substitute.h"

#include <algorithm>

#include "ch5_backend/math/parallel.h"
#include "ch5_backend/sparse/kernels/landmark.h"

namespace ch5 {
namespace {

constexpr int kLandmarks = 64;  // a task's

// Δx_l, and the landmark's part of the model cost change.
template <int P, int L>
CH5_INLINE double CompleteLandmark(const Structure& s, const Linearized& y, const Eliminated& eliminated, int l,
                                   double* delta_x) {
  const int dim = kernels::Pick<L>(s.landmark_dim[l]), first = s.landmark_offset[l];
  kernels::Scratch<L == Eigen::Dynamic ? L : 2 * L> scratch;
  double* rest = scratch.Zeros(2 * dim);  // b_l − w
  double* H_delta = rest + dim;
  kernels::SumOverPoses<P, L>(y.Slots(s, l), dim, delta_x, rest);
  for (int i = 0; i < dim; ++i) rest[i] = y.b[first + i] - rest[i];
  double* delta_l = delta_x + first;
  std::fill_n(delta_l, dim, 0.0);
  kernels::AddSymmetric<L>(&eliminated.H_ll_inverse[s.landmark_block[l]], rest, dim, delta_l);
  kernels::AddSymmetric<L>(&y.H_ll[s.landmark_block[l]], delta_l, dim, H_delta);
  double decrease = 0.0;
  for (int i = 0; i < dim; ++i) decrease += delta_l[i] * (rest[i] - 0.5 * H_delta[i]);
  return decrease;
}

template <int P, int L>
struct CompleteRange {
  using Signature = double(const Structure&, const Linearized&, const Eliminated&, int begin, int end, double* delta_x);
  template <SimdLevel>
  static CH5_INLINE double Run(const Structure& s, const Linearized& y, const Eliminated& eliminated, int begin,
                               int end, double* delta_x) {
    double decrease = 0.0;
    for (int l = begin; l < end; ++l) decrease += CompleteLandmark<P, L>(s, y, eliminated, l, delta_x);
    return decrease;
  }
};

}  // namespace

void BackSubstitute(const Structure& s, const Linearized& y, const Eliminated& eliminated, ThreadPool* pool,
                    Step* step) {
  VecX& delta_x = step->delta_x;
  const auto delta_poses = delta_x.head(s.ordering.dim_poses);
  y.H_pp.Multiply(delta_x.data(), step->H_pp_delta.data());
  const double of_poses = delta_poses.dot(y.b.head(s.ordering.dim_poses) - 0.5 * step->H_pp_delta);

  const auto range = DispatchByRegisters<CompleteRange>(s.sizes);
  const double of_landmarks =
      ParallelSum(pool, s.NumLandmarks(), kLandmarks, &step->partial_sums,
                  [&](int begin, int end) { return range(s, y, eliminated, begin, end, delta_x.data()); });
  step->model_cost_change = of_poses + of_landmarks;
}

}  // namespace ch5
