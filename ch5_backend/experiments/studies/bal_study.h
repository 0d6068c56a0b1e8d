#pragma once
/// Solves a "Bundle Adjustment in the Large" problem and writes its results.

#include "ch5_backend/experiments/studies/file_command.h"
#include "ch5_backend/files/bal.h"

namespace ch5 {

struct BalStudy {
  Summary summary;
  BalProblem before, after;
  double mean_error_before = 0.0;  ///< mean ‖r‖ over the observations [px]
  double mean_error_after = 0.0;
  int behind_before = 0;  ///< observations whose point begins behind its camera
  int behind_camera = 0;  ///< and has ended there
  std::string hint;       ///< HintAtHuber, unless the solver failed: what is far off then need not be an outlier
  std::vector<LeftOut> left_out;  ///< by ReadBal
};

/// Levenberg-Marquardt, as SolveGraph.
/// @throws std::invalid_argument if an observation's residual is not finite at the start; names it
BalStudy SolveBal(const BalProblem& problem, const FileSolveOptions& options, BalPoints move = BalPoints::kOnRay);

/// Writes, all or none, into options.out: NAME-result.txt (BAL), NAME-before.ply, NAME-after.ply, summary.csv (key, value),
/// trace.csv, and for the picture points.csv and cameras.csv.
/// @throws WriteError
void WriteBalStudy(const BalStudy& study, const FileSolveOptions& options);

}  // namespace ch5
