/// States without a gauge: stage 4.

#include "ch5_backend/consistency/gauge_freedom.h"
#include "ch5_backend/graph/ordering.h"
#include "ch5_backend/types/inertial/edge_imu.h"
#include "ch5_backend/types/visual/edge_reprojection.h"
#include "ch5_homework/judge/scenes/scene.h"

namespace ch5::homework {
namespace {

Qd RandomRotation(Random* random, double angle) {
  return ExpSO3(UniformVector(random, Vec3::Constant(-angle), Vec3::Constant(angle)));
}

Vec2 RandomPixel(Random* random) { return RandomMatrix(2, 1, random); }

std::shared_ptr<VertexPose> RandomPose(Random* random) {
  const Qd q = RandomRotation(random, 1.5);
  return std::make_shared<VertexPose>(q, UniformVector(random, Vec3::Constant(-4), Vec3::Constant(4)));
}

std::shared_ptr<VertexSpeedBias> RandomSpeedBias(Random* random) {
  return std::make_shared<VertexSpeedBias>(Vec9(2.0 * RandomMatrix(9, 1, random)));
}

std::shared_ptr<Vertex> RandomVertex(uint64_t type, Random* random) {
  switch (type) {
    case 0: return RandomPose(random);
    case 1: return RandomSpeedBias(random);
    case 2: return std::make_shared<VertexPointXYZ>(UniformVector(random, Vec3::Constant(-4), Vec3::Constant(4)));
    default: return std::make_shared<VertexInverseDepth>(random->Uniform(0.1, 1.0));
  }
}

// R takes x to y, y to z and z to x; p = (2, 1, 0).
void PoseOnPaper(GraphScene* s) { s->vertices = {std::make_shared<VertexPose>(Qd(0.5, 0.5, 0.5, 0.5), Vec3(2, 1, 0))}; }

// So many vertices of a type, 0 for poses, 1 for speeds and biases, 2 for points; and what sets their seed.
void VerticesOfAType(GraphScene* s) {
  s->random = Random(Seed(static_cast<uint64_t>(s->GetSizes().at(2))));
  for (int k = 0; k < s->GetSizes().at(1); ++k) {
    s->vertices.push_back(RandomVertex(static_cast<uint64_t>(s->GetSizes().at(0)), &s->random));
  }
}

// Four or more vertices, each type at least once, in random order; and what sets their seed.
void VerticesOfAllTypes(GraphScene* s) {
  const int count = s->GetSizes().at(0);
  s->random = Random(Seed(static_cast<uint64_t>(s->GetSizes().at(1) + count)));
  for (int i = 0; i < count; ++i) {
    const uint64_t type = i < 4 ? static_cast<uint64_t>(i) : s->random.Bits() % 4;
    const std::shared_ptr<Vertex> vertex = RandomVertex(type, &s->random);
    s->vertices.insert(s->vertices.begin() + static_cast<long>(s->random.Bits() % (s->vertices.size() + 1)), vertex);
  }
}

void AddImu(GraphScene* s) {
  Random* random = &s->random;
  std::vector<std::shared_ptr<VertexSpeedBias>> speeds;
  for (size_t i = 0; i < s->poses.size(); ++i) {
    speeds.push_back(RandomSpeedBias(random));
    s->graph.AddVertex(speeds.back());
    if (i == 0) continue;
    const Vec3 rate = 0.3 * RandomMatrix(3, 1, random), force = Vec3(0, 0, 9.81) + RandomMatrix(3, 1, random);
    auto imu = std::make_shared<Preintegration>(ImuSample{0.0, force, rate}, Vec3::Zero(), Vec3::Zero(), ImuNoise());
    for (int k = 0; k < 20; ++k) imu->Add({0.05, force + 0.3 * RandomMatrix(3, 1, random), rate});
    s->graph.AddEdge(std::make_shared<EdgeImu>(s->poses[i - 1], speeds[i - 1], s->poses[i], speeds[i], imu));
    s->graph.Edges().back()->SetInformation(RandomPositiveDefinite(15, random));  // milder than the sensor's
  }
}

// A few frames that see points and an inverse depth; with an IMU between them if the group is the visual-inertial one.
// The states are not those of a minimum, and need not be: H U = 0 holds everywhere. `vertices` is in the order of H's rows.
void BuildFreeGraph(GraphScene* s) {
  const auto group = static_cast<GaugeGroup>(s->GetSizes().at(0));
  const int frames = s->GetSizes().at(1), points = s->GetSizes().at(2);
  Random& random = s->random = Random(Seed(static_cast<uint64_t>(s->GetSizes().at(3))));
  const Qd look = RandomRotation(&random, 1.5);  // where the cameras look to
  for (int i = 0; i < frames; ++i) {
    const Vec3 p = Vec3(i, 0.3 * i * i, 0) + UniformVector(&random, Vec3::Constant(-0.3), Vec3::Constant(0.3));
    s->poses.push_back(std::make_shared<VertexPose>(look * RandomRotation(&random, 0.2), look * p));
    s->graph.AddVertex(s->poses.back());
  }
  for (int k = 0; k < points; ++k) {
    auto point = std::make_shared<VertexPointXYZ>(look * UniformVector(&random, {-2, -2, 4}, {5, 5, 9}));
    s->graph.AddVertex(point);
    for (const auto& pose : s->poses) {
      s->graph.AddEdge(std::make_shared<EdgeReprojectionXYZ>(point, pose, RandomPixel(&random)));
      s->graph.Edges().back()->SetInformation(100.0 * RandomPositiveDefinite(2, &random));
    }
  }
  auto depth = std::make_shared<VertexInverseDepth>(0.2);
  s->graph.AddVertex(depth);
  for (size_t i = 1; i < s->poses.size(); ++i) {
    const Vec2 host = 0.2 * RandomPixel(&random);
    s->graph.AddEdge(std::make_shared<EdgeReprojection>(depth, s->poses[0], s->poses[i], host, RandomPixel(&random)));
    s->graph.Edges().back()->SetInformation(100.0 * RandomPositiveDefinite(2, &random));
  }
  if (group == GaugeGroup::kVisualInertial) AddImu(s);
  const Ordering ordering = MakeOrdering(s->graph);
  s->vertices = ordering.poses;
  s->vertices.insert(s->vertices.end(), ordering.landmarks.begin(), ordering.landmarks.end());
}

[[maybe_unused]] const bool free_added = GraphScene::Add({{"pose on paper", &PoseOnPaper},
                                                     {"vertices of a type", &VerticesOfAType},
                                                     {"vertices of all types", &VerticesOfAllTypes},
                                                     {"free graph", &BuildFreeGraph}});

}  // namespace
}  // namespace ch5::homework
