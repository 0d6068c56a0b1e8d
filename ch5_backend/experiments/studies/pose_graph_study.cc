#include "ch5_backend/experiments/studies/pose_graph_study.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <iomanip>
#include <numeric>
#include <sstream>
#include <stdexcept>

#include "ch5_backend/initialize/incremental.h"
#include "ch5_backend/types/pose_graph/as_transform.h"

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

size_t CountFalse(const std::vector<LoopVerdict>& loops) {
  return std::count_if(loops.begin(), loops.end(), [](const LoopVerdict& loop) { return loop.IsFalse(); });
}

size_t CountClose(const std::vector<LoopVerdict>& loops) {
  return std::count_if(loops.begin(), loops.end(), [](const LoopVerdict& loop) { return loop.IsClose(); });
}

// " 3-412 with rᵀWr of 95, …": the poses that the loops farthest off connect.
std::string Farthest(std::vector<LoopVerdict> loops, const G2oFile& file) {
  const auto count = static_cast<std::ptrdiff_t>(std::min<size_t>(3, CountFalse(loops)));
  std::partial_sort(loops.begin(), loops.begin() + count, loops.end(),
                    [](const auto& a, const auto& b) { return a.chi2 > b.chi2; });
  std::ostringstream text;
  for (std::ptrdiff_t k = 0; k < count; ++k) {
    const auto& ends = loops[k].edge->Vertices();
    text << (k ? ", " : " ") << file.ids[ends[0]->Id()] << "-" << file.ids[ends[1]->Id()] << " with rᵀWr of "
         << loops[k].chi2;
  }
  return text.str();
}

std::shared_ptr<const LossFunction> MakeLoss(LoopLoss loss, double scale) {
  switch (loss) {
    case LoopLoss::kHuber: return std::make_shared<HuberLoss>(scale);
    case LoopLoss::kCauchy: return std::make_shared<CauchyLoss>(scale);
    case LoopLoss::kGemanMcClure: return std::make_shared<GemanMcClureLoss>(scale * scale);
    case LoopLoss::kDcs: return std::make_shared<DcsLoss>(scale * scale);
    case LoopLoss::kTruncated: return std::make_shared<SaturatedLoss>(scale);
  }
  throw std::logic_error("no such loss");
}

std::vector<int64_t> IdsWithoutEdges(const G2oFile& file) {
  std::vector<bool> has_edge(file.graph.Vertices().back()->Id() + 1, false);
  for (const auto& edge : file.graph.Edges())
    for (const auto& vertex : edge->Vertices()) has_edge[vertex->Id()] = true;
  std::vector<int64_t> ids;
  for (size_t i = 0; i < file.ids.size(); ++i)
    if (!has_edge[file.graph.Vertices()[i]->Id()]) ids.push_back(file.ids[i]);
  return ids;
}

CsvTable SummaryOf(const PoseGraphStudy& study, const G2oFile& file, const PoseGraphOptions& options) {
  CsvTable table = SummaryTable(study.summary, options);
  table.Row("vertices", file.ids.size());
  table.Row("landmarks", CountLandmarks(file));
  table.Row("edges", file.graph.Edges().size());
  table.Row("chi2_before", Sum(study.chi2_before));
  table.Row("chi2", Sum(Chi2OfEdges(file.graph)));
  table.Row("start", NameOf(study.start));
  table.Row("seconds_to_start", study.seconds_to_start);
  table.Row("projected_information", file.projected);
  table.Row("unknown_lines", file.unknown.size());
  table.Row("repeated_vertices", file.repeated_vertices);
  table.Row("repeated_edges", file.repeated);
  table.Row("without_edges", study.alone_ids.size());
  table.Row("last_line_unended", file.unended.empty() ? 0 : 1);
  table.Row("huber", options.huber);
  table.Row("loops_judged", study.loops.size());
  table.Row("given_up", CountFalse(study.loops));
  table.Row("given_up_close", CountClose(study.loops));
  table.Row("doubts", std::count(study.doubts.begin(), study.doubts.end(), '\n'));
  return table;
}

// [x, y, z, qx, qy, qz, qw] of a pose, or of a landmark, which is not turned.
Vec7 PoseOrPoint(const Vertex& vertex) {
  Vec7 x = Vec7::Unit(6);
  if (const std::optional<Transform> pose = PoseOf(vertex)) {
    x << pose->p, pose->q.coeffs();
  } else {
    x.head(vertex.Dimension()) = vertex.Parameters();
  }
  return x;
}

std::vector<Vec7> PosesAndPoints(const Graph& graph) {
  std::vector<Vec7> all;
  for (const auto& vertex : graph.Vertices()) all.push_back(PoseOrPoint(*vertex));
  return all;
}

CsvTable PoseTable(const PoseGraphStudy& study, const G2oFile& file) {
  CsvTable table("state,kind,id,x,y,z,qx,qy,qz,qw");
  const std::vector<Vec7> after = PosesAndPoints(file.graph);
  for (const auto& [state, all] : {std::pair("before", &study.poses_before), {"after", &after}}) {
    for (size_t i = 0; i < file.ids.size(); ++i) {
      const Vec7& p = (*all)[i];
      const char* kind = PoseOf(*file.graph.Vertices()[i]) ? "pose" : "landmark";
      table.Row(state, kind, file.ids[i], p[0], p[1], p[2], p[3], p[4], p[5], p[6]);
    }
  }
  return table;
}

