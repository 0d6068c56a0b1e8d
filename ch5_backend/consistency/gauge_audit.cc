#include "ch5_backend/consistency/gauge_audit.h"

#include <algorithm>
#include <cmath>

#include "ch5_backend/marginalize/marginalize.h"
#include "ch5_backend/marginalize/moved_vertices.h"
#include "ch5_backend/types/vertices.h"

namespace ch5 {
namespace {

// x ↦ c + s R (x − c) + t.
struct GroupElement {
  double s = 1.0;
  Qd R = Qd::Identity();
  Vec3 t = Vec3::Zero(), c = Vec3::Zero();

  Vec3 operator*(const Vec3& x) const { return c + s * (R * (x - c)) + t; }

  // Its action on what a vertex stands for; what does not live in W stays.
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
  const char* name;
  GroupElement (*element)(double epsilon);
};

GroupElement Turn(const Vec3& theta) { return {1.0, ExpSO3(theta), Vec3::Zero(), Vec3::Zero()}; }
GroupElement Shift(const Vec3& t) { return {1.0, Qd::Identity(), t, Vec3::Zero()}; }

std::vector<Direction> DirectionsOf(GaugeGroup group) {
  std::vector<Direction> directions{{"x",
                                     [](double e) {
                                       return Shift({e, 0, 0});
                                     }},
                                    {"y",
                                     [](double e) {
                                       return Shift({0, e, 0});
                                     }},
                                    {"z",
                                     [](double e) {
                                       return Shift({0, 0, e});
                                     }},
                                    {"yaw", [](double e) {
                                       return Turn({0, 0, e});
                                     }}};
  if (group == GaugeGroup::kMonocular) {
    directions.push_back({"roll", [](double e) { return Turn({e, 0, 0}); }});
    directions.push_back({"pitch", [](double e) { return Turn({0, e, 0}); }});
    directions.push_back({"scale", [](double e) {
                            return GroupElement{std::exp(e), Qd::Identity(), {0, 0, 0}, {0, 0, 0}};
                          }});
  }
  return directions;
}

Vec3 MeanPosition(const std::vector<std::shared_ptr<Vertex>>& vertices, const std::vector<const Vertex*>& bystanders) {
  Vec3 sum = Vec3::Zero();
  int count = 0;
  for (const auto& vertex : vertices) {
    const auto* pose = dynamic_cast<const VertexPose*>(vertex.get());
    if (!pose || std::find(bystanders.begin(), bystanders.end(), pose) != bystanders.end()) continue;
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

MatXX GaugeDirections(const std::vector<std::shared_ptr<Vertex>>& vertices, const GaugeAuditOptions& options) {
  const MovedVertices at_linearisation(options.first_estimates);
  const std::vector<Direction> directions = DirectionsOf(options.group);
  const Vec3 center = MeanPosition(vertices, options.bystanders);
  int rows = 0;
  for (const auto& vertex : vertices) rows += vertex->LocalDimension();
  MatXX N = MatXX::Zero(rows, static_cast<Eigen::Index>(directions.size()));
  int row = 0;
  for (const auto& vertex : vertices) {
    const int dim = vertex->LocalDimension();
    const auto& still = options.bystanders;
    if (std::find(still.begin(), still.end(), vertex.get()) == still.end()) {
      for (size_t k = 0; k < directions.size(); ++k) {
        N.block(row, static_cast<Eigen::Index>(k), dim, 1) = Differentiate(vertex.get(), directions[k], center);
      }
    }
    row += dim;
  }
  return N;
}

namespace {

std::vector<GaugeLeak> Leaks(const MatXX& H, const VecX& b, const MatXX& N, GaugeGroup group) {
  const VecX p = ScalingOf(H);
  const std::vector<Direction> directions = DirectionsOf(group);
  std::vector<GaugeLeak> leaks;
  for (size_t k = 0; k < directions.size(); ++k) {
    const VecX n = N.col(static_cast<Eigen::Index>(k)), Hn = H * n;
    const double size = (p.asDiagonal() * n).norm();
    leaks.push_back(
        {directions[k].name, n.dot(Hn), size > 0.0 ? (Hn.array() / p.array()).matrix().norm() / size : 0.0, n.dot(b)});
  }
  return leaks;
}

}  // namespace

std::vector<GaugeLeak> AuditGauge(const std::vector<std::shared_ptr<Edge>>& edges, const GaugeAuditOptions& options) {
  const MarginalSystem system = EliminateVertices(edges, {});
  return Leaks(system.H, system.b, GaugeDirections(system.kept, options), options.group);
}

std::vector<GaugeLeak> AuditPrior(const Prior& prior, const GaugeAuditOptions& options) {
  MovedVertices at_first_estimates;
  for (size_t i = 0; i < prior.vertices.size(); ++i) {
    at_first_estimates.Move(prior.vertices[i].get(), prior.FirstEstimate(static_cast<std::ptrdiff_t>(i)));
  }
  return Leaks(prior.J.transpose() * prior.J, -prior.J.transpose() * prior.r0, GaugeDirections(prior.vertices, options),
               options.group);
}

}  // namespace ch5
