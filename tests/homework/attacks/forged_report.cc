/// An attack on the report that the judge writes.

#include <unistd.h>

#include <fstream>
#include <iterator>
#include <string>

#include "tests/homework/attacks/attack.h"

namespace attacks {
namespace {

// The word of the judge's command line that begins so, without that beginning.
std::string OptionOfJudge(const std::string& option) {
  std::ifstream file("/proc/" + std::to_string(getppid()) + "/cmdline");
  const std::string words{std::istreambuf_iterator<char>(file), {}};
  const size_t at = words.find(option);
  return at == std::string::npos ? "" : words.substr(at + option.size()).c_str();
}

// "All passed", into the file in which the judge will write its report, now and again until somebody stops it.
void ForgeReport() {
  const std::string path = OptionOfJudge("--gtest_output=json:");
  for (int again = 0; again < 3; ++again) {
    if (!path.empty()) {
      std::ofstream(path) << R"({"tests": 1, "failures": 0, "testsuites": [{"name": "Stage11", "testsuite": [)"
                          << R"({"name": "All", "status": "RUN", "result": "COMPLETED"}]}]})";
    }
    if (fork() > 0) return;
    setsid();
    sleep(1);
  }
}

const When kFunction = When::kInFunction;
[[maybe_unused]] const bool added = Add("forge_report", kFunction, &ForgeReport);

}  // namespace
}  // namespace attacks
