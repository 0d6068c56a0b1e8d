/// One side of ./course bench: measure PROBLEM [--threads N] [--repeat N], see measure.h.

#include "tests/bench/measure.h"

#include <sys/resource.h>
#include <unistd.h>

#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <stdexcept>

#include "ch5_backend/apps/studies/command_line.h"
#include "ch5_backend/world/simulate/mono_ba.h"

namespace ch5::bench {
namespace {

constexpr char kUsage[] =
    "usage: measure PROBLEM [--threads N] [--repeat N] [--precision double|single]\n"
    "Solves PROBLEM (a BAL file, a window, a .g2o file, or scene:FRAMESxPOINTS) N times, and prints a line of JSON "
    "for\n"
    "each run.\n";

// The course's scene as a window: camera frames, hosted by the first, the first two held.
WindowDump SceneWindow(const std::string& size) {
  MonoBaOptions options;
  char rest;
  const int read = std::sscanf(size.c_str(), "%dx%d%c", &options.frames, &options.points, &rest);
  if (read != 2) throw std::invalid_argument("a scene is FRAMESxPOINTS, got '" + size + "'");
  const MonoBaScene scene = SimulateMonoBa(options);
  WindowDump window;
  window.T_B_C = {Qd::Identity(), Vec3::Zero()};
  for (const Transform& frame : scene.initial_frames) {
    window.frames.emplace_back();
    window.frames.back().T_W_B = frame;
  }
  for (size_t k = 0; k < scene.points.size(); ++k) {
    WindowDump::Landmark landmark;
    landmark.id = static_cast<int>(k);
    landmark.inverse_depth = scene.initial_inverse_depths[k];
    landmark.x_host = scene.pixels[0][k];
    for (int i = 1; i < options.frames; ++i)
      landmark.observations.push_back({i, scene.pixels[static_cast<size_t>(i)][k]});
    window.landmarks.push_back(landmark);
  }
  window.fixed_frames = {0, 1};
  return window;
}

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

Problem ReadProblem(const std::string& name) {
  Problem problem;
  std::string word;
  const bool is_scene = name.rfind("scene:", 0) == 0;
  if (!is_scene) std::ifstream(name) >> word;
  if (is_scene || word == "VIOWIN") {
    problem.kind = Problem::Kind::kWindow;
    problem.window = is_scene ? SceneWindow(name.substr(6)) : ReadWindowDump(name);
    const bool has_imu = !problem.window.imu.empty();
    problem.options.dogleg = has_imu;  // VINS-Mono's settings
    problem.options.iterations = has_imu ? 8 : 20;
    problem.options.tolerance = has_imu ? 0.0 : 1e-6;
  } else if (name.size() > 4 && name.substr(name.size() - 4) == ".g2o") {
    problem.kind = Problem::Kind::kPoseGraph;
    problem.pose_graph = name;
    problem.options.iterations = 50;
    problem.options.tolerance = 1e-6;
  } else {
    problem.bal = ReadBal(name);
    // Of Ceres' solvers each is the fastest on its side of this.
    if (problem.bal.cameras.size() > 400) problem.options.linear_solver = peer::LinearSolver::kIterativeSchur;
  }
  return problem;
}

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
  bool single_precision = false;
  line.Precision("--precision", &single_precision);
  return line.Run(argc, argv, [&] {
    ch5::bench::Problem problem = ch5::bench::ReadProblem(name);
    problem.options.threads = threads;
    problem.single_precision = single_precision;
    for (int k = 0; k < repeat; ++k) ch5::bench::Print(ch5::bench::Solve(problem));
  });
}
