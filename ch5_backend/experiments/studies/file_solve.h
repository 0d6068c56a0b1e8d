#pragma once
/// Solving one file of any format: the user's options, the run of the sparse solver, the tables of results.

#include <functional>
#include <string>

#include "ch5_backend/files/tables/csv.h"
#include "ch5_backend/graph/graph.h"
#include "ch5_backend/linear/reduced_solver.h"
#include "ch5_backend/solve/minimizer.h"

namespace ch5 {

struct FileSolveOptions {
  std::string input;    ///< the file that is solved; no result may overwrite it
  int iterations = 50;  ///< at most
  int threads = 1;
  int landmark_steps = 0;  ///< SolveOptions::landmark_steps
  double huber = 0.0;  ///< threshold of Huber's loss on √(rᵀWr), which is [px] in BAL; 0 for plain least squares
  ReducedSolverType solver = ReducedSolverType::kAutomatic;
};

/// Called after each iteration.
using IterationCallback = std::function<void(const IterationInfo&)>;

/// The first edge whose residual is not finite at the present states, as of a point in a camera's plane; or none, as −1.
int FirstInfiniteResidual(const Graph& graph);

/// Solves by the sparse solver with diagonal damping: in no format do all unknowns have the same unit.
/// @param solve  the format's own settings; the iterations follow `options`
/// @throws std::invalid_argument if a residual is not finite at the start; names it
Summary SolveGraph(Graph* graph, const FileSolveOptions& options, const IterationCallback& listener,
                   SolveOptions solve = {});

/// key,value: the rows of every summary, to which a format adds its own.
CsvTable SummaryTable(const std::string& name, const Summary& summary, const FileSolveOptions& options);

/// A row for each line of the convergence table, the start included.
CsvTable TraceTable(const Summary& summary);

}  // namespace ch5
