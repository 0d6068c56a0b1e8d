#include "ch5_backend/consistency/gauge_directions.h"

#include <algorithm>

#include "ch5_backend/types/vertices.h"

namespace ch5 {
namespace {

Vec3 MeanPosition(const Vertices& vertices) {
  Vec3 sum = Vec3::Zero();
  int count = 0;
  for (const auto& vertex : vertices) {
    const auto* pose = dynamic_cast<const VertexPose*>(vertex.get());
    if (!pose) continue;
    sum += pose->p();
    ++count;
  }
  return sum / std::max(count, 1);
}

// From motions about the origin to motions about c:  ω × (x − c) = ω × x − ω × c,  x − c.
void MoveCenter(const Vec3& c, MatXX* U) {
  const MatXX translations = U->leftCols<3>();
  const Vec3 axes[] = {Vec3::UnitZ(), Vec3::UnitX(), Vec3::UnitY()};
  for (Eigen::Index k = 3; k < std::min<Eigen::Index>(U->cols(), 6); ++k)
    U->col(k) -= translations * axes[k - 3].cross(c);
  if (U->cols() == 7) U->col(6) -= translations * c;
}

}  // namespace

std::vector<std::string> GaugeDirectionNames(GaugeGroup group) {
  std::vector<std::string> names = {"x", "y", "z", "yaw", "roll", "pitch", "scale"};
  names.resize(static_cast<size_t>(NumGaugeDirections(group)));
  return names;
}

MatXX GaugeDirections(const Vertices& vertices, const GaugeOptions& options) {
  const auto is_local = [&](const std::shared_ptr<Vertex>& vertex) {
    return std::find(options.local_poses.begin(), options.local_poses.end(), vertex.get()) != options.local_poses.end();
  };
  Vertices in_world;
  std::remove_copy_if(vertices.begin(), vertices.end(), std::back_inserter(in_world), is_local);
  MatXX U = GaugeNullSpace(in_world, options.group);
  MoveCenter(MeanPosition(in_world), &U);

  MatXX N = MatXX::Zero(TotalLocalDimension(vertices), U.cols());
  int row = 0, row_in_world = 0;
  for (const auto& vertex : vertices) {
    const int dim = vertex->LocalDimension();
    if (!is_local(vertex)) {
      N.middleRows(row, dim) = U.middleRows(row_in_world, dim);
      row_in_world += dim;
    }
    row += dim;
  }
  return N;
}

}  // namespace ch5
