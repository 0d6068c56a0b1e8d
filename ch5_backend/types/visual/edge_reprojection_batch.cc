// Copies edges into Reprojections; edges with the same vertices, but for the inverse depth, become one of its pairs.

#include <algorithm>
#include <type_traits>

#include "ch5_backend/math/key_numbers.h"
#include "ch5_backend/types/visual/edge_stereo.h"
#include "ch5_backend/types/visual/reprojections.h"

namespace ch5 {
namespace {

RigidNumbers Numbers(const RigidMatrix& from) {
  RigidNumbers T;
  Eigen::Map<Mat33>(T.R) = from.R.transpose();
  Eigen::Map<Vec3>(T.p) = from.p;
  return T;
}

// T_Cj_Ci = T_W_Cj⁻¹ T_W_Ci
RigidNumbers Relative(const RigidNumbers& T_W_Ci, const RigidNumbers& T_W_Cj) {
  RigidNumbers T;
  for (int r = 0; r < 3; ++r) {
    double p = 0.0;
    for (int c = 0; c < 3; ++c) {
      double product = 0.0;
      for (int k = 0; k < 3; ++k) product += T_W_Cj.R[3 * k + r] * T_W_Ci.R[3 * k + c];
      T.R[3 * r + c] = product;
      p += T_W_Cj.R[3 * c + r] * (T_W_Ci.p[c] - T_W_Cj.p[c]);
    }
    T.p[r] = p;
  }
  return T;
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

auto R(const RigidNumbers& T) { return Eigen::Map<const Mat33>(T.R).transpose(); }
auto p(const RigidNumbers& T) { return Eigen::Map<const Vec3>(T.p); }

// T_W_C = T_W_B T_B_C
RigidNumbers Compose(const RigidNumbers& T_W_B, const RigidNumbers& T_B_C) {
  RigidMatrix T_W_C;
  T_W_C.R = R(T_W_B) * R(T_B_C);
  T_W_C.p = p(T_W_B) + R(T_W_B) * p(T_B_C);
  return Numbers(T_W_C);
}

// A of RelativeJacobian += [A_tp A_tθ; 0 A_φθ]
void AddBlocks(const Mat33& A_tp, const Mat33& A_ttheta, const Mat33& A_phitheta, RelativeJacobian* A) {
  for (int r = 0; r < 3; ++r) {
    for (int c = 0; c < 3; ++c) {
      A->row[r][c] += A_tp(r, c);
      A->row[r][3 + c] += A_ttheta(r, c);
      A->row[3 + r][3 + c] += A_phitheta(r, c);
    }
  }
}

}  // namespace

// What Add reads of an edge.
struct ReprojectionReader {
  // A camera that is a vertex, or a constant of an edge.
  struct CameraPlace {
    const VertexPose* vertex;
    const RigidMatrix* constant = nullptr;

    bool operator==(const CameraPlace& other) const {
      return vertex == other.vertex &&
             (vertex || (constant->R == other.constant->R && constant->p == other.constant->p));
    }
    RigidNumbers T_B_C() const { return Numbers(vertex ? RigidMatrix(*vertex) : *constant); }
  };
  CameraPlace camera_i, camera_j;
  const VertexPose *host = nullptr, *target = nullptr;  // null in the host's own frame
  const VertexScalar* time_offset = nullptr;
  MovingPoint host_point, target_point;

  explicit ReprojectionReader(const EdgeReprojection& edge)
      : camera_i{nullptr, &edge.T_B_C_}, camera_j(camera_i), host(&edge.GetVertex<1>()), target(&edge.GetVertex<2>()) {
    host_point.x = edge.f_host_.head<2>();
    target_point.x = edge.u_target_;
  }
  template <typename... V>
  explicit ReprojectionReader(const MovingPointEdge<V...>& edge)
      : camera_i{&edge.template GetVertex<MovingPointEdge<V...>::kCameraI>()},
        camera_j{&edge.template GetVertex<MovingPointEdge<V...>::kCameraJ>()},
        time_offset(&edge.template GetVertex<MovingPointEdge<V...>::kClock>()),
        host_point(edge.host_),
        target_point(edge.target_) {
    if constexpr (MovingPointEdge<V...>::kTwoFrames) {
      host = &edge.template GetVertex<1>();
      target = &edge.template GetVertex<2>();
    }
  }
};

namespace {

template <typename EdgeType>
class ReprojectionBatch : public EdgeBatch {
  static constexpr bool kMoving = !std::is_same_v<EdgeType, EdgeReprojection>;  // a MovingPointEdge

 public:
  void Clear() override {
    poses_.Clear();
    cameras_.clear();
    keys_.Clear();
    seen_.pairs.clear();
    seen_.pair.clear();
    seen_.inverse_depth.clear();
    seen_.time_offset.clear();
    seen_.host.Clear();
    seen_.target.Clear();
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
    const PairKey key{read.host, read.target, camera_i, HasOneCamera() ? camera_i : CameraOf(read.camera_j)};
    if (seen_.pair.empty() || !(key == last_key_)) {  // edges come sorted, as a rule
      last_pair_ = keys_.Of(key);
      if (last_pair_ == static_cast<int>(seen_.pairs.size())) {
        seen_.pairs.push_back({read.host ? poses_.Of(*read.host) : 0, read.target ? poses_.Of(*read.target) : 0,
                               key.camera_i, key.camera_j});
      }
      last_key_ = key;
    }
    seen_.pair.push_back(last_pair_);
    seen_.inverse_depth.push_back(&edge.template GetVertex<0>());
    if constexpr (kMoving) {
      seen_.host.Add(read.host_point);
      seen_.target.Add(read.target_point);
      seen_.time_offset.push_back(read.time_offset);
    } else {
      seen_.host.Add(read.host_point.x);
      seen_.target.Add(read.target_point.x);
    }
  }

