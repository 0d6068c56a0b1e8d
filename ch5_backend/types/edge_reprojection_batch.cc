// The equations of edge_reprojection.h, inverse depth with a constant extrinsic, for eight observations at a time.

#include <algorithm>

#include "ch5_backend/types/edge_reprojection.h"

namespace ch5 {

// A rotation (row-major) and a position.
struct RigidNumbers {
  double R[9], p[3];
  static constexpr int kNumbers = 12;

  bool operator==(const RigidNumbers& other) const {
    return std::equal(R, R + 9, other.R) && std::equal(p, p + 3, other.p);
  }
};
static_assert(sizeof(RigidNumbers) == RigidNumbers::kNumbers * sizeof(double));

struct Reprojections {
  std::vector<RigidNumbers> T_B_C, poses;
  std::vector<const VertexInverseDepth*> inverse_depth;
  std::vector<int> host, target, extrinsic;
  std::vector<double> u_i, v_i, u_j, v_j;
};

namespace {

// y = R x + p, and y = Rᵀ (x − p).
CH5_INLINE void Map(const WideLanes* T, const WideLanes* x, WideLanes* y) {
  CH5_UNROLL
  for (int i = 0; i < 3; ++i) y[i] = T[3 * i] * x[0] + T[3 * i + 1] * x[1] + T[3 * i + 2] * x[2] + T[9 + i];
}
CH5_INLINE void MapBack(const WideLanes* T, const WideLanes* x, WideLanes* y) {
  const WideLanes d[3] = {x[0] - T[9], x[1] - T[10], x[2] - T[11]};
  CH5_UNROLL
  for (int i = 0; i < 3; ++i) y[i] = T[i] * d[0] + T[3 + i] * d[1] + T[6 + i] * d[2];
}
// b = a R and b = a Rᵀ for a row a.
CH5_INLINE void RowTimes(const WideLanes* a, const WideLanes* R, WideLanes* b) {
  CH5_UNROLL
  for (int i = 0; i < 3; ++i) b[i] = a[0] * R[i] + a[1] * R[3 + i] + a[2] * R[6 + i];
}
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

// The chain from the host's camera to the target's, each point in the frame of its name.
struct Chain {
  WideLanes T_W_Bi[12], T_W_Bj[12], T_B_C[12];
  WideLanes depth, p_Ci[3], p_Bi[3], p_Bj[3], p_Cj[3], z_inverse, r[2];

  CH5_INLINE void Compute(const Reprojections& seen, int first, int count) {
    const double *host[kPack], *target[kPack], *extrinsic[kPack], *inverse_depth[kPack], *pixel[4][kPack];
    for (int k = 0; k < kPack; ++k) {
      const auto e = static_cast<size_t>(first + std::min(k, count - 1));
      host[k] = seen.poses[static_cast<size_t>(seen.host[e])].R;
      target[k] = seen.poses[static_cast<size_t>(seen.target[e])].R;
      extrinsic[k] = seen.T_B_C[static_cast<size_t>(seen.extrinsic[e])].R;
      inverse_depth[k] = seen.inverse_depth[e]->GetEstimate().data();
      pixel[0][k] = &seen.u_i[e];
      pixel[1][k] = &seen.v_i[e];
      pixel[2][k] = &seen.u_j[e];
      pixel[3][k] = &seen.v_j[e];
    }
    WideLanes lambda, u[4], p_W[3];
    GatherLanes<12>(host, T_W_Bi);
    GatherLanes<12>(target, T_W_Bj);
    GatherLanes<12>(extrinsic, T_B_C);
    GatherLanes<1>(inverse_depth, &lambda);
    CH5_UNROLL
    for (int i = 0; i < 4; ++i) GatherLanes<1>(pixel[i], u + i);
    depth = 1.0 / lambda;
    p_Ci[0] = u[0] * depth;
    p_Ci[1] = u[1] * depth;
    p_Ci[2] = depth;
    Map(T_B_C, p_Ci, p_Bi);
    Map(T_W_Bi, p_Bi, p_W);
    MapBack(T_W_Bj, p_W, p_Bj);
    MapBack(T_B_C, p_Bj, p_Cj);
    z_inverse = 1.0 / p_Cj[2];
    r[0] = p_Cj[0] * z_inverse - u[2];
    r[1] = p_Cj[1] * z_inverse - u[3];
  }
};

CH5_INLINE void ResidualsBody(const Reprojections& seen, int first, int count, double* r) {
  Chain c;
  c.Compute(seen, first, count);
  auto* out = reinterpret_cast<WideLanes*>(r);
  out[0] = c.r[0];
  out[1] = c.r[1];
}

// Right perturbations R Exp(δθ):  ∂p_W/∂θ_i = −R_W_Bi [p_Bi],  ∂p_Bj/∂θ_j = [p_Bj],  ∂p_Ci/∂λ = −p_Ci/λ;
// a row aᵀ[b] is (a × b)ᵀ.
CH5_INLINE void LinearizeBody(const Reprojections& seen, int first, int count, double* r, double* J) {
  Chain c;
  c.Compute(seen, first, count);
  auto *r_out = reinterpret_cast<WideLanes*>(r), *J_lambda = reinterpret_cast<WideLanes*>(J);
  WideLanes *J_i = J_lambda + 2, *J_j = J_i + 12;
  const WideLanes zero = {};
  CH5_UNROLL
  for (int i = 0; i < 2; ++i) {
    r_out[i] = c.r[i];
    // A row of ∂(x/z, y/z)/∂p_C.
    const WideLanes dr_dp_C[3] = {i == 0 ? c.z_inverse : zero, i == 0 ? zero : c.z_inverse,
                                  -c.p_Cj[i] * c.z_inverse * c.z_inverse};
    WideLanes dr_dp_Bj[3], dr_dp_W[3], dr_dp_Bi[3], dr_dp_Ci[3], turn_i[3], turn_j[3];
    RowTimesTransposed(dr_dp_C, c.T_B_C, dr_dp_Bj);
    RowTimesTransposed(dr_dp_Bj, c.T_W_Bj, dr_dp_W);
    RowTimes(dr_dp_W, c.T_W_Bi, dr_dp_Bi);
    RowTimes(dr_dp_Bi, c.T_B_C, dr_dp_Ci);
    Cross(c.p_Bi, dr_dp_Bi, turn_i);
    Cross(dr_dp_Bj, c.p_Bj, turn_j);
    J_lambda[i] = -c.depth * (dr_dp_Ci[0] * c.p_Ci[0] + dr_dp_Ci[1] * c.p_Ci[1] + dr_dp_Ci[2] * c.p_Ci[2]);
    CH5_UNROLL
    for (int k = 0; k < 3; ++k) {
      J_i[2 * k + i] = dr_dp_W[k];
      J_i[6 + 2 * k + i] = turn_i[k];
      J_j[2 * k + i] = -dr_dp_W[k];
      J_j[6 + 2 * k + i] = turn_j[k];
    }
  }
}

struct Kernels {
  void (*residuals)(const Reprojections&, int, int, double*);
  void (*linearize)(const Reprojections&, int, int, double*, double*);
};

#define CH5_KERNELS(NAME, TARGET)                                                                      \
  TARGET void NAME##Residuals(const Reprojections& seen, int first, int count, double* r) {            \
    ResidualsBody(seen, first, count, r);                                                              \
  }                                                                                                    \
  TARGET void NAME##Linearize(const Reprojections& seen, int first, int count, double* r, double* J) { \
    LinearizeBody(seen, first, count, r, J);                                                           \
  }                                                                                                    \
  constexpr Kernels k##NAME{NAME##Residuals, NAME##Linearize};

