#include "tests/data_folder.h"

#include <cstdlib>
#include <fstream>
#include <stdexcept>
#include <utility>

namespace ch5 {

// The only file that is compiled anew where the data lie elsewhere.
std::filesystem::path DataFolder() {
  const char* named = std::getenv("CH5_DATA_DIR");
  return named != nullptr && *named != '\0' ? named : CH5_DATA_DIR;
}

std::vector<std::vector<std::string>> Cases(const std::string& name) {
  std::vector<std::vector<std::string>> rows;
  std::ifstream file(std::filesystem::path(CH5_TESTS_DIR) / name);
  if (!file) throw std::runtime_error("tests/" + name + " cannot be read");
  for (std::string line; std::getline(file, line);) {
    if (line.empty() || line[0] == '#') continue;
    for (const auto& [written, meant] : {std::pair("\\n", "\n"), {"\\t", "\t"}}) {
      for (size_t at = 0; (at = line.find(written)) != std::string::npos;) line.replace(at, 2, meant);
    }
    rows.emplace_back(1);
    for (const char c : line) {
      if (c == '|') {
        rows.back().emplace_back();
      } else {
        rows.back().back() += c;
      }
    }
  }
  return rows;
}

bool IsSaid(const std::string& expected, const std::string& message) {
  if (expected.empty() || expected.back() != '*') return message == expected;
  return message.compare(0, expected.size() - 1, expected, 0, expected.size() - 1) == 0;
}

}  // namespace ch5
