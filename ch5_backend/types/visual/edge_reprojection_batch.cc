// The equations of edge_reprojection.h, inverse depth with a constant extrinsic, for eight observations at a time.
//
// Edges with the same host, target and camera share T_Cj_Ci = T_W_Cj⁻¹ T_W_Ci, which is worked out once a pair. Scaled
// by λ, no distance is left to divide by: with f = [u_i, v_i, 1]
//   q = λ p_Cj = R_Cj_Ci f + λ p_Cj_Ci,   [x, y] = [q_x, q_y]/q_z,   ∂r/∂p_Cj = λ/q_z G,   G = [1 0 −x; 0 1 −y]

#include <algorithm>
#include <unordered_map>

#include "ch5_backend/math/dispatch.h"
#include "ch5_backend/types/visual/edge_reprojection.h"

namespace ch5 {

// A rotation (row-major) and a position.
struct RigidNumbers {
  double R[9], p[3];
};
static_assert(sizeof(RigidNumbers) == 12 * sizeof(double));

// The same of host and target, and what turns W into the target's camera.
struct PairNumbers {
  RigidNumbers T_Cj_Ci;
  double R_Cj_W[9];
};
static_assert(sizeof(PairNumbers) == 21 * sizeof(double));

struct Reprojections {
  std::vector<RigidNumbers> T_B_C;
  std::vector<PairNumbers> pairs;
  std::vector<const VertexInverseDepth*> inverse_depth;
  std::vector<int> pair, extrinsic;
  std::vector<double> u_i, v_i, u_j, v_j;
};

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

struct Projection {
  WideLanes pair[21];  // PairNumbers
  WideLanes lambda, f[3], q[3], z_inverse, xy[2], r[2];

