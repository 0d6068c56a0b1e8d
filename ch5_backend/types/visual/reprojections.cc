#include "ch5_backend/types/visual/reprojections.h"

#include "ch5_backend/math/dispatch.h"

namespace ch5 {
namespace {

// b = a Rᵀ for a row a.
CH5_INLINE void RowTimesTransposed(const WideLanes* a, const WideLanes* R, WideLanes* b) {
  CH5_UNROLL
  for (int i = 0; i < 3; ++i) b[i] = a[0] * R[3 * i] + a[1] * R[3 * i + 1] + a[2] * R[3 * i + 2];
}
// a × b
CH5_INLINE void Cross(const WideLanes* a, const WideLanes* b, WideLanes* c) {
  c[0] = a[1] * b[2] - a[2] * b[1];
  c[1] = a[2] * b[0] - a[0] * b[2];
  c[2] = a[0] * b[1] - a[1] * b[0];
}

CH5_INLINE void Load(const std::vector<double>& numbers, int first, int count, WideLanes* v) {
  if (count == kPack) {
    *v = *AsWide(numbers.data() + first);
  } else {
    for (int k = 0; k < kPack; ++k) (*v)[k] = numbers[static_cast<size_t>(first + std::min(k, count - 1))];
  }
}

// x̂ = x − (td − td_k) ẋ, as MovingPoint::At.
template <ReprojectionKind kKind>
CH5_INLINE void LoadPoint(const MovingPoints& points, const WideLanes& td, int first, int count, WideLanes* x) {
  for (int i = 0; i < 2; ++i) Load(points.x[i], first, count, x + i);
  if constexpr (kKind != ReprojectionKind::kReprojection) {
    WideLanes velocity, clock_offset;
    Load(points.clock_offset, first, count, &clock_offset);
    for (int i = 0; i < 2; ++i) {
      Load(points.velocity[i], first, count, &velocity);
      x[i] -= (td - clock_offset) * velocity;
    }
  }
}

struct Projection {
  WideLanes pair[21];  // PairNumbers
  WideLanes lambda, f[3], q[3], z_inverse, xy[2], r[2];

  // N numbers of each pair are wanted.
  template <ReprojectionKind kKind, int N>
  CH5_INLINE void Compute(const Reprojections& seen, int first, int count) {
    const double *numbers[kPack], *inverse_depth[kPack], *time_offset[kPack];
    for (int k = 0; k < kPack; ++k) {
      const auto e = static_cast<size_t>(first + std::min(k, count - 1));
      numbers[k] = seen.pair_numbers[static_cast<size_t>(seen.pair[e])].T_Cj_Ci.R;
      inverse_depth[k] = seen.inverse_depth[e]->GetEstimate().data();
      if constexpr (kKind != ReprojectionKind::kReprojection)
        time_offset[k] = seen.time_offset[e]->GetEstimate().data();
    }
    if (std::all_of(numbers + 1, numbers + kPack, [&](const double* other) { return other == numbers[0]; })) {
      CH5_UNROLL
      for (int i = 0; i < N; ++i) pair[i] = WideLanes{} + numbers[0][i];
    } else {
      GatherLanes<N>(numbers, pair);
    }
    GatherLanes<1>(inverse_depth, &lambda);
    WideLanes x_j[2], td = {};
    if constexpr (kKind != ReprojectionKind::kReprojection) GatherLanes<1>(time_offset, &td);
    LoadPoint<kKind>(seen.host, td, first, count, f);
    LoadPoint<kKind>(seen.target, td, first, count, x_j);
    f[2] = WideLanes{} + 1.0;
    CH5_UNROLL
    for (int i = 0; i < 3; ++i) {
      q[i] = pair[3 * i] * f[0] + pair[3 * i + 1] * f[1] + pair[3 * i + 2] + lambda * pair[9 + i];
    }
    z_inverse = 1.0 / q[2];
    CH5_UNROLL
    for (int i = 0; i < 2; ++i) {
      xy[i] = q[i] * z_inverse;
      r[i] = xy[i] - x_j[i];
    }
  }
};

template <ReprojectionKind kKind>
struct Residuals {
  using Signature = void(const Reprojections&, int first, int count, double* r);
  template <SimdLevel>
  static CH5_INLINE void Run(const Reprojections& seen, int first, int count, double* r) {
    Projection c;
    c.Compute<kKind, 12>(seen, first, count);
    auto* out = AsWide(r);
    out[0] = c.r[0];
    out[1] = c.r[1];
  }
};

CH5_INLINE void LoadCamera(const Reprojections& seen, int ReprojectionPair::*camera, int first, int count,
                           WideLanes* T_B_C) {
  const double* numbers[kPack];
  bool is_one = true;
  for (int k = 0; k < kPack; ++k) {
    const auto e = static_cast<size_t>(first + std::min(k, count - 1));
    numbers[k] = seen.T_B_C[static_cast<size_t>(seen.pairs[static_cast<size_t>(seen.pair[e])].*camera)].R;
    is_one = is_one && numbers[k] == numbers[0];
  }
  if (!is_one) return GatherLanes<12>(numbers, T_B_C);
  CH5_UNROLL
  for (int i = 0; i < 12; ++i) T_B_C[i] = WideLanes{} + numbers[0][i];
}

// Right perturbations R Exp(δθ):  ∂p_W/∂θ_i = −R_W_Bi [p_Bi],  ∂p_Bj/∂θ_j = [p_Bj];  a row aᵀ[b] is (a × b)ᵀ.
template <ReprojectionKind kKind>
struct ResidualsAndJacobians {
  static constexpr bool kHasPoses = kKind != ReprojectionKind::kStereoHost,
                        kHasCameras = kKind != ReprojectionKind::kReprojection;
  static constexpr bool kOneCamera =
      kKind == ReprojectionKind::kReprojection || kKind == ReprojectionKind::kCalibration;

