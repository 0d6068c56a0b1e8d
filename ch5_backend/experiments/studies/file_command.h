#pragma once
/// What the programs that solve one file have in common: their command line, their errors, how they report the run.

#include <functional>
#include <string>

#include "ch5_backend/experiments/studies/command_line.h"
#include "ch5_backend/experiments/studies/file_solve.h"

namespace ch5 {

struct FileCommand {
  std::string file, out;
  FileSolveOptions options;  ///< as many threads as the machine has, unless given

  std::string Name() const;  ///< the file's, without folders and extension
};

/// The whole of main(), see CommandLine: FILE --out DIR, and those of --iterations N, --threads N, --huber X
/// and --solver NAME that `usage` names.
/// @param declare  the program's own options, and its defaults
int RunFileCommand(const char* program, const char* usage, int argc, char** argv,
                   const std::function<void(const FileCommand&)>& run,
                   const std::function<void(CommandLine*, FileSolveOptions*)>& declare = {});

/// Prints the table of iterations while it grows.
class IterationTable {
 public:
  IterationTable();
  void Print(const IterationInfo& info);

 private:
  double previous_cost_ = 0.0;
};

/// The lines below that table: how it ended, and whether more iterations would help.
/// @param more  what the format adds, such as ", mean error 2.1 px"
void PrintSummary(const Summary& summary, const std::string& more = "");

}  // namespace ch5