// A prior's world has no name: there, both ends bear the pose's.
CsvTable EdgeTable(const PoseGraphStudy& study, const G2oFile& file) {
  CsvTable table("i,j,chi2_before,chi2_after");
  const std::vector<double> chi2 = Chi2OfEdges(file.graph);
  for (size_t e = 0; e < chi2.size(); ++e) {
    const auto& vertices = file.graph.Edges()[e]->Vertices();
    const size_t i = vertices[0]->Id(), j = vertices[1]->Id();
    table.Row(file.ids[i < file.ids.size() ? i : j], file.ids[j], study.chi2_before[e], chi2[e]);
  }
  return table;
}

CsvTable GivenUpTable(const PoseGraphStudy& study, const G2oFile& file) {
  CsvTable table("i,j,chi2,limit,weight");
  for (const LoopVerdict& loop : study.loops) {
    const auto& ends = loop.edge->Vertices();
    if (loop.IsFalse()) table.Row(file.ids[ends[0]->Id()], file.ids[ends[1]->Id()], loop.chi2, loop.limit, loop.weight);
  }
  return table;
}

// Solves the graph while it grows.  @return what that took
std::string Grow(int every, Graph* graph) {
  using Clock = std::chrono::steady_clock;
  int updates = 0;
  double eliminated = 0.0, variables = 0.0, longest = 0.0;
  const auto begin = Clock::now();
  auto last = begin;
  const auto seconds = [](auto from, auto to) { return std::chrono::duration<double>(to - from).count(); };
  SolveIncrementally(graph, every, [&](const UpdateSummary& update) {
    const auto now = Clock::now();
    longest = std::max(longest, seconds(last, now));
    last = now;
    eliminated += update.eliminated;
    variables += update.variables;
    ++updates;
  });
  std::ostringstream text;
  text << std::fixed << std::setprecision(3) << "incremental: " << updates << " updates in " << seconds(begin, last)
       << " s, the longest " << 1e3 * longest << " ms; on average " << std::lround(eliminated / updates) << " of "
       << std::lround(variables / updates) << " variables eliminated again\n";
  return text.str();
}

}  // namespace

size_t CountLandmarks(const G2oFile& file) {
  const auto& vertices = file.graph.Vertices();
  return std::count_if(vertices.begin(), vertices.begin() + static_cast<long>(file.ids.size()),
                       [](const auto& vertex) { return !PoseOf(*vertex); });
}

std::vector<int> PartsOf(const Graph& graph) {
  // `part` leads from a vertex to one with a smaller id, until it is its own.
  std::vector<int> part(graph.Vertices().empty() ? 0 : graph.Vertices().back()->Id() + 1);
  std::iota(part.begin(), part.end(), 0);
  const auto part_of = [&](int id) {
    while (part[id] != id) id = part[id] = part[part[id]];
    return id;
  };
  for (const auto& edge : graph.Edges()) {
    if (edge->Information().isZero(0.0)) continue;
    for (const auto& vertex : edge->Vertices()) {
      const auto [least, other] = std::minmax({part_of(vertex->Id()), part_of(edge->Vertices()[0]->Id())});
      part[other] = least;
    }
  }
  for (size_t id = 0; id < part.size(); ++id) part[id] = part[part[id]];
  return part;
}

