/// Is the window as certain as it has a right to be? ch5_nees [--out DIR] [--runs N] [--seconds S]

#include <cstdio>
#include <cstdlib>
#include <exception>
#include <string>

#include "ch5_backend/apps/studies/consistency_study.h"
#include "ch5_backend/apps/studies/progress.h"

namespace {

constexpr char kUsage[] =
    "usage: ch5_nees [--out DIR] [--runs N] [--seconds S]\n"
    "Runs a sliding window on N simulated recordings (50) of S seconds (20) for each mode of first estimates, and\n"
    "writes what plot/nees.py draws to DIR/csv (DIR is out/ unless given).\n";

int Fail(const std::string& what) {
  std::fprintf(stderr, "ch5_nees: %s\n", what.c_str());
  return 2;
}

}  // namespace

int main(int argc, char** argv) {
  ch5::ConsistencyOptions options;
  std::filesystem::path out = "out";
  for (int i = 1; i < argc; ++i) {
    const std::string name = argv[i];
    if (name == "--help" || name == "-h") return std::fputs(kUsage, stdout) < 0 ? 2 : 0;
    if (name != "--out" && name != "--runs" && name != "--seconds") return Fail("unknown argument '" + name + "'");
    if (++i == argc) return Fail(name + " needs a value");
    if (name == "--out") out = argv[i];
    if (name == "--out") continue;
    char* end = nullptr;
    const double value = std::strtod(argv[i], &end);
    if (*end != '\0' || !(value >= 1.0) || value > 1e4) return Fail(name + " needs a number from 1 on, got " + argv[i]);
    name == "--runs" ? void(options.runs = static_cast<int>(value)) : void(options.seconds = value);
  }
  const ch5::Progress progress;
  try {
    const auto rows = ch5::RunConsistencyStudy(options, [&](double f) { progress.Show("consistency", f); });
    ch5::WriteConsistencyTables(rows, out / "csv");
  } catch (const std::exception& error) {
    progress.Clear();
    return Fail(error.what());
  }
  return 0;
}
