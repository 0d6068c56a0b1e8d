#pragma once
/// A folder that goes with its test, and what is said of a file in it.

#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>

namespace ch5::test {

/// No other process has it; empty at first.
class TemporaryFolder {
 public:
  TemporaryFolder() { std::filesystem::create_directories(path_); }
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;
  ~TemporaryFolder() { std::filesystem::remove_all(path_); }

  const std::filesystem::path& Path() const { return path_; }
  std::filesystem::path operator/(const std::string& name) const { return path_ / name; }

 private:
  inline static int made_ = 0;
  std::filesystem::path path_ =
      std::filesystem::temp_directory_path() / ("ch5_test_" + std::to_string(getpid()) + "_" + std::to_string(made_++));
};

inline std::string ReadText(const std::filesystem::path& path) {
  std::ostringstream text;
  text << std::ifstream(path, std::ios::binary).rdbuf();
  return text.str();
}

/// What `action` is refused with, or "" if it is not.
template <typename Error, typename Action>
std::string Refusal(const Action& action) {
  try {
    action();
  } catch (const Error& error) {
    return error.what();
  }
  return "";
}

}  // namespace ch5::test
