#pragma once
/// Solves a "Bundle Adjustment in the Large" problem and writes down how it went.

#include <filesystem>
#include <functional>
#include <string>

#include "ch5_backend/solve/minimizer.h"
#include "ch5_backend/solve/reduced_solver.h"
#include "ch5_backend/world/bal.h"

namespace ch5 {

struct BalStudyOptions {
  int iterations = 50;  ///< at most
  int threads = 1;
  double huber = 0.0;  ///< threshold of Huber's loss [px]; 0 for plain least squares
  ReducedSolverType solver = ReducedSolverType::kAutomatic;
};

struct BalStudy {
  Summary summary;
  BalProblem before, after;
  double mean_error_before = 0.0;  ///< mean ‖r‖ over the observations [px]
  double mean_error_after = 0.0;
};

/// Levenberg-Marquardt with diagonal damping in the fast room.
/// @param callback  hears of each iteration
/// @throws std::invalid_argument if an observation's residual is not finite at the start; names it
BalStudy SolveBal(const BalProblem& problem, const BalStudyOptions& options,
                  const std::function<void(const IterationInfo&)>& callback = {});

/// Writes, all or none, into `out`: NAME-result.txt (BAL), NAME-before.ply, NAME-after.ply, summary.csv (key, value),
/// trace.csv, and for the picture points.csv and cameras.csv.
/// @throws WriteError
void WriteBalStudy(const BalStudy& study, const BalStudyOptions& options, const std::string& name,
                   const std::filesystem::path& out);

}  // namespace ch5
