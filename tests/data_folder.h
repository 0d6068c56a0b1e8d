#pragma once

#include <filesystem>

namespace ch5 {

/// The folder of the real recordings and problems: CH5_DATA_DIR of the environment, else the one that CMake was given. It may
/// not be there.
std::filesystem::path DataFolder();

/// Skips a test whose file or folder of DataFolder() is not there.
#define CH5_NEEDS(path) \
  if (!std::filesystem::exists(path)) GTEST_SKIP() << "without the real data, which CH5_DATA_DIR names"

}  // namespace ch5
