#include "tests/scenes.h"

#include <stdexcept>

#include "ch5_backend/graph/auto_diff_edge.h"
#include "ch5_backend/simulate/mono_ba.h"
#include "ch5_backend/simulate/random.h"
#include "ch5_backend/types/bal/edge_bal.h"
#include "ch5_backend/types/edge_curve_fitting.h"
#include "ch5_backend/types/edge_se3_prior.h"
#include "ch5_backend/types/visual/edge_reprojection.h"

namespace ch5::test {
namespace {

// A random symmetric positive definite matrix with eigenvalues of order `scale`, off-diagonal entries included.
template <int N>
Eigen::Matrix<double, N, N> RandomInformation(Random* random, double scale) {
  Eigen::Matrix<double, N, N> A;
  for (int i = 0; i < N * N; ++i) A.data()[i] = random->Normal();
  return scale * (A * A.transpose() + Eigen::Matrix<double, N, N>::Identity());
}

// A pose, a 9-parameter camera, a 3-vector and a point in one residual, nonlinear, with numeric Jacobians.
class MixedEdge : public SizedEdge<4, VertexPointXYZ, VertexPose, VertexCameraBAL, VertexVector<3>> {
 public:
  MixedEdge(std::shared_ptr<VertexPointXYZ> point, std::shared_ptr<VertexPose> pose,
            std::shared_ptr<VertexCameraBAL> camera, std::shared_ptr<VertexVector<3>> vector, Random* random)
      : SizedEdge(std::move(point), std::move(pose), std::move(camera), std::move(vector)) {
    for (int i = 0; i < A_.size(); ++i) A_.data()[i] = 0.3 * random->Normal();
  }
  void ComputeResidual() override {
    Eigen::Matrix<double, 18, 1> x;
    x << GetVertex<1>().R() * GetVertex<0>().GetEstimate() + GetVertex<1>().p(), GetVertex<2>().GetEstimate(),
        GetVertex<3>().GetEstimate(), LogSO3(GetVertex<1>().q());
    x[9] *= 1e-2;  // the focal length, in hundreds of pixels
    r_ = A_ * x;
    r_ += 0.1 * r_.array().sin().matrix();
  }
  std::string TypeInfo() const override { return "MixedEdge"; }

 private:
  Eigen::Matrix<double, 4, 18> A_;
};

// Cameras of anyone's own, with N numbers, and a point:  r = A c + B X + 0.3 (A c) ∘ sin(B X) − z.
template <int N, typename... Cameras>
class OwnEdge : public AutoDiffEdge<OwnEdge<N, Cameras...>, 2, Cameras..., VertexPointXYZ> {
  static constexpr int kNumbers = N * sizeof...(Cameras);

 public:
  OwnEdge(std::shared_ptr<Cameras>... cameras, std::shared_ptr<VertexPointXYZ> point, Random* random)
      : AutoDiffEdge<OwnEdge, 2, Cameras..., VertexPointXYZ>(std::move(cameras)..., std::move(point)) {
    for (int i = 0; i < A_.size(); ++i) A_.data()[i] = random->Normal();
    for (int i = 0; i < B_.size(); ++i) B_.data()[i] = random->Normal();
    z_ = {random->Normal(), random->Normal()};
  }
  template <typename T>
  Eigen::Matrix<T, 2, 1> Evaluate(const Eigen::Matrix<T, N, 1>& c, const Eigen::Matrix<T, 3, 1>& X) const {
    using std::sin;
    Eigen::Matrix<T, 2, 1> r;
    for (int i = 0; i < 2; ++i) {
      const T a = A_.template block<1, N>(i, 0).dot(c), b = B_.row(i).dot(X);
      r[i] = a + b + 0.3 * a * sin(b) - z_[i];
    }
    return r;
  }
  template <typename T>
  Eigen::Matrix<T, 2, 1> Evaluate(const Eigen::Matrix<T, N, 1>& c, const Eigen::Matrix<T, N, 1>& d,
                                  const Eigen::Matrix<T, 3, 1>& X) const {
    return Evaluate<T>(c, X) + (A_.template rightCols<N>() * d);
  }
  std::string TypeInfo() const override { return "OwnEdge"; }

