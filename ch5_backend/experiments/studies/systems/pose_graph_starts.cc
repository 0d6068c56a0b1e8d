// Where a pose graph's optimization begins, and where it ends: each start of initialize_pose_graph.h on each data set.
// Carlone et al., ICRA 2015
#include <stdexcept>

#include "ch5_backend/experiments/studies/pose_graph_study.h"
#include "ch5_backend/experiments/studies/systems/system_studies.h"
#include "ch5_backend/simulate/random.h"
#include "ch5_backend/types/pose_graph/as_transform.h"

namespace ch5 {
namespace {

constexpr const char* kGraphs[] = {"intel", "MIT", "CSAIL", "parking-garage", "sphere2500"};
constexpr size_t kSimulated = std::size(kGraphs);

// A path in rings around a sphere of 50 m, from pole to pole, measured along the path and to the ring below, with a noise
// of 1 m and 0.3 rad. The poses are the truth.
G2oFile SimulateSphere() {
  constexpr int kRings = 40, kPosesOfRing = 50, kPoses = kRings * kPosesOfRing;
  constexpr double kSigmaPosition = 1.0, kSigmaRotation = 0.3;
  G2oFile file;
  std::vector<std::shared_ptr<VertexPose>> poses;
  for (int k = 0; k < kPoses; ++k) {
    const double longitude = 2.0 * M_PI * k / kPosesOfRing, latitude = M_PI * (static_cast<double>(k) / kPoses - 0.5);
    const Qd q = ExpSO3({0.0, 0.0, longitude}) * ExpSO3({0.0, -latitude, 0.0});
    poses.push_back(std::make_shared<VertexPose>(q, q * Vec3(50.0, 0.0, 0.0)));
    file.graph.AddVertex(poses.back());
    file.ids.push_back(k);
  }
  Random random(1);
  Vec6 weights;  // r holds half of the rotation vector
  weights << Vec3::Constant(1.0 / (kSigmaPosition * kSigmaPosition)),
      Vec3::Constant(4.0 / (kSigmaRotation * kSigmaRotation));
  for (int i = 0; i < kPoses; ++i) {
    for (const int j : {i + 1, i + kPosesOfRing}) {
      if (j >= kPoses) continue;
      const Transform T_i_j = Inverse({poses[i]->q(), poses[i]->p()}) * Transform{poses[j]->q(), poses[j]->p()};
      const Vec3 position = T_i_j.p + NormalVector(&random, kSigmaPosition);
      const Qd rotation = T_i_j.q * ExpSO3(NormalVector(&random, kSigmaRotation));
      file.graph.AddEdge(MakeBetween(poses[i], poses[j], {rotation, position}, weights.asDiagonal().toDenseMatrix()));
    }
  }
  return file;
}

}  // namespace

CsvTable PoseGraphStartsTable(int trial, const std::filesystem::path& data) {
  CsvTable table("data_set,poses,edges,start,first_cost,cost,iterations,termination,seconds_to_start,seconds");
  const size_t set = static_cast<size_t>(trial);
  if (set > kSimulated) throw std::invalid_argument("pose_graph_starts has no trial " + std::to_string(trial));
  const std::string name = set == kSimulated ? "simulated sphere" : kGraphs[set];
  for (const auto& [word, start] : kPoseGraphStartNames) {
    G2oFile file = set == kSimulated ? SimulateSphere() : ReadG2o((data / "posegraph" / (name + ".g2o")).string());
    if (start == PoseGraphStart::kGiven && !file.has_poses) continue;
    if (start == PoseGraphStart::kIncremental) continue;  // for landmarks, of which these graphs have none
    PoseGraphOptions options;
    options.start = start;
    const PoseGraphStudy study = SolvePoseGraph(options, &file);
    table.Row(name, file.ids.size(), file.graph.Edges().size(), word, study.summary.initial_cost,
              study.summary.final_cost, study.summary.iterations, ToString(study.summary.termination),
              study.seconds_to_start, study.summary.seconds);
  }
  return table;
}

}  // namespace ch5
