/// One side of ./course bench: measure PROBLEM [--threads N] [--repeat N], see measure.h.

#include "tests/bench/measure.h"

#include <sys/resource.h>
#include <unistd.h>

#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <stdexcept>

#include "ch5_backend/experiments/studies/command_line.h"

namespace ch5::bench {
namespace {

constexpr char kUsage[] =
    "usage: measure PROBLEM [--threads N] [--repeat N]\n"
    "Solves PROBLEM (a BAL file, a window, a .g2o file, or scene:FRAMESxPOINTS) N times, and prints a line of JSON "
    "for\n"
    "each run.\n";

// VmHWM, which begins anew with each program, where getrusage remembers the parent's size; that one elsewhere.
long PeakKilobytes() {
  std::ifstream status("/proc/self/status");
  for (std::string line; std::getline(status, line);) {
    if (line.rfind("VmHWM:", 0) == 0) return std::atol(line.c_str() + 6);
  }
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return usage.ru_maxrss;
}

void Print(const peer::PeerResult& result) {
  std::printf(
      "{\"initial_cost\": %.17g, \"final_cost\": %.17g, \"seconds\": %.9g, \"steps\": %d, \"peak_mb\": %.3f, "
      "\"trace\": [",
      result.initial_cost, result.final_cost, result.seconds, result.iterations,
      static_cast<double>(PeakKilobytes()) / 1024.0);
  const char* comma = "";
  for (const peer::PeerPoint& point : result.trace) {
    std::printf("%s[%.9g, %.17g]", comma, point.seconds, point.cost);
    comma = ", ";
  }
  std::printf("]}\n");
}

}  // namespace

}  // namespace ch5::bench

int main(int argc, char** argv) {
  // BLAS under Ceres is fastest with one thread on matrices this small, and reads this when it is loaded.
  if (!std::getenv("OPENBLAS_NUM_THREADS")) {
    setenv("OPENBLAS_NUM_THREADS", "1", 1);
    execv("/proc/self/exe", argv);
  }
  std::string name;
  int threads = 1, repeat = 1;
  ch5::CommandLine line("measure", ch5::bench::kUsage);
  line.Argument("PROBLEM", &name);
  line.Number("--threads", 1, 256, &threads);
  line.Number("--repeat", 1, 1000, &repeat);
  return line.Run(argc, argv, [&] {
    ch5::bench::Problem problem = ch5::bench::ReadProblem(name);
    problem.options.threads = threads;
    for (int k = 0; k < repeat; ++k) ch5::bench::Print(ch5::bench::Solve(problem));
  });
}
