#include "ch5_backend/sparse/back_substitute.h"

#include "ch5_backend/sparse/kernels/landmark.h"

namespace ch5 {
namespace {

constexpr int kLandmarks = 64;  // a task's

template <int P, int L, typename Scalar>
struct BackSubstituteRange {
  using Signature = double(const Structure&, const Linearized&, const Eliminated&, int begin, int end, double* delta_x);
  template <SimdLevel>
  static CH5_INLINE double Run(const Structure& s, const Linearized& y, const Eliminated& eliminated, int begin,
                               int end, double* delta_x) {
    double decrease = 0.0;
    for (int l = begin; l < end; ++l) {
      decrease += kernels::LandmarkKernels<P, L, Scalar>::BackSubstitute(s, y, eliminated, l, delta_x);
    }
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

  const auto range = Dispatch<BackSubstituteRange>(y.SizesFor(s));
  const double of_landmarks =
      ParallelSum(pool, s.NumLandmarks(), kLandmarks, &step->partial_sums,
                  [&](int begin, int end) { return range(s, y, eliminated, begin, end, delta_x.data()); });
  step->promised_decrease = of_poses + of_landmarks;
}

}  // namespace ch5