  // N numbers of each pair are wanted.
  template <int N>
  CH5_INLINE void Compute(const Reprojections& seen, int first, int count) {
    const double *numbers[kPack], *inverse_depth[kPack];
    for (int k = 0; k < kPack; ++k) {
      const auto e = static_cast<size_t>(first + std::min(k, count - 1));
      numbers[k] = seen.pairs[static_cast<size_t>(seen.pair[e])].T_Cj_Ci.R;
      inverse_depth[k] = seen.inverse_depth[e]->GetEstimate().data();
    }
    if (std::all_of(numbers + 1, numbers + kPack, [&](const double* other) { return other == numbers[0]; })) {
      CH5_UNROLL
      for (int i = 0; i < N; ++i) pair[i] = WideLanes{} + numbers[0][i];
    } else {
      GatherLanes<N>(numbers, pair);
    }
    GatherLanes<1>(inverse_depth, &lambda);
    WideLanes u_j[2];
    Load(seen.u_i, first, count, f);
    Load(seen.v_i, first, count, f + 1);
    Load(seen.u_j, first, count, u_j);
    Load(seen.v_j, first, count, u_j + 1);
    f[2] = WideLanes{} + 1.0;
    CH5_UNROLL
    for (int i = 0; i < 3; ++i) {
      q[i] = pair[3 * i] * f[0] + pair[3 * i + 1] * f[1] + pair[3 * i + 2] + lambda * pair[9 + i];
    }
    z_inverse = 1.0 / q[2];
    CH5_UNROLL
    for (int i = 0; i < 2; ++i) {
      xy[i] = q[i] * z_inverse;
      r[i] = xy[i] - u_j[i];
    }
  }
};

struct Residuals {
  using Signature = void(const Reprojections&, int first, int count, double* r);
  template <SimdLevel>
  static CH5_INLINE void Run(const Reprojections& seen, int first, int count, double* r) {
    Projection c;
    c.Compute<12>(seen, first, count);
    auto* out = AsWide(r);
    out[0] = c.r[0];
    out[1] = c.r[1];
  }
};

CH5_INLINE void LoadExtrinsics(const Reprojections& seen, int first, int count, WideLanes* T_B_C) {
  const double* numbers[kPack];
  for (int k = 0; k < kPack; ++k) {
    const auto e = static_cast<size_t>(first + std::min(k, count - 1));
    numbers[k] = seen.T_B_C[static_cast<size_t>(seen.extrinsic[e])].R;
  }
  if (seen.T_B_C.size() > 1) return GatherLanes<12>(numbers, T_B_C);
  CH5_UNROLL
  for (int i = 0; i < 12; ++i) T_B_C[i] = WideLanes{} + numbers[0][i];
}

// Right perturbations R Exp(δθ):  ∂p_W/∂θ_i = −R_W_Bi [p_Bi],  ∂p_Bj/∂θ_j = [p_Bj];  a row aᵀ[b] is (a × b)ᵀ.
struct ResidualsAndJacobians {
  using Signature = void(const Reprojections&, int first, int count, double* r, double* J);
  template <SimdLevel>
  static CH5_INLINE void Run(const Reprojections& seen, int first, int count, double* r, double* J) {
    Projection c;
    c.Compute<21>(seen, first, count);
    const WideLanes *R_Cj_Ci = c.pair, *p_Cj_Ci = c.pair + 9, *R_Cj_W = c.pair + 12, s = c.z_inverse;
    WideLanes T_B_C[12], p_Bi[3], p_Bj[3];  // these two times λ/q_z
    LoadExtrinsics(seen, first, count, T_B_C);
    RowTimesTransposed(c.f, T_B_C, p_Bi);
    RowTimesTransposed(c.q, T_B_C, p_Bj);
    CH5_UNROLL
    for (int k = 0; k < 3; ++k) {
      p_Bi[k] = s * (p_Bi[k] + c.lambda * T_B_C[9 + k]);
      p_Bj[k] = s * (p_Bj[k] + c.lambda * T_B_C[9 + k]);
    }
    auto *r_out = AsWide(r), *J_lambda = AsWide(J);
    WideLanesInMemory *J_i = J_lambda + 2, *J_j = J_i + 12;
    CH5_UNROLL
    for (int i = 0; i < 2; ++i) {
      r_out[i] = c.r[i];
      WideLanes dr_dp_W[3], G_R_Cj_Ci[3], G_R_Cj_Bi[3], G_R_Cj_Bj[3], turn_i[3], turn_j[3];
      CH5_UNROLL
      for (int k = 0; k < 3; ++k) {
        dr_dp_W[k] = c.lambda * s * (R_Cj_W[3 * i + k] - c.xy[i] * R_Cj_W[6 + k]);
        G_R_Cj_Ci[k] = R_Cj_Ci[3 * i + k] - c.xy[i] * R_Cj_Ci[6 + k];
        G_R_Cj_Bj[k] = T_B_C[3 * k + i] - c.xy[i] * T_B_C[3 * k + 2];
      }
      RowTimesTransposed(G_R_Cj_Ci, T_B_C, G_R_Cj_Bi);
      Cross(p_Bi, G_R_Cj_Bi, turn_i);
      Cross(G_R_Cj_Bj, p_Bj, turn_j);
      J_lambda[i] = s * (p_Cj_Ci[i] - c.xy[i] * p_Cj_Ci[2]);
      CH5_UNROLL
      for (int k = 0; k < 3; ++k) {
        J_i[2 * k + i] = dr_dp_W[k];
        J_i[6 + 2 * k + i] = turn_i[k];
        J_j[2 * k + i] = -dr_dp_W[k];
        J_j[6 + 2 * k + i] = turn_j[k];
      }
    }
  }
};

RigidNumbers Numbers(const Mat33& R, const Vec3& p) {
  RigidNumbers T;
  Eigen::Map<Mat33>(T.R) = R.transpose();
  Eigen::Map<Vec3>(T.p) = p;
  return T;
}

PairNumbers Numbers(const RigidNumbers& T_W_Ci, const RigidNumbers& T_W_Cj) {
  PairNumbers pair;
  for (int r = 0; r < 3; ++r) {
    double p = 0.0;
    for (int c = 0; c < 3; ++c) {
      double product = 0.0;
      for (int k = 0; k < 3; ++k) product += T_W_Cj.R[3 * k + r] * T_W_Ci.R[3 * k + c];
      pair.T_Cj_Ci.R[3 * r + c] = product;
      pair.R_Cj_W[3 * r + c] = T_W_Cj.R[3 * c + r];
      p += T_W_Cj.R[3 * c + r] * (T_W_Ci.p[c] - T_W_Cj.p[c]);
    }
    pair.T_Cj_Ci.p[r] = p;
  }
  return pair;
}

struct PairKey {
  const VertexPose *host, *target;
  size_t extrinsic;
  bool operator==(const PairKey& other) const {
    return host == other.host && target == other.target && extrinsic == other.extrinsic;
  }
};
struct PairHash {
  size_t operator()(const PairKey& key) const {
    const std::hash<const void*> hash;
    return (hash(key.host) * 31 + hash(key.target)) * 31 + key.extrinsic;
  }
};

}  // namespace