  using Signature = void(const Reprojections&, int first, int count, double* r, double* J);
  template <SimdLevel>
  static CH5_INLINE void Run(const Reprojections& seen, int first, int count, double* r, double* J) {
    Projection c;
    c.Compute<kKind, 21>(seen, first, count);
    const WideLanes *R_Cj_Ci = c.pair, *p_Cj_Ci = c.pair + 9, *R_Cj_W = c.pair + 12, s = c.z_inverse;
    WideLanes T_B_Ci[12], T_B_Cj_own[12], p_Bi[3], p_Bj[3];  // the points times λ/q_z
    LoadCamera(seen, &ReprojectionPair::camera_i, first, count, T_B_Ci);
    if (!kOneCamera) LoadCamera(seen, &ReprojectionPair::camera_j, first, count, T_B_Cj_own);
    const WideLanes* T_B_Cj = kOneCamera ? T_B_Ci : T_B_Cj_own;
    RowTimesTransposed(c.f, T_B_Ci, p_Bi);
    RowTimesTransposed(c.q, T_B_Cj, p_Bj);
    CH5_UNROLL
    for (int k = 0; k < 3; ++k) {
      p_Bi[k] = s * (p_Bi[k] + c.lambda * T_B_Ci[9 + k]);
      p_Bj[k] = s * (p_Bj[k] + c.lambda * T_B_Cj[9 + k]);
    }
    auto *r_out = AsWide(r), *J_lambda = AsWide(J);
    WideLanesInMemory *J_i = J_lambda + 2, *J_j = J_i + 12, *J_cameras = kHasPoses ? J_j + 12 : J_i;
    CH5_UNROLL
    for (int i = 0; i < 2; ++i) {
      r_out[i] = c.r[i];
      WideLanes G_R_Cj_Ci[3], G_R_Cj_Bi[3], G_R_Cj_Bj[3];
      CH5_UNROLL
      for (int k = 0; k < 3; ++k) {
        G_R_Cj_Ci[k] = R_Cj_Ci[3 * i + k] - c.xy[i] * R_Cj_Ci[6 + k];
        G_R_Cj_Bj[k] = T_B_Cj[3 * k + i] - c.xy[i] * T_B_Cj[3 * k + 2];
      }
      RowTimesTransposed(G_R_Cj_Ci, T_B_Ci, G_R_Cj_Bi);
      J_lambda[i] = s * (p_Cj_Ci[i] - c.xy[i] * p_Cj_Ci[2]);
      if constexpr (kHasPoses) {
        WideLanes dr_dp_W[3], turn_i[3], turn_j[3];
        CH5_UNROLL
        for (int k = 0; k < 3; ++k) dr_dp_W[k] = c.lambda * s * (R_Cj_W[3 * i + k] - c.xy[i] * R_Cj_W[6 + k]);
        Cross(p_Bi, G_R_Cj_Bi, turn_i);
        Cross(G_R_Cj_Bj, p_Bj, turn_j);
        CH5_UNROLL
        for (int k = 0; k < 3; ++k) {
          J_i[2 * k + i] = dr_dp_W[k];
          J_i[6 + 2 * k + i] = turn_i[k];
          J_j[2 * k + i] = -dr_dp_W[k];
          J_j[6 + 2 * k + i] = turn_j[k];
        }
      }
      if constexpr (kHasCameras) AddCameras(seen, first, count, i, c, G_R_Cj_Ci, G_R_Cj_Bi, G_R_Cj_Bj, J_cameras);
    }
  }

