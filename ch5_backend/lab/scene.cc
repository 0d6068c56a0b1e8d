#include "ch5_backend/lab/scene.h"

#include <algorithm>

#include "ch5_backend/dense/blocks/plain_block_solver.h"
#include "ch5_backend/evaluate/reconstruction.h"
#include "ch5_backend/sparse/sparse_solver.h"

namespace ch5::lab {
namespace {

constexpr double kRotationOfStart = 2.0 * M_PI / 180.0 / 0.1;  // a start beside the truth is so much turned [rad/m]
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
  settings.pixel_information = query->Word("information", {"unit", "noise"}) ? 1.0 / (sigma * sigma) : 1.0;
  settings.outliers = query->Whole("outliers", 0, 0, settings.scene.points);
  settings.loss = query->Word("loss", {"none", "huber", "cauchy", "tukey"});
  settings.delta = query->Number("delta", 2.0, 0.01, 1e3);
  ReadSolver(query, &settings);
  return settings;
}

SceneGraph::SceneGraph(const SceneSettings& settings) : scene(SimulateMonoBa(settings.scene)) {
  for (int k = 0; k < settings.outliers; ++k) scene.pixels.back()[static_cast<size_t>(k)].x() += kOutlier;
  BuildMonoBa(scene, settings.gauge, settings.pixel_information, settings.weight, &ba);
  // A residual's unit is 1/√W; the threshold is asked for in σ.
  const double sigma = std::max(settings.scene.pixel_sigma, 1e-4);
  const auto loss = MakeLoss(settings.loss, settings.delta * sigma * std::sqrt(settings.pixel_information));
  for (const auto& edge : ba.graph.Edges()) {
    if (edge->TypeInfo() == "EdgeReprojection") edge->SetLossFunction(loss);
  }
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
    Json variable;
    variable.Add("kind", kind).Add("number", static_cast<int>(number));
    variables.push_back(variable.Add("row", vertex.OrderingId()).Add("rows", vertex.LocalDimension()));
  };
  for (size_t i = 0; i < graph.ba.poses.size(); ++i) add("pose", i, *graph.ba.poses[i]);
  for (size_t k = 0; k < graph.ba.landmarks.size(); ++k) add("landmark", k, *graph.ba.landmarks[k]);
  return variables;
}

Json Truth(const SceneGraph& graph) { return ToJson(TruthOf(graph.scene)); }

Json Estimate(const SceneGraph& graph) { return ToJson(EstimateOf(graph.scene, graph.ba)); }

}  // namespace ch5::lab
