#include <chrono>
#include <fstream>
#include <stdexcept>

#include "ch5_backend/simulate/city.h"
#include "ch5_backend/simulate/mono_ba.h"
#include "ch5_backend/window/policy.h"
#include "tests/bench/measure.h"

namespace ch5::bench {
namespace {

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

BalProblem CityProblem(const std::string& cameras) {
  CityOptions options;
  char rest;
  if (std::sscanf(cameras.c_str(), "%d%c", &options.cameras, &rest) != 1)
    throw std::invalid_argument("a city has a number of cameras, got '" + cameras + "'");
  return SimulateCity(options).start;
}

}  // namespace

Problem ReadProblem(const std::string& name) {
  for (const auto& [word, task] :
       {std::pair("marginalize:", Problem::Task::kMarginalize), {"covariance:", Problem::Task::kCovariance}}) {
    if (name.rfind(word, 0) != 0) continue;
    Problem problem = ReadProblem(name.substr(std::string(word).size()));
    problem.task = task;
    const bool fits = problem.kind == Problem::Kind::kWindow ||
                      (problem.kind == Problem::Kind::kPoseGraph && task == Problem::Task::kCovariance);
    if (!fits) throw std::invalid_argument(std::string(word) + " is not for this kind of file");
    return problem;
  }
  Problem problem;
  std::string word;
  const bool is_scene = name.rfind("scene:", 0) == 0, is_city = name.rfind("city:", 0) == 0;
  if (!is_scene && !is_city) std::ifstream(name) >> word;
  if (is_scene || word == "VIOWIN") {
    problem.kind = Problem::Kind::kWindow;
    problem.window = is_scene ? SceneWindow(name.substr(6)) : ReadWindowDump(name);
    const bool has_imu = !problem.window.imu.empty();
    problem.options.dogleg = has_imu;  // VINS-Mono's settings
    problem.options.iterations = has_imu ? 8 : 20;
    problem.landmark_steps = has_imu ? VinsOptions().landmark_steps : 0;
  } else if (name.size() > 4 && name.substr(name.size() - 4) == ".g2o") {
    problem.kind = Problem::Kind::kPoseGraph;
    problem.pose_graph = name;
    problem.options.dogleg = true;  // few and long steps; Ceres is tried with both algorithms
    problem.options.iterations = 50;
  } else {
    problem.bal = is_city ? CityProblem(name.substr(5)) : ReadBal(name);
    if (problem.bal.cameras.size() > 5000) problem.options.iterations = 8;  // of some seconds each
    // Of Ceres' solvers each is the fastest on its problem; in a city, S is cheap to factor.
    if (problem.bal.cameras.size() > 400) {
      problem.options.linear_solver = is_city ? peer::LinearSolver::kSparseSchur : peer::LinearSolver::kIterativeSchur;
    }
  }
  return problem;
}

peer::PeerResult Timed(const std::function<double()>& work) {
  const auto start = std::chrono::steady_clock::now();
  const double agreed = work();
  const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return {agreed, agreed, seconds, 1, {{seconds, agreed}}};
}

}  // namespace ch5::bench