  // ∂r/∂(T_B_Ci, T_B_Cj, td), row i: out of the host's camera and into the target's, which may be the same vertex; the
  // points move by −ẋ, through the host's ray and directly in the target. Zero where all of these are fixed.
  static CH5_INLINE void AddCameras(const Reprojections& seen, int first, int count, int i, const Projection& c,
                                    const WideLanes* G_R_Cj_Ci, const WideLanes* G_R_Cj_Bi, const WideLanes* G_R_Cj_Bj,
                                    WideLanesInMemory* J) {
    WideLanesInMemory *J_Ci = J, *J_Cj = kOneCamera ? J : J + 12, *J_td = J_Cj + 12;
    if (!seen.calibrating) {
      for (WideLanesInMemory* out = J + i; out <= J_td + i; out += 2) *out = WideLanes{};
      return;
    }
    const WideLanes s = c.z_inverse;
    WideLanes G[3] = {}, turn_i[3], turn_j[3], velocity;
    G[i] += 1.0;
    G[2] = -c.xy[i];
    Cross(c.f, G_R_Cj_Ci, turn_i);
    Cross(G, c.q, turn_j);
    CH5_UNROLL
    for (int k = 0; k < 3; ++k) {
      const WideLanes move_i = c.lambda * s * G_R_Cj_Bi[k], move_j = -c.lambda * s * G_R_Cj_Bj[k];
      J_Ci[2 * k + i] = kOneCamera ? move_i + move_j : move_i;
      J_Ci[6 + 2 * k + i] = s * (kOneCamera ? turn_i[k] + turn_j[k] : turn_i[k]);
      if (kOneCamera) continue;
      J_Cj[2 * k + i] = move_j;
      J_Cj[6 + 2 * k + i] = s * turn_j[k];
    }
    WideLanes change;
    Load(seen.target.velocity[i], first, count, &change);
    for (int k = 0; k < 2; ++k) {
      Load(seen.host.velocity[k], first, count, &velocity);
      change -= s * G_R_Cj_Ci[k] * velocity;
    }
    J_td[i] = change;
  }
};

}  // namespace

void ComputeResiduals(ReprojectionKind kind, const Reprojections& seen, int first, int count, double* r) {
  switch (kind) {
    case ReprojectionKind::kReprojection:
      return Dispatch<Residuals<ReprojectionKind::kReprojection>>()(seen, first, count, r);
    case ReprojectionKind::kCalibration:
      return Dispatch<Residuals<ReprojectionKind::kCalibration>>()(seen, first, count, r);
    case ReprojectionKind::kStereo: return Dispatch<Residuals<ReprojectionKind::kStereo>>()(seen, first, count, r);
    case ReprojectionKind::kStereoHost:
      return Dispatch<Residuals<ReprojectionKind::kStereoHost>>()(seen, first, count, r);
  }
}

void Linearize(ReprojectionKind kind, const Reprojections& seen, int first, int count, double* r, double* J) {
  switch (kind) {
    case ReprojectionKind::kReprojection:
      return Dispatch<ResidualsAndJacobians<ReprojectionKind::kReprojection>>()(seen, first, count, r, J);
    case ReprojectionKind::kCalibration:
      return Dispatch<ResidualsAndJacobians<ReprojectionKind::kCalibration>>()(seen, first, count, r, J);
    case ReprojectionKind::kStereo:
      return Dispatch<ResidualsAndJacobians<ReprojectionKind::kStereo>>()(seen, first, count, r, J);
    case ReprojectionKind::kStereoHost:
      return Dispatch<ResidualsAndJacobians<ReprojectionKind::kStereoHost>>()(seen, first, count, r, J);
  }
}

}  // namespace ch5
