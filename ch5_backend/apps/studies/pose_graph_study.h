#pragma once
/// Solves a pose graph and writes down how it went.

#include <filesystem>
#include <string>

#include "ch5_backend/apps/studies/file_solve.h"
#include "ch5_backend/world/files/g2o_file.h"

namespace ch5 {

struct PoseGraphStudy {
  Summary summary;
  std::vector<VecX> poses_before;   ///< the parameters of each vertex at the start
  std::vector<double> chi2_before;  ///< rᵀWr of each edge at the start
  std::vector<int> fixed_ids;       ///< the poses that were fixed because the file left their part of the graph free
};

/// Fixes the first pose of every connected part that has no fixed one, so that each part has a place.
/// @return indices of these poses; a pose without edges is no part
std::vector<int> FixFreeParts(const Graph& graph);

/// Levenberg-Marquardt, as SolveGraph; `file` then holds the result.
PoseGraphStudy SolvePoseGraph(const FileSolveOptions& options, G2oFile* file, const Listener& listener = {});

/// Writes, all or none, into `out`: NAME-result.g2o, summary.csv (key, value), trace.csv, and for the picture
/// poses.csv and edges.csv.
/// @throws WriteError
void WritePoseGraphStudy(const PoseGraphStudy& study, const G2oFile& file, const FileSolveOptions& options,
                         const std::string& name, const std::filesystem::path& out);

}  // namespace ch5