CH5_KERNELS(Portable, )
CH5_KERNELS(Avx2, CH5_WITH_AVX2)
CH5_KERNELS(Avx512, CH5_WITH_AVX512)

RigidNumbers Numbers(const Mat33& R, const Vec3& p) {
  RigidNumbers T;
  Eigen::Map<Mat33>(T.R) = R.transpose();
  Eigen::Map<Vec3>(T.p) = p;
  return T;
}

}  // namespace

class EdgeReprojectionBatch : public EdgeBatch {
 public:
  void Clear() override {
    poses_.Clear();
    seen_ = {};
  }
  void Add(const Edge& base) override {
    const auto& edge = static_cast<const EdgeReprojection&>(base);
    seen_.inverse_depth.push_back(&edge.GetVertex<0>());
    seen_.host.push_back(poses_.Of(edge.GetVertex<1>()));
    seen_.target.push_back(poses_.Of(edge.GetVertex<2>()));
    const RigidNumbers T_B_C = Numbers(edge.R_B_C_, edge.p_B_C_);  // one, or one for each camera
    size_t known = 0;
    while (known < seen_.T_B_C.size() && !(seen_.T_B_C[known] == T_B_C)) ++known;
    if (known == seen_.T_B_C.size()) seen_.T_B_C.push_back(T_B_C);
    seen_.extrinsic.push_back(static_cast<int>(known));
    seen_.u_i.push_back(edge.f_host_.x());
    seen_.v_i.push_back(edge.f_host_.y());
    seen_.u_j.push_back(edge.u_target_.x());
    seen_.v_j.push_back(edge.u_target_.y());
  }

  void LoadPoses() override {
    seen_.poses.resize(poses_.Vertices().size());
    for (size_t i = 0; i < seen_.poses.size(); ++i) {
      seen_.poses[i] = Numbers(poses_.Vertices()[i]->R(), poses_.Vertices()[i]->p());
    }
  }
  void ComputeResiduals(int first, int count, double* r) const override { kernels_.residuals(seen_, first, count, r); }
  void Linearize(int first, int count, double* r, double* J) const override {
    kernels_.linearize(seen_, first, count, r, J);
  }

 private:
  const Kernels& kernels_ = HasAvx512() ? kAvx512 : HasAvx2() ? kAvx2 : kPortable;
  VertexNumbers<VertexPose> poses_;
  Reprojections seen_;
};

std::unique_ptr<EdgeBatch> EdgeReprojection::MakeBatch() const { return std::make_unique<EdgeReprojectionBatch>(); }

}  // namespace ch5
