#include "ch5_backend/files/bal.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "ch5_backend/files/tables/text_writer.h"
#include "ch5_backend/files/text_reader.h"
#include "ch5_backend/math/lists.h"
#include "ch5_backend/types/bal/edge_bal.h"

namespace ch5 {
namespace {

// A file of `bytes` bytes cannot hold more: each number takes a digit and a space at least.
void RequireRoomFor(int cameras, int points, int observations, const TextReader& reader) {
  const uint64_t numbers =
      4 * static_cast<uint64_t>(observations) + 9 * static_cast<uint64_t>(cameras) + 3 * static_cast<uint64_t>(points);
  if (2 * numbers > reader.BytesLeft() + 1) {
    reader.Fail("the header promises " + std::to_string(cameras) + " cameras, " + std::to_string(points) +
                " points and " + std::to_string(observations) + " observations, " + std::to_string(numbers) +
                " numbers, but only " + std::to_string(reader.BytesLeft()) + " bytes follow");
  }
}

// Of a point that a camera sees twice, the first observation stays. In the order of points each
// camera remembers its last observation: linear time.
void LeaveOutRepetitions(const std::string& path, std::vector<LeftOut>* left_out, BalProblem* problem) {
  std::vector<int>& lines = problem->lines;
  std::vector<BalObservation>& observations = problem->observations;
  const Lists by_point = ListByKey(static_cast<int>(observations.size()), static_cast<int>(problem->points.size()),
                                   [&](int i) { return observations[static_cast<size_t>(i)].point; });
  constexpr size_t kNone = std::numeric_limits<size_t>::max();
  std::vector<size_t> last(problem->cameras.size(), kNone);
  std::vector<bool> is_repeated(observations.size(), false);
  auto next_in_order = by_point.items.begin();
  ReadEach(path, left_out, [&] {
    if (next_in_order == by_point.items.end()) return false;
    const auto i = static_cast<size_t>(*next_in_order++);
    const auto [camera, point, pixel] = observations[i];
    size_t& previous = last[static_cast<size_t>(camera)];
    is_repeated[i] = previous != kNone && observations[previous].point == point;
    if (!is_repeated[i]) previous = i;
    if (!is_repeated[i]) return true;
    throw FileError(path + ":" + std::to_string(lines[i]) + ": observation " + std::to_string(i) +
                    " is repeated: camera " + std::to_string(camera) + " saw point " + std::to_string(point) +
                    " in line " + std::to_string(lines[previous]) + " already");
  });
  size_t kept = 0;
  for (size_t i = 0; i < observations.size(); ++i)
    if (!is_repeated[i]) observations[kept] = observations[i], lines[kept++] = lines[i];
  observations.resize(kept);
  lines.resize(kept);
}

Qd Rotation(const Vec9& camera) { return ExpSO3(camera.head<3>()); }

std::vector<Vec3> Centers(const BalProblem& problem) {
  std::vector<Vec3> centers;
  for (const Vec9& camera : problem.cameras) centers.push_back(CameraCenter(camera));
  return centers;
}

void RequireIndices(const BalProblem& problem) {
  for (size_t i = 0; i < problem.observations.size(); ++i) {
    const auto& [camera, point, pixel] = problem.observations[i];
    if (static_cast<size_t>(camera) < problem.cameras.size() && static_cast<size_t>(point) < problem.points.size())
      continue;
    throw std::invalid_argument("BuildBal: observation " + std::to_string(i) + " names camera " +
                                std::to_string(camera) + " and point " + std::to_string(point) +
                                "; one of them does not exist");
  }
}

// The points' mean if it is far from the world's origin, as in a map's coordinates; else zero. A BAL camera turns about the
// origin: from afar, its rotation and translation can hardly be told apart.
Vec3 FarPlace(const std::vector<Vec3>& points) {
  constexpr double kFar = 100.0;  // times the points' extent
  const double count = static_cast<double>(points.size());
  Vec3 mean = Vec3::Zero();
  for (const Vec3& p_W : points) mean += p_W / count;
  double square = 0.0;
  for (const Vec3& p_W : points) square += (p_W - mean).squaredNorm();
  return mean.norm() > kFar * std::sqrt(square / count) ? mean : Vec3::Zero();
}

void MoveWorld(const Vec3& shift, BalProblem* problem) {
  for (Vec9& camera : problem->cameras) camera.segment<3>(3) -= Rotation(camera) * shift;
  for (Vec3& p_W : problem->points) p_W += shift;
}

// A point at the center of a camera that sees it has no direction there, and Jacobians of 10¹⁶ that would stop the whole solve.
// It begins on its pixel's ray, as far away as the camera's other points are on average.
void MovePointsOutOfCameras(BalProblem* problem) {
  constexpr double kCenter = 1e-6;  // of that distance
  const std::vector<Vec3> centers = Centers(*problem);
  std::vector<double> distance(centers.size(), 0.0), count(centers.size(), 0.0);
  for (const auto& [camera, point, pixel] : problem->observations) {
    distance[camera] += (problem->points[point] - centers[camera]).norm();
    count[camera] += 1.0;
  }
  for (const auto& [camera, point, pixel] : problem->observations) {
    Vec3& p_W = problem->points[point];
    const Vec9& x = problem->cameras[camera];
    const double mean = distance[camera] / count[camera];
    if (!((p_W - centers[camera]).norm() <= kCenter * mean)) continue;
    const Vec3 ray(pixel.x() / x[6], pixel.y() / x[6], -1.0);
    p_W = centers[camera] + mean * (Rotation(x).conjugate() * ray.normalized());
  }
}

}  // namespace

std::vector<Vec3> FarthestCenters(const BalProblem& problem) {
  const std::vector<Vec3> centers = Centers(problem);
  std::vector<Vec3> farthest = problem.points;
  for (const auto& [camera, point, pixel] : problem.observations) {
    const Vec3& p_W = problem.points[point];
    if ((centers[camera] - p_W).squaredNorm() > (farthest[point] - p_W).squaredNorm())
      farthest[point] = centers[camera];
  }
  return farthest;
}

BalProblem ReadBal(const std::string& path, std::vector<LeftOut>* left_out) {
  constexpr int kMost = std::numeric_limits<int>::max();
  TextReader reader(path);
  const int cameras = reader.ReadInt("number of cameras", 1, kMost);
  const int points = reader.ReadInt("number of points", 1, kMost);
  const int observations = reader.ReadInt("number of observations", 1, kMost);
  RequireRoomFor(cameras, points, observations, reader);

  BalProblem problem;
  problem.observations.resize(static_cast<size_t>(observations));
  problem.cameras.resize(static_cast<size_t>(cameras));
  problem.points.resize(static_cast<size_t>(points));
  problem.lines.reserve(problem.observations.size());
  for (int i = 0; i < observations; ++i) {
    BalObservation& observation = problem.observations[static_cast<size_t>(i)];
    reader.BeginRecord("observation", i);
    observation.camera = reader.ReadInt("camera", 0, cameras - 1);
    problem.lines.push_back(reader.Line());
    observation.point = reader.ReadInt("point", 0, points - 1);
    observation.pixel.x() = reader.ReadDouble("x");
    observation.pixel.y() = reader.ReadDouble("y");
  }
  constexpr const char* kParameters[] = {"omega_x", "omega_y", "omega_z", "t_x", "t_y", "t_z", "f", "k1", "k2"};
  for (int i = 0; i < cameras; ++i) {
    reader.BeginRecord("camera", i);
    for (int k = 0; k < 9; ++k) problem.cameras[static_cast<size_t>(i)][k] = reader.ReadDouble(kParameters[k]);
  }
  constexpr const char* kCoordinates[] = {"x", "y", "z"};
  for (int i = 0; i < points; ++i) {
    reader.BeginRecord("point", i);
    for (int k = 0; k < 3; ++k) problem.points[static_cast<size_t>(i)][k] = reader.ReadDouble(kCoordinates[k]);
  }
  reader.ExpectEnd();
  problem.unended = reader.UnendedLine();
  LeaveOutRepetitions(path, left_out, &problem);
  return problem;
}

std::string FormatBal(const BalProblem& problem) {
  std::string text;
  text.reserve(48 * problem.observations.size() + 72 * problem.points.size());
  AppendNumber(static_cast<int>(problem.cameras.size()), ' ', &text);
  AppendNumber(static_cast<int>(problem.points.size()), ' ', &text);
  AppendNumber(static_cast<int>(problem.observations.size()), '\n', &text);
  for (const BalObservation& observation : problem.observations) {
    AppendNumber(observation.camera, ' ', &text);
    AppendNumber(observation.point, ' ', &text);
    AppendNumber(observation.pixel.x(), ' ', &text);
    AppendNumber(observation.pixel.y(), '\n', &text);
  }
  for (const Vec9& camera : problem.cameras) {
    for (const double x : camera) AppendNumber(x, '\n', &text);
  }
  for (const Vec3& point : problem.points) {
    for (const double x : point) AppendNumber(x, '\n', &text);
  }
  return text;
}

std::string FormatBalPly(const BalProblem& problem) {
  std::string text = "ply\nformat ascii 1.0\nelement vertex " +
                     std::to_string(problem.points.size() + problem.cameras.size()) +
                     "\nproperty double x\nproperty double y\nproperty double z\nproperty uchar red\n"
                     "property uchar green\nproperty uchar blue\nend_header\n";
  const auto add = [&text](const Vec3& p, const char* color) {
    for (const double x : p) AppendNumber(x, ' ', &text);
    text += color;
  };
  for (const Vec3& p : problem.points) add(p, "200 200 200\n");
  for (const Vec9& camera : problem.cameras) add(CameraCenter(camera), "255 128 0\n");
  return text;
}

Vec3 CameraCenter(const Vec9& camera) { return Rotation(camera).conjugate() * -camera.segment<3>(3); }

Mat33 CameraAxes(const Vec9& camera) {
  Mat33 axes = Rotation(camera).conjugate().toRotationMatrix();
  axes.col(2) *= -1.0;
  return axes;
}

BalGraph BuildBal(const BalProblem& given, std::shared_ptr<const LossFunction> loss, BalPoints move) {
  RequireIndices(given);
  BalGraph bal;
  bal.place = FarPlace(given.points);
  BalProblem problem = given;
  MoveWorld(-bal.place, &problem);
  MovePointsOutOfCameras(&problem);
  if (move == BalPoints::kOnRay) {
    bal.tau = 3e-6;
    bal.rescue_steps = 2;
  }
  std::vector<std::shared_ptr<VertexCameraBAL>> cameras;
  std::vector<std::shared_ptr<VertexPointXYZ>> points;
  for (const Vec9& camera : problem.cameras) {
    cameras.push_back(std::make_shared<VertexCameraBAL>(camera));
    bal.graph.AddVertex(cameras.back());
  }
  const std::vector<Vec3> anchors = FarthestCenters(problem);
  for (size_t i = 0; i < anchors.size(); ++i) {
    const Vec3& p_W = problem.points[i];
    points.push_back(move == BalPoints::kOnRay ? std::make_shared<VertexPointOnRay>(p_W, anchors[i])
                                               : std::make_shared<VertexPointXYZ>(p_W));
    bal.graph.AddVertex(points.back());
  }
  for (const auto& [camera, point, pixel] : problem.observations) {
    auto edge = std::make_shared<EdgeBAL>(cameras[camera], points[point], pixel);
    edge->SetLossFunction(loss);
    bal.graph.AddEdge(std::move(edge));
  }
  bal.cameras.assign(cameras.begin(), cameras.end());
  bal.points.assign(points.begin(), points.end());
  if (VertexPointXYZ::kLocalDimension * points.size() < VertexCameraBAL::kLocalDimension * cameras.size()) {
    for (const auto& camera : cameras) camera->SetRole(Role::kLandmark);
    for (const auto& point : points) point->SetRole(Role::kPose);
  }
  return bal;
}

void ReadBack(const BalGraph& bal, BalProblem* problem) {
  if (problem->cameras.size() != bal.cameras.size() || problem->points.size() != bal.points.size()) {
    throw std::invalid_argument("ReadBack: the problem is not the one that the graph was built of");
  }
  for (size_t i = 0; i < bal.cameras.size(); ++i) problem->cameras[i] = bal.cameras[i]->Parameters();
  for (size_t i = 0; i < bal.points.size(); ++i) problem->points[i] = bal.points[i]->Parameters();
  MoveWorld(bal.place, problem);
}

double MeanReprojectionError(const Graph& graph) {
  double sum = 0.0;
  for (const auto& edge : graph.Edges()) {
    edge->ComputeResidual();
    sum += edge->Residual().norm();
  }
  return graph.Edges().empty() ? 0.0 : sum / static_cast<double>(graph.Edges().size());
}

}  // namespace ch5
