#include "ch5_backend/consistency/gauge_audit.h"

#include "ch5_backend/marginalize/marginalize.h"
#include "ch5_backend/marginalize/scoped_linearization_point.h"

namespace ch5 {
namespace {

// @param N  n×4 or n×7, from GaugeDirections
std::vector<GaugeLeak> LeaksAlong(const MatXX& N, const MatXX& H, const VecX& b, GaugeGroup group) {
  const VecX p = ScalingOf(H);
  const std::vector<std::string> names = GaugeDirectionNames(group);
  std::vector<GaugeLeak> leaks;
  for (size_t k = 0; k < names.size(); ++k) {
    const VecX n = N.col(static_cast<Eigen::Index>(k)), Hn = H * n;
    const double size = (p.asDiagonal() * n).norm();
    leaks.push_back(
        {names[k], n.dot(Hn), size > 0.0 ? (Hn.array() / p.array()).matrix().norm() / size : 0.0, n.dot(b)});
  }
  return leaks;
}

}  // namespace

// H n = 0 and nᵀb = 0, or what is known of n has leaked in.  Huang (2010)
std::vector<GaugeLeak> AuditGauge(const std::vector<std::shared_ptr<Edge>>& edges, const GaugeOptions& options) {
  const MarginalSystem system = EliminateVertices(edges, {});
  return LeaksAlong(GaugeDirections(system.kept, options), system.H, system.b, options.group);
}

std::vector<GaugeLeak> AuditPrior(const Prior& prior, const GaugeOptions& options) {
  ScopedLinearizationPoint at_first_estimates;
  for (size_t i = 0; i < prior.vertices.size(); ++i) {
    at_first_estimates.Move(prior.vertices[i].get(), prior.FirstEstimate(static_cast<std::ptrdiff_t>(i)));
  }
  return LeaksAlong(GaugeDirections(prior.vertices, options), prior.J.transpose() * prior.J,
                    -prior.J.transpose() * prior.r0, options.group);
}

}  // namespace ch5
