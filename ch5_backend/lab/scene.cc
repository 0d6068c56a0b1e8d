#include "ch5_backend/lab/scene.h"

#include <algorithm>
#include <map>

#include "ch5_backend/dense/blocks/plain_block_solver.h"
#include "ch5_backend/evaluate/reconstruction.h"
#include "ch5_backend/sparse/sparse_solver.h"

namespace ch5::lab {
namespace {

constexpr double kRotationOfStart = 2.0 * M_PI / 180.0 / 0.1;  // a start beside the truth is so much turned [rad/m]
constexpr double kNearest = 0.1;                               // depth of a start that was dragged [m]
constexpr double kOutlier = 0.05;                              // in the normalized plane: 50 σ of the course's noise

void ReadSolver(Query* query, SceneSettings* settings) {
  settings->damping = query->Word("damping", {"identity", "diagonal"}) ? Damping::kDiagonal : Damping::kIdentity;
  constexpr Algorithm kAlgorithms[] = {Algorithm::kLevenbergMarquardt, Algorithm::kGaussNewton, Algorithm::kDogleg};
  settings->options.algorithm = kAlgorithms[query->Word("algorithm", {"lm", "gn", "dogleg"})];
  settings->options.tau = query->Number("tau", settings->options.tau, 1e-12, 1e3);
  settings->options.initial_radius = query->Number("radius", settings->options.initial_radius, 1e-6, 1e6);
  settings->options.max_iterations = query->Whole("iterations", settings->options.max_iterations, 0, 100);
  settings->solver = static_cast<Solver>(query->Word("solver", {"dense", "blocks", "sparse"}));
}

void ReadDrags(Query* query, SceneSettings* settings) {
  settings->turns_in_place = query->Word("motion", {"arc", "turn"}) == 1;
  Drags& drags = settings->drags;
  drags.cameras = query->Items("cameras", 2);
  drags.landmarks = query->Items("landmarks", 2);
  drags.camera_starts = query->Items("camera_starts", 2);
  drags.landmark_starts = query->Items("landmark_starts", 2);
  settings->without = query->Items("without", 1);
}

Vec2 Project(const Transform& T_W_C, const Vec3& p_W) { return (T_W_C.q.conjugate() * (p_W - T_W_C.p)).hnormalized(); }

Vec3 ShiftOf(const Query::Item& item) { return {item.reals[0], item.reals[1], 0.0}; }

// Calls move(number, shift) for the items that the scene has.
template <typename Move>
void ForEach(const std::vector<Query::Item>& items, size_t count, Move move) {
  for (const Query::Item& item : items) {
    if (static_cast<size_t>(item.number) < count) move(static_cast<size_t>(item.number), ShiftOf(item));
  }
}

// Cameras and landmarks move; each observation keeps its noise, each start its error.
void MoveTruth(const SceneSettings& settings, MonoBaScene* scene) {
  const MonoBaScene old = *scene;
  if (settings.turns_in_place) {
    for (Transform& T_W_C : scene->frames) T_W_C.p.setZero();
  }
  ForEach(settings.drags.cameras, scene->frames.size(),
          [&](size_t i, const Vec3& shift) { scene->frames[i].p += shift; });
  ForEach(settings.drags.landmarks, scene->points.size(),
          [&](size_t k, const Vec3& shift) { scene->points[k] += shift; });
  for (size_t i = 0; i < scene->frames.size(); ++i) {
    scene->initial_frames[i].p += scene->frames[i].p - old.frames[i].p;
    for (size_t k = 0; k < scene->points.size(); ++k) {
      scene->pixels[i][k] += Project(scene->frames[i], scene->points[k]) - Project(old.frames[i], old.points[k]);
    }
  }
}

// A landmark's start is a depth on the ray of its host: it follows the part of the shift along the ray as it is seen in
// the picture.
void MoveStarts(const Drags& drags, MonoBaScene* scene) {
  ForEach(drags.camera_starts, scene->frames.size(),
          [&](size_t i, const Vec3& shift) { scene->initial_frames[i].p += shift; });
  ForEach(drags.landmark_starts, scene->points.size(), [&](size_t k, const Vec3& shift) {
    const Vec2 ray = (scene->initial_frames[0].q * scene->pixels[0][k].homogeneous()).head<2>();
    const double depth = 1.0 / scene->initial_inverse_depths[k] + ray.dot(shift.head<2>()) / (ray.squaredNorm() + 1e-9);
    scene->initial_inverse_depths[k] = 1.0 / std::max(depth, kNearest);
  });
}

MonoBaScene MakeScene(const SceneSettings& settings) {
  MonoBaScene scene = SimulateMonoBa(settings.scene);
  MoveTruth(settings, &scene);
  MoveStarts(settings.drags, &scene);
  for (int k = 0; k < settings.outliers; ++k) scene.pixels.back()[static_cast<size_t>(k)].x() += kOutlier;
  return scene;
}

std::shared_ptr<const LossFunction> MakeLoss(int loss, double delta) {
  switch (loss) {
    case 1: return std::make_shared<HuberLoss>(delta);
    case 2: return std::make_shared<CauchyLoss>(delta);
    case 3: return std::make_shared<TukeyLoss>(delta);
    default: return nullptr;
  }
}

Json ToJson(const Reconstruction& reconstruction) {
  return Json().Add("frames", reconstruction.frames).Add("points", reconstruction.points);
}

}  // namespace

SceneSettings ReadScene(Query* query) {
  SceneSettings settings;
  settings.scene.frames = query->Whole("frames", 3, 2, 10);
  settings.scene.points = query->Whole("points", 20, 4, 40);
  settings.scene.pixel_sigma = query->Number("noise", 1e-3, 0.0, 0.1);
  settings.scene.depth_sigma = query->Number("depth", 1.0, 0.0, 3.0);
  settings.scene.position_sigma = query->Number("start", 0.0, 0.0, 1.0);
  settings.scene.rotation_sigma = kRotationOfStart * settings.scene.position_sigma;
  settings.scene.seed = static_cast<uint64_t>(query->Whole("seed", 5, 0, 999));
  constexpr Gauge kGauges[] = {Gauge::kPriorTwoFrames, Gauge::kPriorMinimal, Gauge::kFixTwoFrames, Gauge::kFree};
  settings.gauge = kGauges[query->Word("gauge", {"prior", "minimal", "fixed", "free"})];
  settings.weight = query->Number("weight", 1.0, 0.0, 1e12);
  const double sigma = std::max(settings.scene.pixel_sigma, 1e-4);
  settings.is_calibrated = query->Word("information", {"unit", "noise"}) == 1;
  settings.pixel_information = settings.is_calibrated ? 1.0 / (sigma * sigma) : 1.0;
  settings.outliers = query->Whole("outliers", 0, 0, settings.scene.points);
  settings.loss = query->Word("loss", {"none", "huber", "cauchy", "tukey"});
  settings.delta = query->Number("delta", 2.0, 0.01, 1e3);
  ReadDrags(query, &settings);
  ReadSolver(query, &settings);
  return settings;
}

SceneGraph::SceneGraph(const SceneSettings& settings)
    : scene(MakeScene(settings)), ba(BuildMonoBa(scene, settings.gauge, settings.pixel_information, settings.weight)) {
  // A residual's unit is 1/√W; the threshold is given in σ.
  const double sigma = std::max(settings.scene.pixel_sigma, 1e-4);
  const auto loss = MakeLoss(settings.loss, settings.delta * sigma * std::sqrt(settings.pixel_information));
  for (const auto& edge : ba.graph.Edges()) {
    if (edge->TypeInfo() == "EdgeReprojection") edge->SetLossFunction(loss);
  }
  for (const Observation& one : ObservationsOf(*this)) {
    const bool is_out = std::any_of(settings.without.begin(), settings.without.end(), [&](const Query::Item& item) {
      return item.number == one.landmark && item.reals[0] == one.frame;
    });
    if (is_out) ba.graph.RemoveEdge(one.edge);
  }
}

std::vector<Observation> ObservationsOf(const SceneGraph& graph) {
  std::map<const Vertex*, int> numbers;
  int number = 0;
  for (const auto& pose : graph.ba.poses) numbers[pose.get()] = number++;
  number = 0;
  for (const auto& landmark : graph.ba.landmarks) numbers[landmark.get()] = number++;
  std::vector<Observation> observations;
  for (const auto& edge : graph.ba.graph.Edges()) {
    if (edge->TypeInfo() != "EdgeReprojection") continue;
    const auto& vertices = edge->Vertices();  // landmark, host, target
    observations.push_back({numbers[vertices[0].get()], numbers[vertices[2].get()], edge});
  }
  return observations;
}

std::unique_ptr<NormalEquations> MakeSystem(const SceneSettings& settings, Graph* graph) {
  std::unique_ptr<NormalEquations> system;
  switch (settings.solver) {
    case Solver::kDense: system = std::make_unique<Problem>(graph); break;
    case Solver::kBlocks: system = std::make_unique<PlainBlockSolver>(graph); break;
    case Solver::kSparse: system = std::make_unique<SparseSolver>(graph); break;
  }
  system->SetDamping(settings.damping);
  return system;
}

std::vector<Json> VariablesOf(const SceneGraph& graph) {
  std::vector<Json> variables;
  const auto add = [&](const char* kind, size_t number, const Vertex& vertex) {
    variables.push_back(VariableJson(kind, static_cast<int>(number), vertex.OrderingId(), vertex.LocalDimension()));
  };
  for (size_t i = 0; i < graph.ba.poses.size(); ++i) add("pose", i, *graph.ba.poses[i]);
  for (size_t k = 0; k < graph.ba.landmarks.size(); ++k) add("landmark", k, *graph.ba.landmarks[k]);
  return variables;
}

Json Truth(const SceneGraph& graph) { return ToJson(TruthOf(graph.scene)); }

Json Estimate(const SceneGraph& graph) { return ToJson(EstimateOf(graph.scene, graph.ba)); }

}  // namespace ch5::lab
