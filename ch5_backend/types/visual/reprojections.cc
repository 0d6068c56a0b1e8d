#include "ch5_backend/types/visual/reprojections.h"

#include "ch5_backend/math/dispatch.h"

namespace ch5 {
namespace {

// Numbers first, first + 1, …, and the last again where they end.
template <typename Vector>
CH5_INLINE void Load(const std::vector<double>& numbers, int first, int last, Vector* v) {
  constexpr int kWidth = sizeof(Vector) / sizeof(double);
  if (first + kWidth - 1 <= last) return ch5::Load(numbers.data() + first, v);
  for (int k = 0; k < kWidth; ++k) (*v)[k] = numbers[static_cast<size_t>(std::min(first + k, last))];
}

// A pack's edges, or half of them, as many as a Vector has lanes; behind edge `last` this one again. Their points move if
// the camera's clock is a vertex.
template <typename Vector, bool kMoving>
struct Projection {
  static constexpr int kWidth = sizeof(Vector) / sizeof(double);
  Vector lambda, p[3], Rf[3], z_inverse, xy[2], r[2];

  CH5_INLINE Projection(const Reprojections& seen, int first, int last) {
    const double *inverse_depth[kWidth], *time_offset[kWidth], *numbers[kWidth];
    for (int k = 0; k < kWidth; ++k) {
      const auto e = static_cast<size_t>(std::min(first + k, last));
      inverse_depth[k] = seen.inverse_depth[e]->GetEstimate().data();
      if constexpr (kMoving) time_offset[k] = seen.time_offset[e]->GetEstimate().data();
      numbers[k] = seen.T_Cj_Ci[static_cast<size_t>(seen.pair[e])].R;
    }
    GatherLanes<1>(inverse_depth, &lambda);
    Vector T[12], f[2], x_j[2], td = {};
    if (std::all_of(numbers + 1, numbers + kWidth, [&](const double* x) { return x == numbers[0]; })) {
      CH5_UNROLL
      for (int i = 0; i < 12; ++i) T[i] = Vector{} + numbers[0][i];
    } else {
      GatherLanes<12>(numbers, T);
    }
    if constexpr (kMoving) GatherLanes<1>(time_offset, &td);
    LoadPoint(seen.host, td, first, last, f);
    LoadPoint(seen.target, td, first, last, x_j);
    CH5_UNROLL
    for (int i = 0; i < 3; ++i) {
      p[i] = T[9 + i];
      Rf[i] = T[3 * i] * f[0] + T[3 * i + 1] * f[1] + T[3 * i + 2];
    }
    z_inverse = 1.0 / (Rf[2] + lambda * p[2]);
    CH5_UNROLL
    for (int i = 0; i < 2; ++i) {
      xy[i] = (Rf[i] + lambda * p[i]) * z_inverse;
      r[i] = xy[i] - x_j[i];
    }
  }

  // x̂ = x − (td − td_k) ẋ, as MovingPoint::At.
  static CH5_INLINE void LoadPoint(const MovingPoints& points, const Vector& td, int first, int last, Vector* x) {
    for (int i = 0; i < 2; ++i) Load(points.x[i], first, last, x + i);
    if constexpr (kMoving) {
      Vector velocity, clock_offset;
      Load(points.clock_offset, first, last, &clock_offset);
      for (int i = 0; i < 2; ++i) {
        Load(points.velocity[i], first, last, &velocity);
        x[i] -= (td - clock_offset) * velocity;
      }
    }
  }
};

template <bool kMoving>
struct Residuals {
  using Signature = void(const Reprojections&, int first, int count, double* r);
  template <SimdLevel kSimd>
  static CH5_INLINE void Run(const Reprojections& seen, int first, int count, double* r) {
    using Vector = FittingLanes<kSimd>;
    using Edges = Projection<Vector, kMoving>;
    CH5_UNROLL
    for (int lane = 0; lane < kPack; lane += Edges::kWidth) {
      const Edges edges(seen, first + lane, first + count - 1);
      for (int i = 0; i < 2; ++i) Store(edges.r[i], r + i * kPack + lane);
    }
  }
};

template <bool kMoving>
struct ResidualsAndJacobians {
  using Signature = void(const Reprojections&, int first, int count, double* r, double* J);
  template <SimdLevel kSimd>
  static CH5_INLINE void Run(const Reprojections& seen, int first, int count, double* r, double* J) {
    using Vector = FittingLanes<kSimd>;
    using Edges = Projection<Vector, kMoving>;
    CH5_UNROLL
    for (int lane = 0; lane < kPack; lane += Edges::kWidth, r += Edges::kWidth, J += Edges::kWidth) {
      const Edges edges(seen, first + lane, first + count - 1);
      const Vector *Rf = edges.Rf, *xy = edges.xy, s = edges.z_inverse, s_lambda = s * edges.lambda, none = {};
      const auto store = [](int number, const Vector& row_0, const Vector& row_1, double* out) {
        Store(row_0, out + 2 * number * kPack);
        Store(row_1, out + (2 * number + 1) * kPack);
      };
      double* J_xi = J + 2 * kPack;
      store(0, edges.r[0], edges.r[1], r);
      store(0, s * (edges.p[0] - xy[0] * edges.p[2]), s * (edges.p[1] - xy[1] * edges.p[2]), J);
      store(0, s_lambda, none, J_xi);
      store(1, none, s_lambda, J_xi);
      store(2, -xy[0] * s_lambda, -xy[1] * s_lambda, J_xi);
      // a row aᵀ of G/q_z turns into (R_Cj_Ci f × a)ᵀ
      store(3, -s * xy[0] * Rf[1], -s * (Rf[2] + xy[1] * Rf[1]), J_xi);
      store(4, s * (Rf[2] + xy[0] * Rf[0]), s * xy[1] * Rf[0], J_xi);
      store(5, -s * Rf[1], s * Rf[0], J_xi);
    }
  }
};

}  // namespace

void ComputeResiduals(const Reprojections& seen, int first, int count, double* r) {
  (seen.time_offset.empty() ? Dispatch<Residuals<false>>() : Dispatch<Residuals<true>>())(seen, first, count, r);
}

void Linearize(const Reprojections& seen, int first, int count, double* r, double* J) {
  (seen.time_offset.empty() ? Dispatch<ResidualsAndJacobians<false>>() : Dispatch<ResidualsAndJacobians<true>>())(
      seen, first, count, r, J);
}

}  // namespace ch5