class EdgeReprojectionBatch : public EdgeBatch {
 public:
  void Clear() override {
    poses_.Clear();
    pair_number_.clear();
    pairs_.clear();
    seen_.T_B_C.clear();
    for (auto* numbers : {&seen_.pair, &seen_.extrinsic}) numbers->clear();
    for (auto* numbers : {&seen_.u_i, &seen_.v_i, &seen_.u_j, &seen_.v_j}) numbers->clear();
    seen_.inverse_depth.clear();
  }
  void Add(const Edge& base) override {
    const auto& edge = static_cast<const EdgeReprojection&>(base);
    const size_t extrinsic = ExtrinsicOf(edge);
    const PairKey key{&edge.GetVertex<1>(), &edge.GetVertex<2>(), extrinsic};
    if (seen_.pair.empty() || !(key == last_key_)) {  // edges come sorted, as a rule
      last_pair_ = pair_number_.try_emplace(key, static_cast<int>(pairs_.size())).first->second;
      if (last_pair_ == static_cast<int>(pairs_.size()))
        pairs_.push_back({poses_.Of(*key.host), poses_.Of(*key.target), extrinsic});
      last_key_ = key;
    }
    seen_.pair.push_back(last_pair_);
    seen_.extrinsic.push_back(static_cast<int>(extrinsic));
    seen_.inverse_depth.push_back(&edge.GetVertex<0>());
    seen_.u_i.push_back(edge.f_host_.x());
    seen_.v_i.push_back(edge.f_host_.y());
    seen_.u_j.push_back(edge.u_target_.x());
    seen_.v_j.push_back(edge.u_target_.y());
  }

  void LoadPoses() override {
    const size_t num_poses = poses_.Vertices().size();
    T_W_C_.resize(num_poses * seen_.T_B_C.size());
    for (size_t i = 0; i < num_poses; ++i) {
      const Mat33 R_W_B = poses_.Vertices()[i]->R();
      for (size_t c = 0; c < seen_.T_B_C.size(); ++c) {
        const Mat33 R_B_C = Eigen::Map<const Mat33>(seen_.T_B_C[c].R).transpose();
        const Vec3 p_W_C = poses_.Vertices()[i]->p() + R_W_B * Eigen::Map<const Vec3>(seen_.T_B_C[c].p);
        T_W_C_[c * num_poses + i] = Numbers(R_W_B * R_B_C, p_W_C);
      }
    }
    seen_.pairs.resize(pairs_.size());
    for (size_t k = 0; k < pairs_.size(); ++k) {
      const RigidNumbers* T_W_C = T_W_C_.data() + pairs_[k].extrinsic * num_poses;
      seen_.pairs[k] = Numbers(T_W_C[pairs_[k].host], T_W_C[pairs_[k].target]);
    }
  }
  void ComputeResiduals(int first, int count, double* r) const override {
    Dispatch<Residuals>()(seen_, first, count, r);
  }
  void Linearize(int first, int count, double* r, double* J) const override {
    Dispatch<ResidualsAndJacobians>()(seen_, first, count, r, J);
  }

 private:
  struct Pair {
    int host, target;  // in poses_
    size_t extrinsic;
  };

  // One, or one for each camera.
  size_t ExtrinsicOf(const EdgeReprojection& edge) {
    size_t known = 0;
    while (known < seen_.T_B_C.size() && !IsAt(edge, seen_.T_B_C[known])) ++known;
    if (known == seen_.T_B_C.size()) seen_.T_B_C.push_back(Numbers(edge.R_B_C_, edge.p_B_C_));
    return known;
  }
  static bool IsAt(const EdgeReprojection& edge, const RigidNumbers& T_B_C) {
    return Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(T_B_C.R) == edge.R_B_C_ &&
           Eigen::Map<const Vec3>(T_B_C.p) == edge.p_B_C_;
  }

  VertexNumbers<VertexPose> poses_;
  std::unordered_map<PairKey, int, PairHash> pair_number_;
  std::vector<Pair> pairs_;
  PairKey last_key_ = {};
  int last_pair_ = 0;
  std::vector<RigidNumbers> T_W_C_;  // [extrinsic][pose]
  Reprojections seen_;
};

std::unique_ptr<EdgeBatch> EdgeReprojection::MakeBatch() const { return std::make_unique<EdgeReprojectionBatch>(); }

}  // namespace ch5
