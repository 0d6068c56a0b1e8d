#include "ch5_backend/experiments/studies/pose_graph_study.h"

#include <algorithm>
#include <cmath>
#include <numeric>

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

CsvTable SummaryOf(const PoseGraphStudy& study, const G2oFile& file, const FileSolveOptions& options,
                   const std::string& name) {
  CsvTable table = SummaryTable(name, study.summary, options);
  table.Row("vertices", file.graph.Vertices().size());
  table.Row("edges", file.graph.Edges().size());
  table.Row("chi2_before", Sum(study.chi2_before));
  table.Row("chi2", Sum(Chi2OfEdges(file.graph)));
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
  // Union-find: the root of a part is its first pose.
  std::vector<int> root(graph.Vertices().size());
  std::iota(root.begin(), root.end(), 0);
  const auto find = [&](int i) {
    while (root[i] != i) i = root[i] = root[root[i]];
    return i;
  };
  std::vector<bool> has_edge(root.size(), false), is_fixed(root.size(), false);
  for (const auto& edge : graph.Edges()) {
    const int i = edge->Vertices()[0]->Id(), j = edge->Vertices()[1]->Id();
    has_edge[i] = has_edge[j] = true;
    const int root_i = find(i), root_j = find(j);
    root[std::max(root_i, root_j)] = std::min(root_i, root_j);
  }
  for (const auto& vertex : graph.Vertices()) {
    if (vertex->IsFixed()) is_fixed[find(vertex->Id())] = true;
  }
  std::vector<int> fixed;
  for (const auto& vertex : graph.Vertices()) {
    const int i = vertex->Id();
    if (find(i) != i || !has_edge[i] || is_fixed[i]) continue;
    vertex->SetFixed();
    fixed.push_back(i);
  }
  return fixed;
}

PoseGraphStudy SolvePoseGraph(const FileSolveOptions& options, G2oFile* file, const IterationCallback& listener) {
  PoseGraphStudy study;
  for (const int index : FixFreeParts(file->graph)) study.fixed_ids.push_back(file->ids[index]);
  for (const auto& vertex : file->graph.Vertices()) study.poses_before.push_back(vertex->Parameters());
  study.chi2_before = Chi2OfEdges(file->graph);
  if (options.huber > 0.0) {
    const auto loss = std::make_shared<HuberLoss>(options.huber);
    for (const auto& edge : file->graph.Edges()) edge->SetLossFunction(loss);
  }
  study.summary = SolveGraph(&file->graph, options, listener);
  return study;
}

void WritePoseGraphStudy(const PoseGraphStudy& study, const G2oFile& file, const FileSolveOptions& options,
                         const std::string& name, const std::filesystem::path& out) {
  FileBatch files(options.input);
  files.Add(out / (name + "-result.g2o"), FormatG2o(file));
  files.Add(out / "poses.csv", PoseTable(study, file).Text());
  files.Add(out / "edges.csv", EdgeTable(study, file).Text());
  files.Add(out / "trace.csv", TraceTable(study.summary).Text());
  files.Add(out / "summary.csv", SummaryOf(study, file, options, name).Text());
  files.Commit();
}

}  // namespace ch5
