#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace ch5 {

/// The folder of the real recordings and problems: CH5_DATA_DIR of the environment, else the one that CMake was given. It may
/// not be there.
std::filesystem::path DataFolder();

/// The rows of a table of cases, tests/NAME: cells between bars, in which \n is the end of a line and \t a tab. Lines that begin with
/// # are comments.
std::vector<std::vector<std::string>> Cases(const std::string& name);

/// Whether a message is the one of a case; * at its end stands for whatever follows.
bool IsSaid(const std::string& expected, const std::string& message);

/// Skips a test whose file or folder of DataFolder() is not there.
#define CH5_NEEDS(path) \
  if (!std::filesystem::exists(path)) GTEST_SKIP() << "without the real data, which CH5_DATA_DIR names"

}  // namespace ch5
