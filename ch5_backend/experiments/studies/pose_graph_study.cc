#include "ch5_backend/experiments/studies/pose_graph_study.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <numeric>
#include <stdexcept>

#include "ch5_backend/initialize/spanning_tree.h"

namespace ch5 {
namespace {

std::vector<double> Chi2OfEdges(const Graph& graph) {
  std::vector<double> chi2;
  for (const auto& edge : graph.Edges()) {
    edge->ComputeResidual();
    chi2.push_back(edge->Chi2());
  }
  return chi2;
}

double Sum(const std::vector<double>& values) { return std::accumulate(values.begin(), values.end(), 0.0); }

CsvTable SummaryOf(const PoseGraphStudy& study, const G2oFile& file, const PoseGraphOptions& options) {
  CsvTable table = SummaryTable(study.summary, options);
  table.Row("vertices", file.graph.Vertices().size());
  table.Row("edges", file.graph.Edges().size());
  table.Row("chi2_before", Sum(study.chi2_before));
  table.Row("chi2", Sum(Chi2OfEdges(file.graph)));
  table.Row("start", NameOf(study.start));
  table.Row("seconds_to_start", study.seconds_to_start);
  table.Row("projected_information", file.projected);
  table.Row("unknown_lines", file.unknown.size());
  table.Row("huber", options.huber);
  return table;
}

// [x, y, z, qx, qy, qz, qw] of either kind of pose.
Vec7 Pose(const VecX& x) {
  Vec7 pose;
  if (x.size() == 7) {
    pose = x;
  } else {
    pose << x[0], x[1], 0.0, 0.0, 0.0, std::sin(0.5 * x[2]), std::cos(0.5 * x[2]);
  }
  return pose;
}

CsvTable PoseTable(const PoseGraphStudy& study, const G2oFile& file) {
  CsvTable table("state,id,x,y,z,qx,qy,qz,qw");
  for (const std::string state : {"before", "after"}) {
    for (size_t i = 0; i < file.ids.size(); ++i) {
      const Vec7 p = Pose(state == "before" ? study.poses_before[i] : file.graph.Vertices()[i]->Parameters());
      table.Row(state, file.ids[i], p[0], p[1], p[2], p[3], p[4], p[5], p[6]);
    }
  }
  return table;
}

CsvTable EdgeTable(const PoseGraphStudy& study, const G2oFile& file) {
  CsvTable table("i,j,chi2_before,chi2_after");
  const std::vector<double> chi2 = Chi2OfEdges(file.graph);
  for (size_t e = 0; e < chi2.size(); ++e) {
    const auto& vertices = file.graph.Edges()[e]->Vertices();
    table.Row(file.ids[vertices[0]->Id()], file.ids[vertices[1]->Id()], study.chi2_before[e], chi2[e]);
  }
  return table;
}

}  // namespace

std::vector<int> FixFreeParts(const Graph& graph) {
  std::vector<int> fixed;
  for (const auto& root : FindRoots(graph)) {
    if (root->IsFixed()) continue;
    root->SetFixed();
    fixed.push_back(root->Id());
  }
  return fixed;
}

std::string NameOf(PoseGraphStart start) { return kPoseGraphStartNames[static_cast<size_t>(start)].first; }

PoseGraphStudy StartPoseGraph(const PoseGraphOptions& options, G2oFile* file) {
  const auto begin = std::chrono::steady_clock::now();
  if (options.start == PoseGraphStart::kGiven && !file->has_poses) {
    throw std::invalid_argument("this file holds edges only, so no poses to start from");
  }
  PoseGraphStudy study;
  for (const int index : FixFreeParts(file->graph)) study.fixed_ids.push_back(file->ids[index]);
  if (options.huber > 0.0) {
    const auto loss = std::make_shared<HuberLoss>(options.huber);
    for (const auto& edge : file->graph.Edges()) edge->SetLossFunction(loss);
  }
  std::vector<PoseGraphStart> starts;
  for (const auto& [name, start] : kPoseGraphStartNames) {
    if (options.start ? start == *options.start : file->has_poses || start != PoseGraphStart::kGiven) {
      starts.push_back(start);
    }
  }
  const std::vector<double> costs = InitializeAtLeastCost(starts, &file->graph, options.threads);
  for (size_t k = 0; k < starts.size(); ++k) study.costs_of_starts.emplace_back(starts[k], costs[k]);
  study.start = starts[std::min_element(costs.begin(), costs.end()) - costs.begin()];
  study.seconds_to_start = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  for (const auto& vertex : file->graph.Vertices()) study.poses_before.push_back(vertex->Parameters());
  study.chi2_before = Chi2OfEdges(file->graph);
  return study;
}

PoseGraphStudy SolvePoseGraph(const PoseGraphOptions& options, G2oFile* file) {
  PoseGraphStudy study = StartPoseGraph(options, file);
  study.summary = SolveGraph(&file->graph, options);
  return study;
}

void WritePoseGraphStudy(const PoseGraphStudy& study, const G2oFile& file, const PoseGraphOptions& options) {
  const std::filesystem::path out = options.out;
  FileBatch files(options.input);
  files.Add(out / (options.Name() + "-result.g2o"), FormatG2o(file));
  files.Add(out / "poses.csv", PoseTable(study, file).Text());
  files.Add(out / "edges.csv", EdgeTable(study, file).Text());
  files.Add(out / "trace.csv", TraceTable(study.summary).Text());
  files.Add(out / "summary.csv", SummaryOf(study, file, options).Text());
  files.Commit();
}

}  // namespace ch5
