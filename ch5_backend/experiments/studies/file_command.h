#pragma once
/// What the programs that solve one file have in common: their command line, the run of the sparse solver, its report on
/// the terminal, and the tables that every format has.

#include <functional>
#include <string>

#include "ch5_backend/experiments/studies/command_line.h"
#include "ch5_backend/files/tables/csv.h"
#include "ch5_backend/graph/graph.h"
#include "ch5_backend/linear/reduced_solver.h"
#include "ch5_backend/solve/minimizer.h"

namespace ch5 {

struct FileSolveOptions {
  FileSolveOptions() { solve.max_iterations = 50; }
  std::string input, out;  ///< the file that is solved, which no result may overwrite; the folder of the results
  int threads = 1;
  double huber = 0.0;  ///< threshold of Huber's loss on √(rᵀWr), which is [px] in BAL; 0 for plain least squares
  ReducedSolverType solver = ReducedSolverType::kAutomatic;
  SolveOptions solve;

  std::string Name() const;  ///< the input's, without folders and extension
};

/// The whole of main(), see CommandLine: FILE --out DIR, and those of --iterations N, --threads N, --huber X and
/// --solver NAME that `usage` names. Prints the table of iterations while it grows.
/// @param options  the program's defaults, then as set; as many threads as the machine has, unless given
/// @param declare  the program's own options
int RunFileCommand(const char* program, const char* usage, int argc, char** argv, FileSolveOptions* options,
                   const std::function<void()>& run, const std::function<void(CommandLine*)>& declare = {});

/// The lines below the table of iterations: how it ended, and whether more would help.
/// @param more  what the format adds, such as ", mean error 2.1 px"
void PrintSummary(const Summary& summary, const std::string& more = "");

/// Solves by the sparse solver with diagonal damping: in no format do all unknowns have the same unit.
/// @throws std::invalid_argument if a residual or a Jacobian is not finite; names its edge
Summary SolveGraph(Graph* graph, const FileSolveOptions& options);

/// Residuals are outliers if they are so many times the median, hold so much of the cost and are no more than so few: intel,
/// CSAIL and parking-garage, whose edges of odometry fit exactly, stay below.
struct OutlierLimits {
  double far = 10.0, cost = 0.5, few = 0.1;
};

/// One sentence on --huber, for a plain least-squares solution of which few residuals hold most of the cost; else empty.
std::string HintAtHuber(const Graph& graph, const FileSolveOptions& options, const OutlierLimits& limits = {});

/// key,value: the rows of every summary, to which a format adds its own.
CsvTable SummaryTable(const Summary& summary, const FileSolveOptions& options);

/// A row for each line of the convergence table, the start included.
CsvTable TraceTable(const Summary& summary);

}  // namespace ch5
