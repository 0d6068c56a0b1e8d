#pragma once
/// Solves a pose graph and writes its results.

#include <filesystem>
#include <string>

#include "ch5_backend/experiments/studies/file_solve.h"
#include "ch5_backend/files/g2o_file.h"

namespace ch5 {

struct PoseGraphStudy {
  Summary summary;
  std::vector<VecX> poses_before;   ///< the parameters of each vertex at the start
  std::vector<double> chi2_before;  ///< rᵀWr of each edge at the start
  std::vector<int> fixed_ids;       ///< the poses that were fixed because the file fixed none of their component
};

/// Fixes the first pose of every connected component without a fixed one, so that no gauge is left free.
/// @return indices of these poses; poses without edges stay free
std::vector<int> FixFreeParts(const Graph& graph);

/// Levenberg-Marquardt, as SolveGraph; `file` then holds the result.
PoseGraphStudy SolvePoseGraph(const FileSolveOptions& options, G2oFile* file, const IterationCallback& listener = {});

/// Writes, all or none, into `out`: NAME-result.g2o, summary.csv (key, value), trace.csv, and for the picture
/// poses.csv and edges.csv.
/// @throws WriteError
void WritePoseGraphStudy(const PoseGraphStudy& study, const G2oFile& file, const FileSolveOptions& options,
                         const std::string& name, const std::filesystem::path& out);

}  // namespace ch5