 private:
  Eigen::Matrix<double, 2, kNumbers> A_;
  Eigen::Matrix<double, 2, 3> B_;
  Vec2 z_;
};

template <int N, typename... Cameras>
void AddOwnCameras(Graph* graph) {
  Random random(18);
  std::vector<std::shared_ptr<VertexVector<N>>> cameras;
  for (int i = 0; i < 5; ++i) {
    cameras.push_back(std::make_shared<VertexVector<N>>(
        0.3 * VertexVector<N>::Estimate::NullaryExpr([&] { return random.Normal(); })));
    graph->AddVertex(cameras.back());
  }
  const auto loss = std::make_shared<HuberLoss>(1.0);
  for (int k = 0; k < 60; ++k) {
    auto point = std::make_shared<VertexPointXYZ>(NormalVector(&random, 0.5));
    graph->AddVertex(point);
    for (int i = 0; i < 4; ++i) {
      const auto &c = cameras[(i + k) % 5], &d = cameras[(i + k + 1) % 5];
      std::shared_ptr<Edge> edge;
      if constexpr (sizeof...(Cameras) == 2) {
        edge = std::make_shared<OwnEdge<N, Cameras...>>(c, d, point, &random);
      } else {
        edge = std::make_shared<OwnEdge<N, Cameras...>>(c, point, &random);
      }
      edge->SetIsotropicInformation(0.5 + random.Uniform());
      edge->SetLossFunction(loss);
      graph->AddEdge(edge);
    }
  }
}
template <int N>
Scene OwnCameras() {
  return {"OwnCameras" + std::to_string(N), false, AddOwnCameras<N, VertexVector<N>>};
}

void AddMonoBa(Graph* graph, int frames, int points, Gauge gauge, double information, double prior_weight,
               const std::function<void(MonoBa*)>& change = {}) {
  MonoBaOptions options;
  options.frames = frames;
  options.points = points;
  options.position_sigma = 0.02;
  options.rotation_sigma = 0.01;
  MonoBa scene = BuildMonoBa(SimulateMonoBa(options), gauge, information, prior_weight);
  if (change) change(&scene);
  *graph = std::move(scene.graph);
}

// Points seen by a random half of the poses, through an extrinsic; correlated noise; two poses fixed.
void AddPoints(Graph* graph, bool correlated) {
  Random random(11);
  const Transform T_B_C{ExpSO3({0.1, -0.2, 0.3}), {0.05, 0.02, -0.03}};
  std::vector<std::shared_ptr<VertexPose>> poses;
  for (int i = 0; i < 6; ++i) {
    const Vec3 p(0.5 * i, 0.3 * random.Normal(), 0.2 * random.Normal());
    poses.push_back(std::make_shared<VertexPose>(ExpSO3(NormalVector(&random, 0.1)), p));
    poses.back()->SetFixed(i < 2);
    graph->AddVertex(poses.back());
  }
  for (int k = 0; k < 40; ++k) {
    const Vec3 p_W(random.Uniform(-3, 5), random.Uniform(-3, 3), random.Uniform(6, 12));
    auto point = std::make_shared<VertexPointXYZ>(p_W + NormalVector(&random, 0.05));
    graph->AddVertex(point);
    for (int i = 0; i < 6; ++i) {
      if (i > 1 && random.Uniform() < 0.5) continue;
      const Vec3 p_C = T_B_C.q.conjugate() * (poses[i]->q().conjugate() * (p_W - poses[i]->p()) - T_B_C.p);
      const Vec2 u = p_C.head<2>() / p_C.z() + NormalVector<2>(&random, 1e-2);
      auto edge = std::make_shared<EdgeReprojectionXYZ>(point, poses[i], u, T_B_C);
      if (correlated) edge->SetInformation(RandomInformation<2>(&random, 1e4));
      graph->AddEdge(edge);
    }
  }
}

std::vector<std::shared_ptr<VertexCameraBAL>> AddBal(Graph* graph, int cameras, int points) {
  Random random(12);
  std::vector<std::shared_ptr<VertexCameraBAL>> vertices;
  for (int i = 0; i < cameras; ++i) {
    Vec9 x;
    x << NormalVector(&random, 0.1), 0.5 * i, NormalVector<2>(&random, 0.2), 500.0 + 10.0 * i, -0.05, 0.01;
    vertices.push_back(std::make_shared<VertexCameraBAL>(x));
    graph->AddVertex(vertices.back());
  }
  for (int k = 0; k < points; ++k) {
    const Vec3 p_W(random.Uniform(-4, 3), random.Uniform(-3, 3), random.Uniform(-12, -6));
    auto point = std::make_shared<VertexPointXYZ>(p_W);
    graph->AddVertex(point);
    for (int i = 0; i < cameras; ++i) {
      const auto& camera = vertices[i];
      if ((i + k) % 4 == 0) continue;
      EdgeBAL exact(camera, point, Vec2::Zero());
      exact.ComputeResidual();
      graph->AddEdge(std::make_shared<EdgeBAL>(camera, point, exact.GetResidual() + NormalVector<2>(&random, 1.0)));
    }
    point->SetEstimate(p_W + NormalVector(&random, 0.02));
  }
  return vertices;
}

void AddExtrinsic(Graph* graph) {
  const MonoBaScene scene = SimulateMonoBa({4, 30});
  Random random(13);
  std::vector<std::shared_ptr<VertexPose>> poses;
  for (const Transform& frame : scene.frames) {
    poses.push_back(std::make_shared<VertexPose>(frame.q, frame.p));
    graph->AddVertex(poses.back());
  }
  poses[0]->SetFixed();
  poses[1]->SetFixed();
  auto T_B_C = std::make_shared<VertexPose>(ExpSO3({0.01, 0.02, -0.01}), Vec3(0.02, -0.01, 0.03));
  graph->AddVertex(T_B_C);
  graph->AddEdge(std::make_shared<EdgeSE3Prior>(T_B_C, Qd::Identity(), Vec3::Zero()));
  for (size_t k = 0; k < scene.points.size(); ++k) {
    auto landmark = std::make_shared<VertexInverseDepth>(scene.initial_inverse_depths[k]);
    graph->AddVertex(landmark);
    for (size_t j = 1; j < poses.size(); ++j) {
      graph->AddEdge(std::make_shared<EdgeReprojectionExtrinsic>(landmark, poses[0], poses[j], T_B_C,
                                                                 scene.pixels[0][k], scene.pixels[j][k]));
    }
  }
}

void AddPoseOnly(Graph* graph) {
  Random random(14);
  for (int i = 0; i < 3; ++i) {
    auto pose = std::make_shared<VertexPose>(ExpSO3(NormalVector(&random, 0.2)), NormalVector(&random, 0.5));
    graph->AddVertex(pose);
    auto prior = std::make_shared<EdgeSE3Prior>(pose, Qd::Identity(), Vec3::Zero());
    prior->SetInformation(RandomInformation<6>(&random, 1.0));
    graph->AddEdge(prior);
    for (int k = 0; k < 8; ++k) {
      const Vec3 p_W(random.Uniform(-2, 2), random.Uniform(-2, 2), random.Uniform(4, 8));
      graph->AddEdge(std::make_shared<EdgeReprojectionPoseOnly>(
          pose, p_W, p_W.head<2>() / p_W.z() + NormalVector<2>(&random, 1e-2)));
    }
  }
}

void AddMixed(Graph* graph) {
  const auto cameras = AddBal(graph, 4, 20);
  cameras[0]->SetFixed();
  cameras[1]->SetFixed();
  Random random(15);
  std::vector<std::shared_ptr<VertexPose>> poses;
  for (int i = 0; i < 3; ++i) {
    poses.push_back(std::make_shared<VertexPose>(ExpSO3(NormalVector(&random, 0.05)), NormalVector(&random, 0.3)));
    graph->AddVertex(poses.back());
    graph->AddEdge(std::make_shared<EdgeSE3Prior>(poses.back(), Qd::Identity(), Vec3::Zero()));
  }
  auto vector = std::make_shared<VertexVector<3>>(Vec3(0.1, 0.2, 0.3));
  graph->AddVertex(vector);
  for (int k = 0; k < 5; ++k) graph->AddEdge(std::make_shared<EdgeCurveFitting>(vector, 0.2 * k, 1.0 + 0.3 * k));
  std::vector<std::shared_ptr<VertexPointXYZ>> points;
  for (int k = 0; k < 8; ++k) {
    points.push_back(std::make_shared<VertexPointXYZ>(NormalVector(&random, 1.0)));
    graph->AddVertex(points.back());
    for (int i = 0; i < 3; ++i) {
      auto edge = std::make_shared<MixedEdge>(points[k], poses[i], cameras[1 + (i + k) % 3], vector, &random);
      edge->SetInformation(RandomInformation<4>(&random, 1.0));
      graph->AddEdge(edge);
    }
  }
  auto landmark = std::make_shared<VertexInverseDepth>(0.2);
  graph->AddVertex(landmark);
  graph->AddEdge(std::make_shared<EdgeReprojection>(landmark, poses[0], poses[1], Vec2(0.1, 0.2), Vec2(0.2, 0.1)));
  graph->AddEdge(std::make_shared<EdgeReprojection>(landmark, poses[0], poses[2], Vec2(0.1, 0.2), Vec2(0.0, 0.1)));
}

void SetLosses(Graph* graph, const std::vector<std::shared_ptr<LossFunction>>& losses, double inlier, double outlier) {
  Random random(16);
  size_t i = 0;
  for (const auto& edge : graph->Edges()) {
    edge->SetLossFunction(losses[i++ % losses.size()]);
    if (edge->ResidualDimension() == 2 && random.Uniform() < 0.5) {
      edge->SetInformation(RandomInformation<2>(&random, random.Uniform() < 0.2 ? outlier : inlier));
    }
  }
}

void FixEvery(Graph* graph, Role role, size_t n) {
  size_t i = 0;
  for (const auto& vertex : graph->Vertices()) {
    if (vertex->GetRole() == role && i++ % n == 0) vertex->SetFixed();
  }
}

// What edges and vertices there are.
std::vector<Scene> ScenesOfEachKind() {
  return {
      {"Mono3x20Fixed", false, [](Graph* g) { AddMonoBa(g, 3, 20, Gauge::kFixTwoFrames, 1.0, 0.0); }},
      {"Mono3x20Free", true, [](Graph* g) { AddMonoBa(g, 3, 20, Gauge::kFree, 1.0, 0.0); }},
      {"Mono3x20Priors", false, [](Graph* g) { AddMonoBa(g, 3, 20, Gauge::kPriorTwoFrames, 1e6, 1e4); }},
      {"Mono10x50Fixed", false, [](Graph* g) { AddMonoBa(g, 10, 50, Gauge::kFixTwoFrames, 1e6, 0.0); }},
      {"Mono10x50Free", true, [](Graph* g) { AddMonoBa(g, 10, 50, Gauge::kFree, 1.0, 0.0); }},
      {"Mono10x50Priors", false, [](Graph* g) { AddMonoBa(g, 10, 50, Gauge::kPriorTwoFrames, 1.0, 10.0); }},
      {"Mono10x50MinimalGauge", false, [](Graph* g) { AddMonoBa(g, 10, 50, Gauge::kPriorMinimal, 1.0, 10.0); }},
      {"Points", false, [](Graph* g) { AddPoints(g, false); }},
      {"PointsWithCorrelatedNoise", false, [](Graph* g) { AddPoints(g, true); }},
      {"Bal", true, [](Graph* g) { AddBal(g, 6, 60); }},
      {"ExtrinsicEstimated", false, AddExtrinsic},
      {"PosesOnly", false, AddPoseOnly},
      {"MixedDimensions", true, AddMixed},
      OwnCameras<5>(),
      OwnCameras<8>(),
      OwnCameras<9>(),
      OwnCameras<10>(),
      OwnCameras<13>(),
      OwnCameras<16>(),
      {"TwoOwnCamerasAnEdge", false, AddOwnCameras<10, VertexVector<10>, VertexVector<10>>},
  };
}

// What is fixed, and what hangs together.
std::vector<Scene> ScenesWithFixedParts() {
  return {
      {"FixedLandmarks", false,
       [](Graph* g) {
         AddPoints(g, true);
         FixEvery(g, Role::kLandmark, 3);
       }},
      {"LandmarksOnly", false,
       [](Graph* g) {
         AddPoints(g, true);
         FixEvery(g, Role::kPose, 1);
       }},
      {"PosesOfKnownLandmarks", false,
       [](Graph* g) {
         AddPoints(g, true);
         FixEvery(g, Role::kLandmark, 1);
       }},
      {"Disconnected", false,
       [](Graph* g) {
         AddPoints(g, false);
         AddPoseOnly(g);
       }},
  };
}

// What the residuals are weighted by.
std::vector<Scene> ScenesWithLosses() {
  return {
      {"HuberLoss", false,
       [](Graph* g) {
         AddPoints(g, true);
         SetLosses(g, {std::make_shared<HuberLoss>(1.0), nullptr}, 1e4, 1e5);
       }},
      {"CauchyLoss", false,
       [](Graph* g) {
         AddPoints(g, true);
         SetLosses(g, {std::make_shared<CauchyLoss>(2.0), std::make_shared<CauchyLoss>(1.0, LossCorrection::kIrls)},
                   1e4, 1e5);
       }},
      {"TukeyAndTrivialLoss", false,
       [](Graph* g) {
         AddPoints(g, true);
         SetLosses(g, {std::make_shared<TukeyLoss>(5.0), std::make_shared<TrivialLoss>(), nullptr}, 1e4, 1e5);
       }},
      {"BalWithCauchyLoss", true,
       [](Graph* g) {
         AddBal(g, 6, 60);
         SetLosses(g, {std::make_shared<CauchyLoss>(3.0)}, 1.0, 10.0);
       }},
  };
}

}  // namespace

const std::vector<Scene>& AllScenes() {
  static const std::vector<Scene> scenes = [] {
    std::vector<Scene> all = ScenesOfEachKind();
    for (const auto& more : {ScenesWithFixedParts(), ScenesWithLosses()})
      all.insert(all.end(), more.begin(), more.end());
    return all;
  }();
  return scenes;
}

const Scene& SceneNamed(const std::string& name) {
  for (const Scene& scene : AllScenes()) {
    if (scene.name == name) return scene;
  }
  throw std::logic_error("no scene " + name);
}

}  // namespace ch5::test
