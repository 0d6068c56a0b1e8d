#include "ch5_homework/judge/stage_4_scene.h"

#include <Eigen/Dense>
#include <cmath>

#include "ch5_backend/types/edge_imu.h"
#include "ch5_backend/types/edge_reprojection.h"

namespace ch5::homework {
namespace {

constexpr double kStep = 1e-5;  // error of central differences: kStep² ≈ rounding / kStep

// The motion by ε along one direction of the gauge.
Motion Along(GaugeGroup group, int direction, double epsilon) {
  if (direction < 3) return {1.0, Qd::Identity(), epsilon * Vec3::Unit(direction)};
  if (direction == 6) return {std::exp(epsilon), Qd::Identity(), Vec3::Zero()};
  return {1.0, ExpSO3(epsilon * AxesOf(group).col(direction - 3)), Vec3::Zero()};
}

// What g makes of a vertex, as a step from x0.
VecX Moved(const Motion& g, Vertex* vertex, const VecX& x0) {
  const VecX before = vertex->Parameters();
  g.ActOn(vertex);
  const VecX step = vertex->Minus(x0);
  vertex->Parameters() = before;
  return step;
}

Qd RandomRotation(Random* random, double angle) {
  return ExpSO3(UniformVector(random, Vec3::Constant(-angle), Vec3::Constant(angle)));
}

Vec2 RandomPixel(Random* random) { return RandomMatrix(2, 1, random); }

}  // namespace

void Motion::ActOn(Vertex* vertex) const {
  if (auto* pose = dynamic_cast<VertexPose*>(vertex)) {
    pose->SetPose(R * pose->q(), *this * pose->p());
  } else if (auto* point = dynamic_cast<VertexPointXYZ*>(vertex)) {
    point->SetEstimate(*this * point->GetEstimate());
  } else if (auto* inverse_depth = dynamic_cast<VertexInverseDepth*>(vertex)) {
    inverse_depth->Parameters() /= s;
  } else if (auto* speed_bias = dynamic_cast<VertexSpeedBias*>(vertex)) {
    speed_bias->Parameters().head<3>() = s * (R * speed_bias->v());
  }
}

void MoveAll(const Motion& g, const Vertices& vertices) {
  for (const auto& vertex : vertices) g.ActOn(vertex.get());
}

Names DirectionNames(GaugeGroup group) {
  Names names = {Word("x"), Word("y"), Word("z"), "scene.yaw", "scene.roll", "scene.pitch", "scene.scale"};
  names.resize(group == GaugeGroup::kVisualInertial ? 4 : 7);
  return names;
}

Names RowNames(const Vertices& vertices) {
  Ordering ordering;
  ordering.poses = vertices;
  return RowNames(ordering);
}

Text NameOf(GaugeGroup group) { return group == GaugeGroup::kVisualInertial ? "4.camera_IMU" : "4.camera_alone"; }

MatXX AxesOf(GaugeGroup group) {
  MatXX axes(3, group == GaugeGroup::kVisualInertial ? 1 : 3);
  axes.col(0) = Vec3::UnitZ();
  if (axes.cols() == 3) axes.rightCols<2>() = Mat33::Identity().leftCols<2>();
  return axes;
}

MatXX NumericNullSpace(const Vertices& vertices, GaugeGroup group) {
  const int columns = static_cast<int>(DirectionNames(group).size());
  MatXX U(TotalLocalDimension(vertices), columns);
  int row = 0;
  for (const auto& vertex : vertices) {
    const VecX x = vertex->Parameters();
    for (int k = 0; k < columns; ++k) {
      const VecX forward = Moved(Along(group, k, kStep), vertex.get(), x);
      U.block(row, k, forward.size(), 1) = (forward - Moved(Along(group, k, -kStep), vertex.get(), x)) / (2.0 * kStep);
    }
    row += vertex->LocalDimension();
  }
  return U;
}

MatXX NumericMotionJacobian(const Vertices& vertices, const Motion& g) {
  const int n = TotalLocalDimension(vertices);
  MatXX J = MatXX::Zero(n, n);
  int row = 0;
  for (const auto& vertex : vertices) {
    const int dim = vertex->LocalDimension();
    const VecX x = vertex->Parameters();
    g.ActOn(vertex.get());
    const VecX y = vertex->Parameters();
    const auto from = [&](int k, double step) {
      vertex->Parameters() = x;
      const VecX delta = step * VecX::Unit(dim, k);
      vertex->Plus(delta.data());
      return Moved(g, vertex.get(), y);
    };
    for (int k = 0; k < dim; ++k) {
      J.block(row, row + k, dim, 1) = (from(k, kStep) - from(k, -kStep)) / (2.0 * kStep);
    }
    vertex->Parameters() = x;
    row += dim;
  }
  return J;
}

std::shared_ptr<VertexPose> RandomPose(Random* random) {
  const Qd q = RandomRotation(random, 1.5);
  return std::make_shared<VertexPose>(q, UniformVector(random, Vec3::Constant(-4), Vec3::Constant(4)));
}

std::shared_ptr<VertexSpeedBias> RandomSpeedBias(Random* random) {
  return std::make_shared<VertexSpeedBias>(Vec9(2.0 * RandomMatrix(9, 1, random)));
}

std::shared_ptr<VertexPointXYZ> RandomPoint(Random* random) {
  return std::make_shared<VertexPointXYZ>(UniformVector(random, Vec3::Constant(-4), Vec3::Constant(4)));
}

Vertices RandomVertices(int count, Random* random) {
  Vertices vertices;
  for (int i = 0; i < count; ++i) {
    std::shared_ptr<Vertex> vertex;
    switch (i < 4 ? i : static_cast<int>(random->Bits() % 4)) {
      case 0: vertex = RandomPose(random); break;
      case 1: vertex = RandomSpeedBias(random); break;
      case 2: vertex = RandomPoint(random); break;
      default: vertex = std::make_shared<VertexInverseDepth>(random->Uniform(0.1, 1.0));
    }
    vertices.insert(vertices.begin() + static_cast<long>(random->Bits() % (vertices.size() + 1)), vertex);
  }
  return vertices;
}

FreeScene::FreeScene(GaugeGroup group, int frames, int points, uint64_t seed) {
  Random random(Seed(seed));
  const Qd look = RandomRotation(&random, 1.5);  // where the cameras look to
  std::vector<std::shared_ptr<VertexPose>> poses;
  for (int i = 0; i < frames; ++i) {
    const Vec3 p = Vec3(i, 0.3 * i * i, 0) + UniformVector(&random, Vec3::Constant(-0.3), Vec3::Constant(0.3));
    poses.push_back(std::make_shared<VertexPose>(look * RandomRotation(&random, 0.2), look * p));
    graph.AddVertex(poses.back());
  }
  for (int k = 0; k < points; ++k) {
    auto point = std::make_shared<VertexPointXYZ>(look * UniformVector(&random, {-2, -2, 4}, {5, 5, 9}));
    graph.AddVertex(point);
    for (const auto& pose : poses) {
      graph.AddEdge(std::make_shared<EdgeReprojectionXYZ>(point, pose, RandomPixel(&random)));
      graph.Edges().back()->SetInformation(100.0 * RandomPositiveDefinite(2, &random));
    }
  }
  auto depth = std::make_shared<VertexInverseDepth>(0.2);
  graph.AddVertex(depth);
  for (size_t i = 1; i < poses.size(); ++i) {
    const Vec2 host = 0.2 * RandomPixel(&random);
    graph.AddEdge(std::make_shared<EdgeReprojection>(depth, poses[0], poses[i], host, RandomPixel(&random)));
    graph.Edges().back()->SetInformation(100.0 * RandomPositiveDefinite(2, &random));
  }
  if (group == GaugeGroup::kVisualInertial) AddImu(&random);
  const Ordering ordering = MakeOrdering(graph);
  vertices = ordering.poses;
  vertices.insert(vertices.end(), ordering.landmarks.begin(), ordering.landmarks.end());
}

void FreeScene::AddImu(Random* random) {
  std::vector<std::shared_ptr<VertexPose>> poses;
  for (const auto& vertex : graph.Vertices()) {
    if (auto pose = std::dynamic_pointer_cast<VertexPose>(vertex)) poses.push_back(pose);
  }
  std::vector<std::shared_ptr<VertexSpeedBias>> speeds;
  for (size_t i = 0; i < poses.size(); ++i) {
    speeds.push_back(RandomSpeedBias(random));
    graph.AddVertex(speeds.back());
    if (i == 0) continue;
    const Vec3 rate = 0.3 * RandomMatrix(3, 1, random), force = Vec3(0, 0, 9.81) + RandomMatrix(3, 1, random);
    auto imu = std::make_shared<Preintegration>(ImuSample{0.0, force, rate}, Vec3::Zero(), Vec3::Zero(), ImuNoise());
    for (int k = 0; k < 20; ++k) imu->Add({0.05, force + 0.3 * RandomMatrix(3, 1, random), rate});
    graph.AddEdge(std::make_shared<EdgeImu>(poses[i - 1], speeds[i - 1], poses[i], speeds[i], imu));
    graph.Edges().back()->SetInformation(RandomPositiveDefinite(15, random));  // milder than the sensor's
  }
}

MatXX FreeScene::Hessian() const { return StackedNormalEquations(graph, TotalLocalDimension(vertices)).H; }

MatXX FreeScene::FirstFrame(GaugeGroup group) const {
  const auto& first = dynamic_cast<const VertexPose&>(*vertices[0]);
  const auto& second = dynamic_cast<const VertexPose&>(*vertices[1]);
  MatXX V = MatXX::Zero(TotalLocalDimension(vertices), static_cast<Eigen::Index>(DirectionNames(group).size()));
  V.topLeftCorner<3, 3>().setIdentity();
  if (group == GaugeGroup::kVisualInertial) {
    V.block<3, 1>(3, 3) = first.R().transpose() * Vec3::UnitZ();  // e_zᵀ R δθ
  } else {
    V.block<3, 3>(3, 3).setIdentity();
    V.block<3, 1>(6, 6) = (second.p() - first.p()).normalized();
  }
  return V;
}

MatXX FreeCovariance(const MatXX& H, int nullity) {
  const Eigen::SelfAdjointEigenSolver<MatXX> eigen(H);
  const Eigen::Index rank = H.rows() - nullity;
  const MatXX range = eigen.eigenvectors().rightCols(rank);
  return range * eigen.eigenvalues().tail(rank).cwiseInverse().asDiagonal() * range.transpose();
}

MatXX FixedCovariance(const MatXX& H, const MatXX& V) {
  const MatXX N = Complement(V);
  return N * (N.transpose() * H * N).ldlt().solve(N.transpose());
}

MatXX Complement(const MatXX& V) {
  const MatXX basis = Eigen::HouseholderQR<MatXX>(V).householderQ();
  return basis.rightCols(V.rows() - V.cols());
}

}  // namespace ch5::homework