std::vector<int> FixFreeParts(const Graph& graph) {
  const std::vector<int> part = PartsOf(graph);
  std::vector<bool> has_edge(part.size(), false);
  for (const auto& edge : graph.Edges())
    for (const auto& vertex : edge->Vertices()) has_edge[vertex->Id()] = true;
  // A pose that is fixed, or a prior's world, holds its part; of landmarks it takes two in the plane, and three in space.
  constexpr int kHeld = 6;
  std::vector<int> held(part.size(), 0);
  for (const auto& vertex : graph.Vertices()) {
    if (!vertex->IsFixed()) continue;
    held[part[vertex->Id()]] += vertex->GetRole() == Role::kPose ? kHeld : kHeld / vertex->Dimension();
  }
  std::vector<int> fixed;
  for (const auto& vertex : graph.Vertices()) {
    int& of_part = held[part[vertex->Id()]];
    if (of_part >= kHeld || !has_edge[vertex->Id()] || !PoseOf(*vertex)) continue;
    vertex->SetFixed();
    fixed.push_back(vertex->Id());
    of_part = kHeld;
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
  study.alone_ids = IdsWithoutEdges(*file);
  if (options.huber > 0.0) {
    const auto loss = std::make_shared<HuberLoss>(options.huber);
    for (const auto& edge : file->graph.Edges()) edge->SetLossFunction(loss);
  }
  if (options.loss && !options.gnc) {
    for (const LoopVerdict& loop : FindLoops(file->graph, options.scale))
      loop.edge->SetLossFunction(MakeLoss(*options.loss, std::sqrt(loop.limit)));
  }
  std::vector<PoseGraphStart> starts;
  if (options.incremental > 0) study.growth = Grow(options.incremental, &file->graph);
  const auto asked = options.incremental > 0 ? PoseGraphStart::kGiven
                     : options.gnc           ? options.start.value_or(PoseGraphStart::kOdometry)
                                             : options.start;
  for (const auto& [name, start] : kPoseGraphStartNames) {
    const bool has_sense = start == PoseGraphStart::kGiven         ? file->has_poses
                           : start == PoseGraphStart::kIncremental ? CountLandmarks(*file) > 0
                                                                   : true;
    if (asked ? start == *asked : has_sense) starts.push_back(start);
  }
  const std::vector<double> costs = InitializeAtLeastCost(starts, &file->graph, options.threads);
  if (options.incremental > 0) starts = {PoseGraphStart::kIncremental};
  for (size_t k = 0; k < starts.size(); ++k) study.costs_of_starts.emplace_back(starts[k], costs[k]);
  study.start = starts[std::min_element(costs.begin(), costs.end()) - costs.begin()];
  study.seconds_to_start = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  study.poses_before = PosesAndPoints(file->graph);
  study.chi2_before = Chi2OfEdges(file->graph);
  return study;
}

PoseGraphStudy SolvePoseGraph(const PoseGraphOptions& options, G2oFile* file) {
  PoseGraphStudy study = StartPoseGraph(options, file);
  SolveStartedPoseGraph(options, &file->graph, &study);
  return study;
}

void SolveStartedPoseGraph(const PoseGraphOptions& options, Graph* graph, PoseGraphStudy* study) {
  if (options.gnc) {
    PoseGraphOptions inner = options;
    inner.solve.max_iterations = 10;  // a round: the next one goes on from there
    inner.solve.cost_tolerance = 1e-4;
    inner.solve.callback = nullptr;
    const bool geman_mcclure = options.loss == LoopLoss::kGemanMcClure;
    study->loops = GiveUpFalseLoops({geman_mcclure ? Surrogate::kGemanMcClure : Surrogate::kTruncated, options.scale},
                                    graph, [&] { SolveGraph(graph, inner); });
  }
  constexpr int kMostTurns = 10;  // a loop given up that fits the final poses counts again, and the other way round
  for (int turn = 0; turn < kMostTurns; ++turn) {
    study->summary = SolveGraph(graph, options);
    MeasureLoops(&study->loops);
    ReadmitLoops(graph, &study->loops);
    if (!SeparateFalseLoops(study->loops)) break;
  }
}

std::string ReportOnLoops(const PoseGraphOptions& options, const PoseGraphStudy& study, const G2oFile& file) {
  if ((options.loss && !options.gnc) || options.huber > 0.0) return "";
  std::vector<LoopVerdict> loops = options.gnc ? study.loops : FindLoops(file.graph);
  MeasureLoops(&loops);
  const size_t far = CountFalse(loops), close = CountClose(loops);
  std::ostringstream text;
  text << std::setprecision(6) << far << " of " << loops.size();
  if (options.gnc) {
    text << " loops given up (given_up.csv); cost over the edges kept " << study.summary.final_cost;
    if (close > 0) text << "\nnot clear: " << close << " of them are less than twice beyond the limit and may be good";
  } else if (far == 0) {
    return "";
  } else {
    text << " loops disagree with the rest by more than noise would, most of all" << Farthest(loops, file)
         << "; --gnc gives up those that are false";
  }
  if (2 * far > loops.size())
    text << "\nthese are most loops: either "
         << (options.gnc ? "the others are false" : "a few false ones bend the others")
         << ", or the file's information matrices claim too much";
  return text.str();
}

bool AreSomeLoopsFalse(PoseGraphOptions options, const G2oOptions& reading) {
  options.gnc = true;
  options.start = PoseGraphStart::kOdometry;
  options.loss.reset();
  options.huber = options.incremental = 0;
  options.solve.callback = nullptr;
  G2oFile again = ReadG2o(options.input, reading);
  const PoseGraphStudy study = SolvePoseGraph(options, &again);
  return CountFalse(study.loops) > 0 && 2 * CountFalse(study.loops) <= study.loops.size();
}

void WritePoseGraphStudy(const PoseGraphStudy& study, const G2oFile& file, const PoseGraphOptions& options) {
  const std::filesystem::path out = options.out;
  FileBatch files(options.input);
  files.Add(out / (options.Name() + "-result.g2o"), FormatG2o(file));
  files.Add(out / "poses.csv", PoseTable(study, file).Text());
  files.Add(out / "edges.csv", EdgeTable(study, file).Text());
  files.Add(out / "trace.csv", TraceTable(study.summary).Text());
  if (options.gnc) files.Add(out / "given_up.csv", GivenUpTable(study, file).Text());
  files.Add(out / "summary.csv", SummaryOf(study, file, options).Text());
  files.Commit();
}

}  // namespace ch5
