#pragma once
/// What the programs that solve one file have in common: their command line, their errors, their table of iterations.

#include <functional>
#include <string>

#include "ch5_backend/solve/minimizer.h"
#include "ch5_backend/solve/reduced_solver.h"

namespace ch5 {

struct FileCommand {
  std::string file, out;
  int iterations = 50;  ///< at most
  int threads = 0;      ///< as many as the machine has, unless given
  double huber = 0.0;   ///< threshold of Huber's loss; 0 for plain least squares
  ReducedSolverType solver = ReducedSolverType::kAutomatic;
};

/// The whole of main(): reads FILE --out DIR [--iterations N] [--threads N] [--huber X] [--solver NAME], calls `run`, and turns every
/// error into one line on standard error, "program: what is wrong".
/// @param usage  printed for --help
/// @return exit code: 0, or 2 after an error
int RunFileCommand(const char* program, const char* usage, int argc, char** argv,
                   const std::function<void(const FileCommand&)>& run);

/// Prints the table of iterations while it grows.
class IterationTable {
 public:
  IterationTable();
  void Print(const IterationInfo& info);

 private:
  double previous_cost_ = 0.0;
};

}  // namespace ch5
