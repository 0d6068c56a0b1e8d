/// Ten thousand images through each estimator: ch5_endurance [--out DIR] [--frames N]

#include <cstdio>
#include <cstdlib>
#include <exception>
#include <string>

#include "ch5_backend/apps/studies/endurance_study.h"
#include "ch5_backend/apps/studies/progress.h"

namespace {

constexpr char kUsage[] =
    "usage: ch5_endurance [--out DIR] [--frames N]\n"
    "Feeds N simulated images (10000) to both window policies, and writes their memory and drift to DIR/csv, which\n"
    "plot/endurance.py draws (DIR is out/ unless given).\n";

int Fail(const std::string& what) {
  std::fprintf(stderr, "ch5_endurance: %s\n", what.c_str());
  return 2;
}

}  // namespace

int main(int argc, char** argv) {
  ch5::EnduranceOptions options;
  std::filesystem::path out = "out";
  for (int i = 1; i < argc; ++i) {
    const std::string name = argv[i];
    if (name == "--help" || name == "-h") return std::fputs(kUsage, stdout) < 0 ? 2 : 0;
    if (name != "--out" && name != "--frames") return Fail("unknown argument '" + name + "'");
    if (++i == argc) return Fail(name + " needs a value");
    if (name == "--out") {
      out = argv[i];
      continue;
    }
    char* end = nullptr;
    const long frames = std::strtol(argv[i], &end, 10);
    if (*end != '\0' || frames < 100 || frames > 1000000) {
      return Fail("--frames needs a whole number from 100 to 1000000, got " + std::string(argv[i]));
    }
    options.frames = static_cast<int>(frames);
  }
  const ch5::Progress progress;
  try {
    const auto rows = ch5::RunEnduranceStudy(
        options, [&](const std::string& policy, double fraction) { progress.Show(policy, fraction); });
    ch5::WriteEnduranceTables(rows, out / "csv");
  } catch (const std::exception& error) {
    progress.Clear();
    return Fail(error.what());
  }
  return 0;
}
