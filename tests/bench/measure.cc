/// One side of ./course bench: measure PROBLEM [--way WORDS] [--threads N] [--wall] [--repeat N], see measure.h.

#include "tests/bench/measure.h"

#include <sys/resource.h>
#include <unistd.h>

#include <cstdio>
#include <cstdlib>

#include "ch5_backend/experiments/studies/command_line.h"
#include "tests/bench/process.h"

namespace ch5::bench {
namespace {

constexpr char kUsage[] =
    "usage: measure PROBLEM [--way WORDS] [--threads N] [--wall] [--repeat N]\n"
    "Solves PROBLEM (a BAL file, a window, a .g2o file, scene:FRAMESxPOINTS, city:CAMERAS[:SEED], or\n"
    "first:CAMERAS:BALFILE) N times, and prints a line of JSON for each run. Times are those of the\n"
    "processor, with --wall the clock's. WORDS, with commas between them, change what each side does by itself: lm or\n"
    "dogleg, radius=NUMBER (the first one; 1/lambda of lm), xyz or ray, inner or whole (steps of each "
    "landmark\n"
    "alone); and for Ceres alone: dense, sparse or iterative, unscaled, eigen, mixed. Before these may stand "
    "threads=N. Of a\n"
    "marginalization: ldlt.\n";

// VmHWM, which begins anew with each program, where getrusage remembers the parent's size; that one elsewhere.
double PeakBytes() {
  const double bytes = MemoryBytes("VmHWM:");
  if (bytes > 0.0) return bytes;
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return 1024.0 * static_cast<double>(usage.ru_maxrss);
}

void Print(const peer::PeerResult& result, size_t observations) {
  const double peak = PeakBytes(), added = peak - result.bytes_before;
  std::printf(
      "{\"initial_cost\": %.17g, \"final_cost\": %.17g, \"seconds\": %.9g, \"trials\": %d, \"peak_mb\": %.3f, "
      "\"observations\": %zu, \"solver_bytes\": %.0f, \"blas\": \"%s\", \"trace\": [",
      result.initial_cost, result.final_cost, result.seconds, result.trials, peak / 1048576.0, observations,
      result.bytes_before > 0.0 ? added : 0.0, BlasFile().c_str());
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
  std::string name, way;
  int threads = 1, repeat = 1;
  bool wall = false;
  ch5::CommandLine line("measure", ch5::bench::kUsage);
  line.Argument("PROBLEM", &name);
  line.Option("--way", [&](const std::string& words) { way = words; });
  line.Number("--threads", 1, 256, &threads);
  line.Flag("--wall", [&] { wall = true; });
  line.Number("--repeat", 1, 1000, &repeat);
  return line.Run(argc, argv, [&] {
    ch5::bench::Problem problem = ch5::bench::ReadProblem(name);
    problem.options.threads = threads;
    problem.options.wall = wall;
    problem.plain_ldlt = way == "ldlt";
    if (!problem.plain_ldlt) ch5::bench::TakeWay(way, &problem.options);
    for (int k = 0; k < repeat; ++k) ch5::bench::Print(ch5::bench::Solve(problem), problem.bal.observations.size());
  });
}
