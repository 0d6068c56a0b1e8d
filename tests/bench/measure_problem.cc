#include <fstream>
#include <sstream>
#include <stdexcept>

#include "ch5_backend/experiments/studies/command_line.h"
#include "ch5_backend/simulate/city.h"
#include "ch5_backend/simulate/mono_ba.h"
#include "tests/bench/measure.h"
#include "tests/bench/process.h"

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

BalProblem CityProblem(const std::string& words) {
  CityOptions options;
  unsigned long seed = 1;
  char rest;
  const int read = std::sscanf(words.c_str(), "%d:%lu%c", &options.cameras, &seed, &rest);
  if (read != 2 && std::sscanf(words.c_str(), "%d%c", &options.cameras, &rest) != 1)
    throw std::invalid_argument("a city has a number of cameras, and perhaps a seed behind a colon, got '" + words +
                                "'");
  options.seed = seed;
  return SimulateCity(options).start;
}

// The first cameras of a problem, and the points that at least two of them see.
BalProblem FirstCameras(const std::string& words) {
  const size_t colon = words.find(':');
  if (colon == std::string::npos) throw std::invalid_argument("a part is CAMERAS:BALFILE, got '" + words + "'");
  const BalProblem all = ReadBal(words.substr(colon + 1));
  const int cameras = NumberIn(words.substr(0, colon), 2, static_cast<int>(all.cameras.size()));
  std::vector<int> views(all.points.size(), 0), index(all.points.size(), -1);
  for (const BalObservation& seen : all.observations) views[static_cast<size_t>(seen.point)] += seen.camera < cameras;
  BalProblem part;
  part.cameras.assign(all.cameras.begin(), all.cameras.begin() + cameras);
  for (size_t i = 0; i < all.points.size(); ++i) {
    if (views[i] < 2) continue;
    index[i] = static_cast<int>(part.points.size());
    part.points.push_back(all.points[i]);
  }
  for (BalObservation seen : all.observations) {
    seen.point = index[static_cast<size_t>(seen.point)];
    if (seen.camera < cameras && seen.point >= 0) part.observations.push_back(seen);
  }
  return part;
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
  const bool is_part = name.rfind("first:", 0) == 0;
  if (!is_scene && !is_city && !is_part) std::ifstream(name) >> word;
  if (is_scene || word == "VIOWIN") {
    problem.kind = Problem::Kind::kWindow;
    problem.window = is_scene ? SceneWindow(name.substr(6)) : ReadWindowDump(name);
    const bool has_imu = !problem.window.imu.empty();
    problem.options.dogleg = has_imu;  // VINS-Mono's settings
    problem.options.iterations = has_imu ? 8 : 20;
  } else if (name.size() > 4 && name.substr(name.size() - 4) == ".g2o") {
    problem.kind = Problem::Kind::kPoseGraph;
    problem.pose_graph = name;
    problem.options.dogleg = true;  // few and long steps
    problem.options.iterations = 50;
  } else {
    problem.bal = is_city ? CityProblem(name.substr(5)) : is_part ? FirstCameras(name.substr(6)) : ReadBal(name);
    if (problem.bal.cameras.size() > 5000) problem.options.iterations = 8;  // of some seconds each
    // Unless the way says otherwise; in a city, S is cheap to factor.
    if (problem.bal.cameras.size() > 400) {
      problem.options.linear_solver = is_city ? peer::LinearSolver::kSparseSchur : peer::LinearSolver::kIterativeSchur;
    }
  }
  return problem;
}

void TakeWay(const std::string& words, peer::PeerOptions* options) {
  using Change = void (*)(peer::PeerOptions*);
  constexpr std::pair<const char*, Change> kWords[] = {
      {"lm", [](auto* o) { o->dogleg = false; }},
      {"dogleg", [](auto* o) { o->dogleg = true; }},
      {"xyz", [](auto* o) { o->points = BalPoints::kXyz; }},
      {"ray", [](auto* o) { o->points = BalPoints::kOnRay; }},
      {"inner", [](auto* o) { o->inner = true; }},
      {"whole", [](auto* o) { o->inner = false; }},
      {"dense", [](auto* o) { o->linear_solver = peer::LinearSolver::kDenseSchur; }},
      {"sparse", [](auto* o) { o->linear_solver = peer::LinearSolver::kSparseSchur; }},
      {"iterative", [](auto* o) { o->linear_solver = peer::LinearSolver::kIterativeSchur; }},
      {"scaled", [](auto* o) { o->scaled = true; }},
      {"unscaled", [](auto* o) { o->scaled = false; }},
      {"suite", [](auto* o) { o->eigen = false; }},
      {"eigen", [](auto* o) { o->eigen = true; }},
      {"mixed", [](auto* o) { o->mixed = true; }}};
  std::istringstream list(words);
  for (std::string word; std::getline(list, word, ',');) {
    if (word.rfind("radius=", 0) == 0) {
      options->radius = NumberIn(word.substr(7), 1e-30, 1e30);
    } else if (word.rfind("threads=", 0) == 0) {
      options->threads = NumberIn(word.substr(8), 1, 256);
    } else {
      OneOf(word, kWords)(options);
    }
  }
}

peer::PeerResult Timed(bool wall, const std::function<double()>& work) {
  const Stopwatch watch(wall);
  const double agreed = work(), seconds = watch.Seconds();
  return {agreed, agreed, seconds, 1, {{seconds, agreed}}};
}

}  // namespace ch5::bench
