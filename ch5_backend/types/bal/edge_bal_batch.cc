// The equations of edge_bal.h for eight observations at a time.

#include <algorithm>

#include "ch5_backend/math/dispatch.h"
#include "ch5_backend/types/bal/edge_bal.h"

namespace ch5 {
namespace {

// What a camera's observations need of it, row-major.
struct Camera {
  double R[9], J_l[9], t[3], f, k1, k2;
  static constexpr int kNumbers = 24;
};
static_assert(sizeof(Camera) == Camera::kNumbers * sizeof(double));

struct Observations {
  std::vector<int> camera;
  std::vector<const VertexPointXYZ*> point;
  std::vector<double> u, v;
};

// P = Exp(ω) X + t,  p = −[P.x, P.y]/P.z,  r = f (1 + k1 n + k2 n²) p − measurement,  n = ‖p‖²
struct Projection {
  WideLanes camera[Camera::kNumbers];
  WideLanes RX[3], z_inverse, p[2], n, distortion, r[2];

  CH5_INLINE void Compute(const std::vector<Camera>& cameras, const Observations& seen, int first, int count) {
    const double *camera_of[kPack], *point_of[kPack], *u[kPack], *v[kPack];
    for (int k = 0; k < kPack; ++k) {
      const auto e = static_cast<size_t>(first + std::min(k, count - 1)), ahead = e + 2 * kPack;
      if (ahead < seen.point.size()) __builtin_prefetch(seen.point[ahead]->GetEstimate().data());
      camera_of[k] = cameras[static_cast<size_t>(seen.camera[e])].R;
      point_of[k] = seen.point[e]->GetEstimate().data();
      u[k] = &seen.u[e];
      v[k] = &seen.v[e];
    }
    WideLanes X[3], pixel[2];
    GatherLanes<Camera::kNumbers>(camera_of, camera);
    GatherLanes<3>(point_of, X);
    GatherLanes<1>(u, pixel);
    GatherLanes<1>(v, pixel + 1);
    CH5_UNROLL
    for (int i = 0; i < 3; ++i) RX[i] = camera[3 * i] * X[0] + camera[3 * i + 1] * X[1] + camera[3 * i + 2] * X[2];
    z_inverse = -1.0 / (RX[2] + camera[20]);
    p[0] = (RX[0] + camera[18]) * z_inverse;
    p[1] = (RX[1] + camera[19]) * z_inverse;
    n = p[0] * p[0] + p[1] * p[1];
    distortion = 1.0 + n * (camera[22] + n * camera[23]);
    r[0] = camera[21] * distortion * p[0] - pixel[0];
    r[1] = camera[21] * distortion * p[1] - pixel[1];
  }
};

struct Residuals {
  using Signature = void(const std::vector<Camera>&, const Observations&, int first, int count, double* r);
  template <SimdLevel>
  static CH5_INLINE void Run(const std::vector<Camera>& cameras, const Observations& seen, int first, int count,
                             double* r) {
    Projection projection;
    projection.Compute(cameras, seen, first, count);
    auto* out = AsWide(r);
    out[0] = projection.r[0];
    out[1] = projection.r[1];
  }
};

struct ResidualsAndJacobians {
  using Signature = void(const std::vector<Camera>&, const Observations&, int first, int count, double* r, double* J);
  template <SimdLevel>
  static CH5_INLINE void Run(const std::vector<Camera>& cameras, const Observations& seen, int first, int count,
                             double* r, double* J) {
    Projection x;
    x.Compute(cameras, seen, first, count);
    auto *r_out = AsWide(r), *out = AsWide(J);
    r_out[0] = x.r[0];
    r_out[1] = x.r[1];
    // ∂u/∂p = f (d I + 2 (k1 + 2 k2 n) p pᵀ),  ∂p/∂P = −1/P.z [I | p]
    const WideLanes f = x.camera[21];
    const WideLanes a = f * x.z_inverse * x.distortion;
    const WideLanes e = 2.0 * f * x.z_inverse * (x.camera[22] + 2.0 * x.n * x.camera[23]);
    WideLanes du_dP[2][3];
    du_dP[0][0] = a + e * x.p[0] * x.p[0];
    du_dP[0][1] = du_dP[1][0] = e * x.p[0] * x.p[1];
    du_dP[1][1] = a + e * x.p[1] * x.p[1];
    const WideLanes *R = x.camera, *J_l = x.camera + 9;
    CH5_UNROLL
    for (int i = 0; i < 2; ++i) {
      WideLanes* d = du_dP[i];
      d[2] = d[0] * x.p[0] + d[1] * x.p[1];
      // ∂(Exp(ω)X)/∂ω = −[RX] J_l(ω), and a row aᵀ(−[b]) = (b × a)ᵀ
      const WideLanes c[3] = {x.RX[1] * d[2] - x.RX[2] * d[1], x.RX[2] * d[0] - x.RX[0] * d[2],
                              x.RX[0] * d[1] - x.RX[1] * d[0]};
      CH5_UNROLL
      for (int k = 0; k < 3; ++k) {
        out[2 * k + i] = c[0] * J_l[k] + c[1] * J_l[3 + k] + c[2] * J_l[6 + k];
        out[6 + 2 * k + i] = d[k];
        out[18 + 2 * k + i] = d[0] * R[k] + d[1] * R[3 + k] + d[2] * R[6 + k];
      }
      out[12 + i] = x.distortion * x.p[i];
      out[14 + i] = f * x.n * x.p[i];
      out[16 + i] = f * x.n * x.n * x.p[i];
    }
  }
};

class EdgeBALBatch : public EdgeBatch {
 public:
  void Clear() override {
    cameras_.Clear();
    seen_ = {};
  }
  void Reserve(size_t count) override {
    seen_.camera.reserve(count);
    seen_.point.reserve(count);
    seen_.u.reserve(count);
    seen_.v.reserve(count);
  }
  void Add(const Edge& edge) override {
    const auto& bal = static_cast<const EdgeBAL&>(edge);
    seen_.camera.push_back(cameras_.Of(bal.GetVertex<0>()));
    seen_.point.push_back(&bal.GetVertex<1>());
    seen_.u.push_back(bal.Pixel().x());
    seen_.v.push_back(bal.Pixel().y());
  }

  void LoadPoses() override {
    states_.resize(cameras_.Vertices().size());
    for (size_t i = 0; i < states_.size(); ++i) {
      const VertexCameraBAL& vertex = *cameras_.Vertices()[i];
      VertexCameraBAL::Rotation other;
      const VertexCameraBAL::Rotation& rotation = vertex.GetRotation(&other);
      const Vec9& x = vertex.GetEstimate();
      Camera& camera = states_[i];
      Eigen::Map<Mat33>(camera.R) = rotation.R.transpose();
      Eigen::Map<Mat33>(camera.J_l) = rotation.J_l.transpose();
      std::copy_n(x.data() + 3, 6, camera.t);
    }
  }
  void ComputeResiduals(int first, int count, double* r) const override {
    Dispatch<Residuals>()(states_, seen_, first, count, r);
  }
  void Linearize(int first, int count, double* r, double* J) const override {
    Dispatch<ResidualsAndJacobians>()(states_, seen_, first, count, r, J);
  }

 private:
  VertexNumbers<VertexCameraBAL> cameras_;
  Observations seen_;
  std::vector<Camera> states_;
};

}  // namespace

std::unique_ptr<EdgeBatch> EdgeBAL::MakeBatch() const { return std::make_unique<EdgeBALBatch>(); }

}  // namespace ch5
