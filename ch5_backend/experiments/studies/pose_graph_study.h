#pragma once
/// Solves a pose graph and writes its results.

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "ch5_backend/experiments/studies/file_command.h"
#include "ch5_backend/files/g2o_file.h"
#include "ch5_backend/initialize/graduated.h"
#include "ch5_backend/initialize/initialize_pose_graph.h"

namespace ch5 {

/// A loss on the edges that close loops.
enum class LoopLoss { kHuber, kCauchy, kGemanMcClure, kDcs, kTruncated };

/// The losses by name, in the order above.
inline constexpr std::pair<const char*, LoopLoss> kLoopLossNames[] = {
    {"huber", LoopLoss::kHuber}, {"cauchy", LoopLoss::kCauchy}, {"geman-mcclure", LoopLoss::kGemanMcClure},
    {"dcs", LoopLoss::kDcs},     {"tls", LoopLoss::kTruncated},
};

struct PoseGraphOptions : FileSolveOptions {
  PoseGraphOptions() {
    solve.max_iterations = 1000;
    solve.cost_tolerance = 1e-9;  // a long path's valley is flat: an iteration gains little, and many gain much
    solve.step_tolerance = 0.0;   // of ‖x‖: in a map's coordinates a step of 0.1 m is less
  }
  /// Unless set, the one of least cost; incremental if there are landmarks; odometry with gnc.
  std::optional<PoseGraphStart> start;
  std::optional<LoopLoss> loss;
  double scale = 0.0;   ///< of the loss, on √(rᵀWr); unless set, from the χ² distribution
  int incremental = 0;  ///< if not 0: solved while it grows, an update after so many poses (SolveIncrementally)
  bool gnc = false;  ///< graduated non-convexity, towards truncated least squares or, if `loss` is that, Geman–McClure
};

struct PoseGraphStudy {
  PoseGraphStart start;                                            ///< that was taken
  std::vector<std::pair<PoseGraphStart, double>> costs_of_starts;  ///< that were tried
  double seconds_to_start = 0.0;
  std::string growth;  ///< with PoseGraphOptions::incremental: what the updates took, a line
  Summary summary;
  std::vector<Vec7> poses_before;   ///< [p, q] of each vertex at the start
  std::vector<double> chi2_before;  ///< rᵀWr of each edge at the start
  std::vector<int64_t> fixed_ids;   ///< the poses that were fixed because the file fixed none of their component
  std::vector<int64_t> alone_ids;   ///< poses and landmarks without an edge, which stay where the file has them
  std::string doubts;               ///< of graph_doubts.h, a line each
  std::vector<LoopVerdict> loops;   ///< with gnc; empty otherwise
};

/// How many vertices of the file are no poses.
size_t CountLandmarks(const G2oFile& file);

/// The connected parts of the graph, by the least id in each: of each vertex, by its id. Edges of zero information connect nothing.
std::vector<int> PartsOf(const Graph& graph);

/// Fixes the first pose of every connected part that nothing holds, so that no gauge is left free: a part is held by a pose
/// that is fixed, by a prior, or by enough fixed landmarks, two in the plane and three in space.
/// @return indices of these poses; poses without edges stay free
std::vector<int> FixFreeParts(const Graph& graph);

/// Fixes the free parts of the graph, and moves its poses to the start that was asked for.
/// @throws std::invalid_argument if that is the file's poses, and the file has none
PoseGraphStudy StartPoseGraph(const PoseGraphOptions& options, G2oFile* file);

/// Gives up false loops if that was asked for, and solves the graph.
void SolveStartedPoseGraph(const PoseGraphOptions& options, Graph* graph, PoseGraphStudy* study);

/// What is to be said of the loops of a solved graph: what was given up, what could not be decided, or, without a loss,
/// that some disagree with the rest, which poses the farthest of them connect, and that --gnc finds them.
std::string ReportOnLoops(const PoseGraphOptions& options, const PoseGraphStudy& study, const G2oFile& file);

/// Both; `file` then holds the result.
PoseGraphStudy SolvePoseGraph(const PoseGraphOptions& options, G2oFile* file);

/// Whether --gnc would give up some loops of the file, and no more than half: large false ones bend all the others, so plain
/// least squares does not tell.
bool AreSomeLoopsFalse(PoseGraphOptions options, const G2oOptions& reading);

/// "file", "chordal", …
std::string NameOf(PoseGraphStart start);

/// Writes, all or none, into options.out: NAME-result.g2o, summary.csv (key, value), trace.csv, for the picture
/// poses.csv and edges.csv, and with gnc given_up.csv: the false loops.
/// @throws WriteError
void WritePoseGraphStudy(const PoseGraphStudy& study, const G2oFile& file, const PoseGraphOptions& options);

}  // namespace ch5