  void LoadPoses() override {
    T_B_C_.resize(cameras_.size());
    for (size_t c = 0; c < cameras_.size(); ++c) T_B_C_[c] = cameras_[c].T_B_C();
    const std::vector<const VertexPose*>& poses = poses_.Vertices();
    T_W_C_.resize(NumBodies() * cameras_.size());
    for (size_t c = 0; c < cameras_.size(); ++c) {
      if (poses.empty()) T_W_C_[c] = T_B_C_[c];  // W is the body
      for (size_t i = 0; i < poses.size(); ++i)
        T_W_C_[c * NumBodies() + i] = Compose(Numbers(RigidMatrix(*poses[i])), T_B_C_[c]);
    }
    seen_.T_Cj_Ci.resize(seen_.pairs.size());
    for (size_t k = 0; k < seen_.pairs.size(); ++k) {
      const ReprojectionPair& pair = seen_.pairs[k];
      seen_.T_Cj_Ci[k] = Relative(T_W_C(pair.camera_i, pair.host), T_W_C(pair.camera_j, pair.target));
    }
  }
  void ComputeResiduals(int first, int count, double* r) const override {
    ch5::ComputeResiduals(seen_, first, count, r);
  }
  void Linearize(int first, int count, double* r, double* J) const override {
    ch5::Linearize(seen_, first, count, r, J);
  }

  bool IsRelative() const override { return true; }
  int RelativeJacobians(int first, int count, RelativeJacobian* A) const override {
    const auto begin = seen_.pair.begin() + first;
    const auto number = static_cast<size_t>(*begin);
    const ReprojectionPair& pair = seen_.pairs[number];
    const RigidNumbers &T_Cj_Ci = seen_.T_Cj_Ci[number], &T_B_Ci = T_B_C_[static_cast<size_t>(pair.camera_i)],
                       &T_B_Cj = T_B_C_[static_cast<size_t>(pair.camera_j)];
    const Mat33 R_Cj_Bj = R(T_B_Cj).transpose(), R_Cj_Bi = R(T_Cj_Ci) * R(T_B_Ci).transpose(), none = Mat33::Zero();
    if (!poses_.Vertices().empty()) {
      const Mat33 R_Cj_W = R(T_W_C(pair.camera_j, pair.target)).transpose();
      const Vec3 p_Bj_Ci = R(T_B_Cj) * p(T_Cj_Ci) + p(T_B_Cj);
      A[1] = A[2] = {};
      AddBlocks(R_Cj_W, -R_Cj_Bi * Hat(p(T_B_Ci)), R_Cj_Bi, &A[1]);
      AddBlocks(-R_Cj_W, R_Cj_Bj * Hat(p_Bj_Ci), -R_Cj_Bj, &A[2]);
    }
    if constexpr (kMoving) {  // the cameras' own, which may be one vertex
      RelativeJacobian *A_i = A + EdgeType::kCameraI, *A_j = A + EdgeType::kCameraJ;
      *A_i = *A_j = {};
      AddBlocks(R_Cj_Bi, none, R(T_Cj_Ci), A_i);
      AddBlocks(-R_Cj_Bj, Hat(p(T_Cj_Ci)), -Mat33::Identity(), A_j);
    }
    const auto is_other = [&](int other) { return other != *begin; };
    return static_cast<int>(std::find_if(begin + 1, begin + count, is_other) - begin);
  }

 private:
  static constexpr bool HasOneCamera() {
    if constexpr (kMoving) return EdgeType::kCameraI == EdgeType::kCameraJ;
    return true;
  }
  // One, or one for each camera.
  int CameraOf(const ReprojectionReader::CameraPlace& place) {
    const auto it = std::find(cameras_.begin(), cameras_.end(), place);
    const auto number = static_cast<int>(it - cameras_.begin());
    if (it == cameras_.end()) cameras_.push_back(place);
    return number;
  }

  size_t NumBodies() const { return std::max<size_t>(poses_.Vertices().size(), 1); }
  // A key of a body's number and a camera's.
  const RigidNumbers& T_W_C(int camera, int body) const {
    return T_W_C_[static_cast<size_t>(camera) * NumBodies() + static_cast<size_t>(body)];
  }

  VertexNumbers<VertexPose> poses_;
  std::vector<ReprojectionReader::CameraPlace> cameras_;
  KeyNumbers<PairKey, PairHash> keys_;  // of the pairs
  PairKey last_key_ = {};
  int last_pair_ = 0;
  std::vector<RigidNumbers> T_B_C_, T_W_C_;  // of each camera, and of each camera for each body
  Reprojections seen_;
};

}  // namespace

std::unique_ptr<EdgeBatch> EdgeReprojection::MakeBatch() const {
  return std::make_unique<ReprojectionBatch<EdgeReprojection>>();
}
template <typename... V>
std::unique_ptr<EdgeBatch> MovingPointEdge<V...>::MakeBatch() const {
  return std::make_unique<ReprojectionBatch<MovingPointEdge>>();
}

template std::unique_ptr<EdgeBatch>
MovingPointEdge<VertexInverseDepth, VertexPose, VertexPose, VertexPose, VertexScalar>::MakeBatch() const;
template std::unique_ptr<EdgeBatch>
MovingPointEdge<VertexInverseDepth, VertexPose, VertexPose, VertexPose, VertexPose, VertexScalar>::MakeBatch() const;
template std::unique_ptr<EdgeBatch>
MovingPointEdge<VertexInverseDepth, VertexPose, VertexPose, VertexScalar>::MakeBatch() const;

}  // namespace ch5
