// False loops in a pose graph: which loops graduated non-convexity gives up (initialize/graduated.h), where it ends beside the
// graph without them, and where plain least squares does.
#include <algorithm>
#include <chrono>
#include <set>
#include <stdexcept>

#include "ch5_backend/experiments/studies/pose_graph_study.h"
#include "ch5_backend/experiments/studies/systems/system_studies.h"
#include "ch5_backend/simulate/random.h"
#include "ch5_backend/types/pose_graph/as_transform.h"

namespace ch5 {
namespace {

constexpr const char* kWithLoops[] = {"intel", "parking-garage", "sphere2500", "simulated Manhattan"};

// A walk of 3,500 steps along streets 1 m apart, as in M3500: measured from step to step, and at half of the steps to an
// earlier one that was near. The poses are the truth.
G2oFile SimulateManhattan() {
  constexpr int kPoses = 3500, kFewestSteps = 50;
  constexpr double kSide = 15.0, kNear = 1.5, kSigma = 0.05, kSigmaAngle = 0.02;  // [m], [rad]
  Random random(1);
  G2oFile file;
  std::vector<Transform> T_W_B;
  Vec3 place = Vec3::Zero();
  int heading = 0;
  const auto ahead = [&] { return Vec3(Vec3::Unit(heading % 2) * (heading < 2 ? 1.0 : -1.0)); };
  for (int k = 0; k < kPoses; ++k) {
    const double angle = 0.5 * M_PI * heading;
    T_W_B.push_back({ExpSO3({0.0, 0.0, angle}), place});
    file.graph.AddVertex(std::make_shared<VertexSE2>(place.head<2>(), angle));
    file.ids.push_back(k);
    const int turn = static_cast<int>(random.Uniform() * 6.0);  // to the left, to the right, or four times straight on
    heading = (heading + (turn == 0 ? 1 : turn == 1 ? 3 : 0)) % 4;
    while ((place + ahead()).cwiseAbs().maxCoeff() > kSide) heading = (heading + 1) % 4;
    place += ahead();
  }
  const Vec3 weights(1.0 / (kSigma * kSigma), 1.0 / (kSigma * kSigma), 1.0 / (kSigmaAngle * kSigmaAngle));
  const auto measure = [&](int i, int j) {
    Transform T_i_j = Inverse(T_W_B[i]) * T_W_B[j];
    T_i_j.p.head<2>() += NormalVector<2>(&random, kSigma);
    T_i_j.q = T_i_j.q * ExpSO3({0.0, 0.0, kSigmaAngle * random.Normal()});
    const auto& vertices = file.graph.Vertices();
    file.graph.AddEdge(MakeBetween(vertices[i], vertices[j], T_i_j, weights.asDiagonal().toDenseMatrix()));
  };
  for (int j = 1; j < kPoses; ++j) {
    measure(j - 1, j);
    std::vector<int> near;
    for (int i = 0; i + kFewestSteps < j; ++i)
      if ((T_W_B[i].p - T_W_B[j].p).norm() < kNear) near.push_back(i);
    if (!near.empty() && random.Uniform() < 0.5)
      measure(near[static_cast<size_t>(random.Uniform() * static_cast<double>(near.size()))], j);
  }
  return file;
}

G2oFile ReadGraph(size_t set, const std::filesystem::path& data) {
  const std::string name = kWithLoops[set];
  return name.rfind("simulated", 0) == 0 ? SimulateManhattan()
                                         : ReadG2o((data / "posegraph" / (name + ".g2o")).string());
}

// Adds `count` of them. Single: any two poses, and any transform of up to 15 m. Grouped: ten in a row that agree with each
// other, as of two places that look alike.
std::set<const Edge*> AddFalseLoops(size_t count, bool grouped, uint64_t seed, const std::vector<Transform>& truth,
                                    Graph* graph) {
  constexpr double kFar = 15.0;  // [m]
  constexpr int kGroup = 10;
  Random random(seed);
  const std::vector<std::shared_ptr<Vertex>> vertices = graph->Vertices();
  const int n = static_cast<int>(vertices.size());
  const bool flat = std::dynamic_pointer_cast<VertexSE2>(vertices[0]) != nullptr;
  std::set<std::pair<int, int>> known;
  for (const auto& edge : graph->Edges())
    known.insert(std::minmax({edge->Vertices()[0]->Id(), edge->Vertices()[1]->Id()}));
  const MatXX W = FindLoops(*graph).front().edge->Information();
  const auto somewhere = [&](double reach) {
    Vec3 p, turn = NormalVector(&random, 2.0);
    for (int axis = 0; axis < 3; ++axis) p[axis] = random.Uniform(-reach, reach);
    if (flat) p.z() = turn.x() = turn.y() = 0.0;
    return Transform{ExpSO3(turn), p};
  };
  std::set<const Edge*> added;
  const auto add = [&](int i, int j, const Transform& T_i_j) {
    if (std::max(i, j) >= n || std::abs(i - j) < 2 || added.size() == count) return;
    if (!known.insert(std::minmax(i, j)).second) return;
    const auto edge = MakeBetween(vertices[i], vertices[j], T_i_j, W);
    graph->AddEdge(edge);
    added.insert(edge.get());
  };
  while (added.size() < count) {
    const int i = static_cast<int>(random.Uniform() * n), j = static_cast<int>(random.Uniform() * n);
    if (!grouped) {
      add(i, j, somewhere(kFar));
      continue;
    }
    const Transform beside = truth[i] * somewhere(1.0) * Inverse(truth[j]);  // lays the second walk beside the first
    for (int k = 0; k < kGroup && std::max(i, j) + k < n; ++k)
      add(i + k, j + k, Inverse(truth[i + k]) * beside * truth[j + k]);
  }
  return added;
}

// The root of the mean square of the distances between positions; the first pose of both is held.
double Distance(const std::vector<Transform>& truth, const G2oFile& file) {
  double squares = 0.0;
  for (size_t k = 0; k < truth.size(); ++k)
    squares += (PoseOf(*file.graph.Vertices()[k])->p - truth[k].p).squaredNorm();
  return std::sqrt(squares / static_cast<double>(truth.size()));
}

}  // namespace

CsvTable FalseLoopsTable(int trial, const std::filesystem::path& data) {
  CsvTable table(
      "data_set,poses,edges,loops,trial,kind,false_loops,way,found,good_lost,cost,rmse_m,iterations,seconds");
  constexpr size_t kSets = std::size(kWithLoops);
  constexpr int kSeeds = 3;
  const size_t set = static_cast<size_t>(trial) % kSets;
  const int seed = trial / static_cast<int>(kSets);
  if (seed >= kSeeds) throw std::invalid_argument("false_loops has no trial " + std::to_string(trial));
  std::vector<Transform> truth;  // the optimum without false loops, which a group of them is laid upon
  const auto solve = [&](const std::string& kind, size_t count, const std::string& way) {
    G2oFile file = ReadGraph(set, data);
    const size_t edges = file.graph.Edges().size(), loops = FindLoops(file.graph).size();
    const auto added = AddFalseLoops(count, kind == "grouped", 1 + static_cast<uint64_t>(seed), truth, &file.graph);
    PoseGraphOptions options;
    options.gnc = way == "gnc";
    if (way == "plain") options.solve.max_iterations = 100;
    const auto begin = std::chrono::steady_clock::now();
    const PoseGraphStudy study = SolvePoseGraph(options, &file);
    const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    size_t found = 0, lost = 0;
    for (const LoopVerdict& loop : study.loops) {
      if (loop.IsFalse()) ++(added.count(loop.edge) > 0 ? found : lost);
    }
    if (truth.empty()) {
      for (size_t k = 0; k < file.ids.size(); ++k) truth.push_back(*PoseOf(*file.graph.Vertices()[k]));
    }
    table.Row(kWithLoops[set], file.ids.size(), edges, loops, seed, kind, count, way, found, lost,
              study.summary.final_cost, Distance(truth, file), study.summary.iterations, seconds);
  };
  solve("none", 0, "plain");
  solve("none", 0, "gnc");
  for (const char* kind : {"single", "grouped"}) {
    for (const size_t count : {10, 100}) {
      for (const char* way : {"plain", "gnc"}) solve(kind, count, way);
    }
  }
  return table;
}

}  // namespace ch5
