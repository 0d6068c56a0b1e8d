/// Solves a "Bundle Adjustment in the Large" file: ch5_bal FILE --out DIR.

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <vector>

#include "ch5_backend/experiments/studies/bal_study.h"
#include "ch5_backend/files/tables/text_writer.h"
#include "ch5_backend/math/median.h"

namespace {

constexpr char kUsage[] =
    "usage: ch5_bal FILE --out DIR [--iterations N] [--threads N] [--huber PIXELS] [--solver NAME]\n"
    "               [--points NAME] [--strict]\n"
    "Solves the bundle adjustment in FILE (BAL text) and writes into DIR: the result as BAL and PLY, the table of\n"
    "iterations, a summary, and what figures/bal.py draws.\n"
    "  --iterations N   at most N iterations (50)\n"
    "  --threads N      (as many as the machine has); the result does not depend on it\n"
    "  --huber PIXELS   Huber's loss with this threshold, for data with outliers (none)\n"
    "  --solver NAME    of the cameras' system: dense, sparse or pcg form it, implicit-pcg and power-series do not;\n"
    "                   automatic (the default) begins with power-series for more than 400 cameras\n"
    "  --points NAME    how a step moves a point: ray (the default), along the ray from a camera, or xyz, by x + dx\n"
    "  --strict         a repeated observation is an error; without it, it is left out and counted\n";

// A solution may begin or end at a focal length that no camera has, and still fit the pixels.
void PrintDoubtsOfFocalLengths(const ch5::BalProblem& problem, const char* when) {
  constexpr double kFar = 30.0;  // times the median or a part of it; phones' and telephoto lenses' are within
  std::vector<double> sizes;
  for (const ch5::Vec9& camera : problem.cameras) sizes.push_back(std::abs(camera[6]));
  const double median = ch5::Median(sizes);
  const auto is_doubtful = [&](const ch5::Vec9& x) { return !(x[6] > median / kFar && x[6] < median * kFar); };
  const auto& cameras = problem.cameras;
  const auto first = std::find_if(cameras.begin(), cameras.end(), is_doubtful);
  if (first == cameras.end()) return;
  const double f = (*first)[6];
  std::printf("camera %td has the focal length %.4g px %s: %s (cameras like it: %td; the median is %.4g px)\n",
              first - cameras.begin(), f, when,
              f < 0.0    ? "negative, as if x and y of its pixels had the opposite sign"
              : f == 0.0 ? "no camera has that"
                         : "implausible beside the others",
              std::count_if(first, cameras.end(), is_doubtful), median);
}

// One such pixel bends its camera until it fits, so that no residual tells afterwards.
void PrintDoubtsOfPixels(const ch5::BalProblem& problem) {
  constexpr double kFar = 10.0;  // times the median distance from the center; in public files at most 3.5
  std::vector<double> radii;
  for (const auto& observation : problem.observations) radii.push_back(observation.pixel.norm());
  const double far = kFar * ch5::Median(radii);
  const auto first = std::find_if(radii.begin(), radii.end(), [&](double r) { return r > far; });
  if (first == radii.end()) return;
  const auto& [camera, point, pixel] = problem.observations[first - radii.begin()];
  std::printf(
      "pixels more than %g times as far from the center as the median: %td, the first in line %d: "
      "camera %d, point %d, (%.6g, %.6g)\n",
      kFar, std::count_if(first, radii.end(), [&](double r) { return r > far; }), problem.lines[first - radii.begin()],
      camera, point, pixel.x(), pixel.y());
}

// What is solved all the same, but hardly meant.
void PrintDoubts(const ch5::BalProblem& problem) {
  std::vector<int> views(problem.points.size(), 0), points(problem.cameras.size(), 0);
  ch5::Vec2 least = problem.observations[0].pixel, most = least;
  for (const auto& [camera, point, pixel] : problem.observations) {
    ++views[point];
    ++points[camera];
    least = least.cwiseMin(pixel);
    most = most.cwiseMax(pixel);
  }
  if (const auto few = std::count_if(views.begin(), views.end(), [](int n) { return n < 2; }); few > 0)
    std::printf("points that fewer than two cameras see, so that their distance is unknown: %td\n", few);
  if (const auto few = std::count_if(points.begin(), points.end(), [](int n) { return n < 5; }); few > 0)
    std::printf("cameras that see fewer than five points, so that their nine unknowns are not all determined: %td\n",
                few);
  if (least.x() >= 0.0 && (least.y() >= 0.0 || most.y() <= 0.0))
    std::printf("no x is negative: BAL's pixels are counted from the center of the image, y upwards\n");
  const auto turns = std::count_if(problem.cameras.begin(), problem.cameras.end(),
                                   [](const ch5::Vec9& camera) { return camera.head<3>().norm() > 2.0 * M_PI; });
  if (turns > 0) std::printf("cameras turned by more than a full turn: %td; BAL's rotations are in radians\n", turns);
  PrintDoubtsOfPixels(problem);
  PrintDoubtsOfFocalLengths(problem, "in the file");
}

void Run(const ch5::FileSolveOptions& options, ch5::BalPoints move, bool strict) {
  std::vector<ch5::LeftOut> left_out;
  const ch5::BalProblem problem = ch5::ReadBal(options.input, strict ? nullptr : &left_out);
  const ch5::OutputFolder made(options.out);
  std::printf("%s: %zu cameras, %zu points, %zu observations\n\n", options.Name().c_str(), problem.cameras.size(),
              problem.points.size(), problem.observations.size());
  PrintDoubts(problem);
  if (!problem.unended.empty()) std::printf("%s\n", problem.unended.c_str());
  for (const ch5::LeftOut& repeated : left_out)
    std::printf("observations left out: %d, the first: %s\n", repeated.count, repeated.first.c_str());
  ch5::BalStudy study = ch5::SolveBal(problem, options, move);
  study.left_out = left_out;
  ch5::WriteBalStudy(study, options);
  char error[80];
  std::snprintf(error, sizeof error, ", mean error %.3f -> %.3f px", study.mean_error_before, study.mean_error_after);
  ch5::PrintSummary(study.summary, error);
  if (10 * study.behind_before > static_cast<int>(problem.observations.size()))
    std::printf(
        "in %d observations the file has the point behind its camera: do points and cameras share one world, and "
        "do R and t lead from it to the camera, which looks along -z?\n",
        study.behind_before);
  if (study.behind_camera > 0)
    std::printf("in %d observations the point lies behind its camera\n", study.behind_camera);
  PrintDoubtsOfFocalLengths(study.after, "in the result");
  if (!study.hint.empty()) std::printf("%s\n", study.hint.c_str());
}

}  // namespace

int main(int argc, char** argv) {
  ch5::FileSolveOptions options;
  ch5::BalPoints move = ch5::BalPoints::kOnRay;
  bool strict = false;
  return ch5::RunFileCommand(
      "ch5_bal", kUsage, argc, argv, &options, [&] { Run(options, move, strict); },
      [&](ch5::CommandLine* line) {
        line->Flag("--strict", [&] { strict = true; });
        line->Option("--points", [&](const std::string& name) {
          move = ch5::OneOf<ch5::BalPoints>(name, {{"ray", ch5::BalPoints::kOnRay}, {"xyz", ch5::BalPoints::kXyz}});
        });
      });
}
