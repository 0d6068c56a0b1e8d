#include "ch5_backend/consistency/gauge_directions.h"

#include <algorithm>
#include <cmath>

#include "ch5_backend/marginalize/scoped_linearization_point.h"
#include "ch5_backend/types/vertices.h"

namespace ch5 {
namespace {

// x ↦ c + s R (x − c) + t.
struct GroupElement {
  double s = 1.0;
  Qd R = Qd::Identity();
  Vec3 t = Vec3::Zero(), c = Vec3::Zero();

  Vec3 operator*(const Vec3& x) const { return c + s * (R * (x - c)) + t; }

  // Its action on the state of a vertex; a state that is not expressed in W does not change.
  void ActOn(Vertex* vertex) const {
    if (auto* pose = dynamic_cast<VertexPose*>(vertex)) {
      pose->SetPose(R * pose->q(), *this * pose->p());
    } else if (auto* point = dynamic_cast<VertexPointXYZ*>(vertex)) {
      point->SetEstimate(*this * point->GetEstimate());
    } else if (auto* inverse_depth = dynamic_cast<VertexInverseDepth*>(vertex)) {
      inverse_depth->Parameters() /= s;
    } else if (auto* speed_bias = dynamic_cast<VertexSpeedBias*>(vertex)) {
      speed_bias->Parameters().head<3>() = s * (R * speed_bias->v());
    }
  }
};

struct Direction {
  std::string name;
  GroupElement (*element)(double epsilon);
};

GroupElement Rotate(const Vec3& theta) { return {1.0, ExpSO3(theta), Vec3::Zero(), Vec3::Zero()}; }
GroupElement Translate(const Vec3& t) { return {1.0, Qd::Identity(), t, Vec3::Zero()}; }
GroupElement Scale(double s) { return {s, Qd::Identity(), Vec3::Zero(), Vec3::Zero()}; }

std::vector<Direction> DirectionsOf(GaugeGroup group) {
  std::vector<Direction> directions;
  directions.push_back({"x", [](double e) { return Translate({e, 0, 0}); }});
  directions.push_back({"y", [](double e) { return Translate({0, e, 0}); }});
  directions.push_back({"z", [](double e) { return Translate({0, 0, e}); }});
  directions.push_back({"yaw", [](double e) { return Rotate({0, 0, e}); }});
  if (group == GaugeGroup::kMonocular) {
    directions.push_back({"roll", [](double e) { return Rotate({e, 0, 0}); }});
    directions.push_back({"pitch", [](double e) { return Rotate({0, e, 0}); }});
    directions.push_back({"scale", [](double e) { return Scale(std::exp(e)); }});
  }
  return directions;
}

bool Contains(const std::vector<const Vertex*>& vertices, const Vertex* vertex) {
  return std::find(vertices.begin(), vertices.end(), vertex) != vertices.end();
}

Vec3 MeanPosition(const std::vector<std::shared_ptr<Vertex>>& vertices, const std::vector<const Vertex*>& local_poses) {
  Vec3 sum = Vec3::Zero();
  int count = 0;
  for (const auto& vertex : vertices) {
    const auto* pose = dynamic_cast<const VertexPose*>(vertex.get());
    if (!pose || Contains(local_poses, pose)) continue;
    sum += pose->p();
    ++count;
  }
  return sum / std::max(count, 1);
}

// (g(ε)·x ⊟ x − g(−ε)·x ⊟ x)/2ε
VecX Differentiate(Vertex* vertex, const Direction& direction, const Vec3& center) {
  constexpr double kEpsilon = 1e-5;  // error ε² ≈ rounding/ε
  const VecX x = vertex->Parameters();
  const auto moved_by = [&](double epsilon) {
    GroupElement g = direction.element(epsilon);
    g.c = center;
    g.ActOn(vertex);
    VecX delta = vertex->Minus(x);
    vertex->Parameters() = x;
    return delta;
  };
  return (moved_by(kEpsilon) - moved_by(-kEpsilon)) / (2.0 * kEpsilon);
}

}  // namespace

std::vector<std::string> GaugeDirectionNames(GaugeGroup group) {
  std::vector<std::string> names;
  for (const Direction& direction : DirectionsOf(group)) names.push_back(direction.name);
  return names;
}

// n = ∂(g(ε)·x ⊟ x)/∂ε for each direction.  Zhang (2018), §III
MatXX GaugeDirections(const std::vector<std::shared_ptr<Vertex>>& vertices, const GaugeOptions& options) {
  const ScopedLinearizationPoint at_linearization_points(options.linearization_points);
  const std::vector<Direction> directions = DirectionsOf(options.group);
  const Vec3 center = MeanPosition(vertices, options.local_poses);
  int rows = 0;
  for (const auto& vertex : vertices) rows += vertex->LocalDimension();
  MatXX N = MatXX::Zero(rows, static_cast<Eigen::Index>(directions.size()));
  int row = 0;
  for (const auto& vertex : vertices) {
    const int dim = vertex->LocalDimension();
    if (!Contains(options.local_poses, vertex.get())) {
      for (size_t k = 0; k < directions.size(); ++k) {
        N.block(row, static_cast<Eigen::Index>(k), dim, 1) = Differentiate(vertex.get(), directions[k], center);
      }
    }
    row += dim;
  }
  return N;
}

}  // namespace ch5
