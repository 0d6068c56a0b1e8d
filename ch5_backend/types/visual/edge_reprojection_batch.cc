// The equations of edge_reprojection.h, edge_reprojection_calibration.h and edge_stereo.h for eight observations at a time.
//
// Edges with the same host, target and cameras share T_Cj_Ci = T_W_Cj⁻¹ T_W_Ci, which is worked out once a pair. Scaled
// by λ, no distance is left to divide by: with f = [u_i, v_i, 1]
//   q = λ p_Cj = R_Cj_Ci f + λ p_Cj_Ci,   [x, y] = [q_x, q_y]/q_z,   ∂r/∂p_Cj = λ/q_z G,   G = [1 0 −x; 0 1 −y]

#include <algorithm>
#include <optional>
#include <unordered_map>

#include "ch5_backend/math/dispatch.h"
#include "ch5_backend/types/visual/edge_stereo.h"

namespace ch5 {

// A rotation (row-major) and a position.
struct RigidNumbers {
  double R[9], p[3];

  bool operator==(const RigidNumbers& other) const {
    return std::equal(R, R + 9, other.R) && std::equal(p, p + 3, other.p);
  }
};
static_assert(sizeof(RigidNumbers) == 12 * sizeof(double));

// The same of host and target, and what turns W into the target's camera.
struct PairNumbers {
  RigidNumbers T_Cj_Ci;
  double R_Cj_W[9];
};
static_assert(sizeof(PairNumbers) == 21 * sizeof(double));

// Which edges a batch has, by their vertices.
enum class Kind {
  kReprojection,  // λ, i, j
  kCalibration,   // λ, i, j, T_B_C, td
  kStereo,        // λ, i, j, T_B_C0, T_B_C1, td
  kStereoHost     // λ, T_B_C0, T_B_C1, td
};

// A point of each edge; all but x only where the camera's clock is a vertex.
struct MovingPoints {
  std::vector<double> x[2], velocity[2], clock_offset;

