#pragma once
/// Experiments of many trials, one trial a call: PROGRAM STUDY --trial K writes the rows of trial K, so that trials run
/// beside each other and what many of them say is drawn from one table.

#include <filesystem>
#include <string>
#include <vector>

#include "ch5_backend/files/tables/csv.h"

namespace ch5 {

struct TrialStudy {
  std::string name;
  /// @param trial  0, 1, …: another scene, flight, or draw of the noise
  /// @param data   the folder of recordings and pose graphs, for those that read one
  CsvTable (*run)(int trial, const std::filesystem::path& data);
};

/// main() of a program with these studies.
/// @param about  what it does, in lines for --help
/// @return the exit code
int RunTrialStudies(const std::string& program, const std::string& about, const std::vector<TrialStudy>& studies,
                    int argc, char** argv);

}  // namespace ch5
