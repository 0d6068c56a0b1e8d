#include "ch5_backend/evaluate/reconstruction.h"

#include <cmath>
#include <stdexcept>
#include <string>

#include "ch5_backend/math/so3.h"

namespace ch5 {
namespace {

std::vector<Vec3> Centers(const Reconstruction& world) {
  std::vector<Vec3> centers;
  for (const Transform& T_W_C : world.frames) centers.push_back(T_W_C.p);
  return centers;
}

void RequireSameSizes(const Reconstruction& a, const Reconstruction& b, const char* who) {
  if (a.frames.size() == b.frames.size() && a.points.size() == b.points.size()) return;
  throw std::invalid_argument(std::string(who) + ": " + std::to_string(a.frames.size()) + " frames and " +
                              std::to_string(a.points.size()) + " points against " + std::to_string(b.frames.size()) +
                              " and " + std::to_string(b.points.size()));
}

double RootMean(double sum, size_t count) { return count == 0 ? 0.0 : std::sqrt(sum / static_cast<double>(count)); }

Reconstruction Moved(const Similarity& S, const Reconstruction& world) {
  Reconstruction moved;
  for (const Transform& T_W_C : world.frames) moved.frames.push_back(S * T_W_C);
  for (const Vec3& p_W : world.points) moved.points.push_back(S * p_W);
  return moved;
}

}  // namespace

Reconstruction TruthOf(const MonoBaScene& scene) { return {scene.frames, scene.points}; }

Reconstruction EstimateOf(const MonoBaScene& scene, const MonoBa& problem) {
  Reconstruction estimate;
  for (const auto& pose : problem.poses) estimate.frames.push_back({pose->q(), pose->p()});
  const Transform& T_W_C0 = estimate.frames.front();
  for (size_t k = 0; k < problem.landmarks.size(); ++k) {
    const Vec3 p_C0 = scene.pixels[0][k].homogeneous() / problem.landmarks[k]->InverseDepth();
    estimate.points.push_back(T_W_C0.q * p_C0 + T_W_C0.p);
  }
  return estimate;
}

std::optional<Reconstruction> AlignToTruth(const Reconstruction& estimate, const Reconstruction& truth) {
  RequireSameSizes(estimate, truth, "AlignToTruth");
  const auto S = AlignUmeyama(Centers(estimate), Centers(truth));
  return S ? std::optional(Moved(*S, estimate)) : std::nullopt;
}

Rmse Compare(const Reconstruction& estimate, const Reconstruction& truth) {
  RequireSameSizes(estimate, truth, "Compare");
  double position = 0.0, rotation = 0.0, point = 0.0;
  for (size_t i = 0; i < truth.frames.size(); ++i) {
    position += (estimate.frames[i].p - truth.frames[i].p).squaredNorm();
    rotation += LogSO3(truth.frames[i].q.conjugate() * estimate.frames[i].q).squaredNorm();
  }
  for (size_t k = 0; k < truth.points.size(); ++k) point += (estimate.points[k] - truth.points[k]).squaredNorm();
  return {RootMean(position, truth.frames.size()), RootMean(rotation, truth.frames.size()),
          RootMean(point, truth.points.size())};
}

std::optional<Rmse> CompareAligned(const Reconstruction& estimate, const Reconstruction& truth) {
  const std::optional<Reconstruction> by_cameras = AlignToTruth(estimate, truth);
  const std::optional<Similarity> of_points = AlignUmeyama(estimate.points, truth.points);
  if (!by_cameras || !of_points) return std::nullopt;
  Rmse rmse = Compare(*by_cameras, truth);
  rmse.point = Compare(Moved(*of_points, estimate), truth).point;
  return rmse;
}

}  // namespace ch5