  void Add(const Vec2& point) {
    for (int i = 0; i < 2; ++i) x[i].push_back(point[i]);
  }
  void Add(const MovingPoint& point) {
    Add(point.x);
    for (int i = 0; i < 2; ++i) velocity[i].push_back(point.velocity[i]);
    clock_offset.push_back(point.clock_offset);
  }
  void Clear() {
    for (auto* numbers : {&x[0], &x[1], &velocity[0], &velocity[1], &clock_offset}) numbers->clear();
  }
};

// What edges with the same vertices, but for the inverse depth, have in common: numbers of poses and of cameras.
struct Pair {
  int host, target, camera_i, camera_j;
};

struct Reprojections {
  std::vector<RigidNumbers> T_B_C;
  std::vector<Pair> pairs;
  std::vector<PairNumbers> pair_numbers;
  std::vector<int> pair;  // of each edge, as all below
  std::vector<const VertexInverseDepth*> inverse_depth;
  std::vector<const VertexScalar*> time_offset;
  MovingPoints host, target;
  bool calibrating = false;  // a camera's place or its clock is free
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

// x̂ = x − (td − td_k) ẋ, as MovingPoint::At.
template <Kind kKind>
CH5_INLINE void LoadPoint(const MovingPoints& points, const WideLanes& td, int first, int count, WideLanes* x) {
  for (int i = 0; i < 2; ++i) Load(points.x[i], first, count, x + i);
  if constexpr (kKind != Kind::kReprojection) {
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
  template <Kind kKind, int N>
  CH5_INLINE void Compute(const Reprojections& seen, int first, int count) {
    const double *numbers[kPack], *inverse_depth[kPack], *time_offset[kPack];
    for (int k = 0; k < kPack; ++k) {
      const auto e = static_cast<size_t>(first + std::min(k, count - 1));
      numbers[k] = seen.pair_numbers[static_cast<size_t>(seen.pair[e])].T_Cj_Ci.R;
      inverse_depth[k] = seen.inverse_depth[e]->GetEstimate().data();
      if constexpr (kKind != Kind::kReprojection) time_offset[k] = seen.time_offset[e]->GetEstimate().data();
    }
    if (std::all_of(numbers + 1, numbers + kPack, [&](const double* other) { return other == numbers[0]; })) {
      CH5_UNROLL
      for (int i = 0; i < N; ++i) pair[i] = WideLanes{} + numbers[0][i];
    } else {
      GatherLanes<N>(numbers, pair);
    }
    GatherLanes<1>(inverse_depth, &lambda);
    WideLanes x_j[2], td = {};
    if constexpr (kKind != Kind::kReprojection) GatherLanes<1>(time_offset, &td);
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

template <Kind kKind>
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

CH5_INLINE void LoadCamera(const Reprojections& seen, int Pair::*camera, int first, int count, WideLanes* T_B_C) {
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
template <Kind kKind>
struct ResidualsAndJacobians {
  static constexpr bool kHasPoses = kKind != Kind::kStereoHost, kHasCameras = kKind != Kind::kReprojection;
  static constexpr bool kOneCamera = kKind == Kind::kReprojection || kKind == Kind::kCalibration;

  using Signature = void(const Reprojections&, int first, int count, double* r, double* J);
  template <SimdLevel>
  static CH5_INLINE void Run(const Reprojections& seen, int first, int count, double* r, double* J) {
    Projection c;
    c.Compute<kKind, 21>(seen, first, count);
    const WideLanes *R_Cj_Ci = c.pair, *p_Cj_Ci = c.pair + 9, *R_Cj_W = c.pair + 12, s = c.z_inverse;
    WideLanes T_B_Ci[12], T_B_Cj_own[12], p_Bi[3], p_Bj[3];  // the points times λ/q_z
    LoadCamera(seen, &Pair::camera_i, first, count, T_B_Ci);
    if (!kOneCamera) LoadCamera(seen, &Pair::camera_j, first, count, T_B_Cj_own);
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

// Poses are null in the host's own frame.
struct PairKey {
  const VertexPose *host, *target;
  int camera_i, camera_j;
  bool operator==(const PairKey& other) const {
    return host == other.host && target == other.target && camera_i == other.camera_i && camera_j == other.camera_j;
  }
};
struct PairHash {
  size_t operator()(const PairKey& key) const {
    const std::hash<const void*> hash;
    return ((hash(key.host) * 31 + hash(key.target)) * 31 + static_cast<size_t>(key.camera_i)) * 31 +
           static_cast<size_t>(key.camera_j);
  }
};

RigidNumbers Numbers(const VertexPose& T) { return Numbers(T.R(), T.p()); }

// T_W_C = T_W_B T_B_C
RigidNumbers Compose(const RigidNumbers& T_W_B, const RigidNumbers& T_B_C) {
  const auto R = [](const RigidNumbers& T) { return Eigen::Map<const Mat33>(T.R).transpose(); };
  const auto p = [](const RigidNumbers& T) { return Eigen::Map<const Vec3>(T.p); };
  return Numbers(R(T_W_B) * R(T_B_C), p(T_W_B) + R(T_W_B) * p(T_B_C));
}

}  // namespace

// The four kinds of edges: what Add reads of them is all that differs.
struct ReprojectionReader {
  // A camera that is a vertex, or a constant.
  struct CameraPlace {
    const VertexPose* vertex;
    RigidNumbers T_B_C;
  };
  CameraPlace camera_i;
  std::optional<CameraPlace> camera_j;  // unless it is camera_i
  const VertexPose *host = nullptr, *target = nullptr;
  const VertexScalar* time_offset = nullptr;
  MovingPoint host_point, target_point;

  static CameraPlace Place(const VertexPose& T_B_C) { return {&T_B_C, Numbers(T_B_C)}; }

  explicit ReprojectionReader(const EdgeReprojection& edge)
      : camera_i{nullptr, Numbers(edge.R_B_C_, edge.p_B_C_)}, host(&edge.GetVertex<1>()), target(&edge.GetVertex<2>()) {
    host_point.x = edge.f_host_.head<2>();
    target_point.x = edge.u_target_;
  }
  explicit ReprojectionReader(const EdgeReprojectionCalibration& edge)
      : camera_i(Place(edge.GetVertex<3>())),
        host(&edge.GetVertex<1>()),
        target(&edge.GetVertex<2>()),
        time_offset(&edge.GetVertex<4>()),
        host_point(edge.host_),
        target_point(edge.target_) {}
  explicit ReprojectionReader(const EdgeStereo& edge)
      : camera_i(Place(edge.GetVertex<3>())),
        camera_j(Place(edge.GetVertex<4>())),
        host(&edge.GetVertex<1>()),
        target(&edge.GetVertex<2>()),
        time_offset(&edge.GetVertex<5>()),
        host_point(edge.host_),
        target_point(edge.target_) {}
  explicit ReprojectionReader(const EdgeStereoHost& edge)
      : camera_i(Place(edge.GetVertex<1>())),
        camera_j(Place(edge.GetVertex<2>())),
        time_offset(&edge.GetVertex<3>()),
        host_point(edge.host_),
        target_point(edge.target_) {}
};

namespace {

template <typename EdgeType, Kind kKind>
class ReprojectionBatch : public EdgeBatch {
 public:
  void Clear() override {
    poses_.Clear();
    cameras_.clear();
    pair_number_.clear();
    seen_.pairs.clear();
    seen_.pair.clear();
    seen_.inverse_depth.clear();
    seen_.time_offset.clear();
    seen_.host.Clear();
    seen_.target.Clear();
    seen_.calibrating = false;
  }
  void Reserve(size_t count) override {
    seen_.pair.reserve(count);
    seen_.inverse_depth.reserve(count);
    for (MovingPoints* points : {&seen_.host, &seen_.target}) {
      for (std::vector<double>& x : points->x) x.reserve(count);
    }
  }
  void Add(const Edge& base) override {
    const auto& edge = static_cast<const EdgeType&>(base);
    const ReprojectionReader read(edge);
    const int camera_i = CameraOf(read.camera_i);
    const PairKey key{read.host, read.target, camera_i, read.camera_j ? CameraOf(*read.camera_j) : camera_i};
    if (seen_.pair.empty() || !(key == last_key_)) {  // edges come sorted, as a rule
      last_pair_ = pair_number_.try_emplace(key, static_cast<int>(seen_.pairs.size())).first->second;
      if (last_pair_ == static_cast<int>(seen_.pairs.size())) {
        seen_.pairs.push_back({read.host ? poses_.Of(*read.host) : 0, read.target ? poses_.Of(*read.target) : 0,
                               key.camera_i, key.camera_j});
      }
      last_key_ = key;
    }
    seen_.pair.push_back(last_pair_);
    seen_.inverse_depth.push_back(&edge.template GetVertex<0>());
    if constexpr (kKind == Kind::kReprojection) {
      seen_.host.Add(read.host_point.x);
      seen_.target.Add(read.target_point.x);
    } else {
      seen_.host.Add(read.host_point);
      seen_.target.Add(read.target_point);
      seen_.time_offset.push_back(read.time_offset);
      const auto is_free = [](const Vertex* vertex) { return !vertex->IsFixed(); };
      seen_.calibrating = seen_.calibrating || is_free(read.camera_i.vertex) ||
                          (read.camera_j && is_free(read.camera_j->vertex)) || is_free(read.time_offset);
    }
  }

  void LoadPoses() override {
    seen_.T_B_C.resize(cameras_.size());
    for (size_t c = 0; c < cameras_.size(); ++c) {
      seen_.T_B_C[c] = cameras_[c].vertex ? Numbers(*cameras_[c].vertex) : cameras_[c].T_B_C;
    }
    const size_t num_poses = poses_.Vertices().size();
    T_W_C_.resize(std::max<size_t>(num_poses, 1) * cameras_.size());
    for (size_t c = 0; c < cameras_.size(); ++c) {
      if (num_poses == 0) T_W_C_[c] = seen_.T_B_C[c];  // W is the body
      for (size_t i = 0; i < num_poses; ++i) {
        T_W_C_[c * num_poses + i] = Compose(Numbers(*poses_.Vertices()[i]), seen_.T_B_C[c]);
      }
    }
    seen_.pair_numbers.resize(seen_.pairs.size());
    const size_t stride = std::max<size_t>(num_poses, 1);
    for (size_t k = 0; k < seen_.pairs.size(); ++k) {
      const auto at = [&](int camera, int pose) -> const RigidNumbers& {
        return T_W_C_[static_cast<size_t>(camera) * stride + static_cast<size_t>(pose)];
      };
      const Pair& pair = seen_.pairs[k];
      seen_.pair_numbers[k] = Numbers(at(pair.camera_i, pair.host), at(pair.camera_j, pair.target));
    }
  }
  void ComputeResiduals(int first, int count, double* r) const override {
    Dispatch<Residuals<kKind>>()(seen_, first, count, r);
  }
  void Linearize(int first, int count, double* r, double* J) const override {
    Dispatch<ResidualsAndJacobians<kKind>>()(seen_, first, count, r, J);
  }

 private:
  // One, or one for each camera.
  int CameraOf(const ReprojectionReader::CameraPlace& place) {
    const auto is_it = [&](const ReprojectionReader::CameraPlace& known) {
      return known.vertex == place.vertex && (place.vertex || known.T_B_C == place.T_B_C);
    };
    const auto it = std::find_if(cameras_.begin(), cameras_.end(), is_it);
    const auto number = static_cast<int>(it - cameras_.begin());
    if (it == cameras_.end()) cameras_.push_back(place);
    return number;
  }

  VertexNumbers<VertexPose> poses_;
  std::vector<ReprojectionReader::CameraPlace> cameras_;
  std::unordered_map<PairKey, int, PairHash> pair_number_;
  PairKey last_key_ = {};
  int last_pair_ = 0;
  std::vector<RigidNumbers> T_W_C_;  // [camera][pose]
  Reprojections seen_;
};

}  // namespace

std::unique_ptr<EdgeBatch> EdgeReprojection::MakeBatch() const {
  return std::make_unique<ReprojectionBatch<EdgeReprojection, Kind::kReprojection>>();
}
std::unique_ptr<EdgeBatch> EdgeReprojectionCalibration::MakeBatch() const {
  return std::make_unique<ReprojectionBatch<EdgeReprojectionCalibration, Kind::kCalibration>>();
}
std::unique_ptr<EdgeBatch> EdgeStereo::MakeBatch() const {
  return std::make_unique<ReprojectionBatch<EdgeStereo, Kind::kStereo>>();
}
std::unique_ptr<EdgeBatch> EdgeStereoHost::MakeBatch() const {
  return std::make_unique<ReprojectionBatch<EdgeStereoHost, Kind::kStereoHost>>();
}

}  // namespace ch5
