#include "ch5_backend/initialize/graduated.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <unordered_set>

#include "ch5_backend/initialize/spanning_tree.h"
#include "ch5_backend/math/chi_squared.h"
#include "ch5_backend/types/pose_graph/as_transform.h"

namespace ch5 {
namespace {

// ρ(s) = w s
class WeightLoss : public LossFunction {
 public:
  Rho Evaluate(double s) const override { return {weight * s, weight, 0.0}; }
  double weight = 1.0;
};

double LargestRatio(const std::vector<LoopVerdict>& loops) {
  double largest = 0.0;
  for (const LoopVerdict& loop : loops) largest = std::max(largest, loop.chi2 / loop.c2);
  return largest;
}

}  // namespace

double GraduatedWeight(Surrogate surrogate, double u, double mu) {
  if (surrogate == Surrogate::kGemanMcClure) return std::pow(mu / (mu + u), 2);
  if (u * (mu + 1.0) <= mu) return 1.0;
  if (u * mu >= mu + 1.0) return 0.0;
  return std::sqrt(mu * (mu + 1.0) / u) - mu;
}

std::vector<LoopVerdict> FindLoops(const Graph& graph, double scale) {
  constexpr double kNoneLost = 0.99, kDoubtful = 1e-3;
  const std::vector<const Edge*> tree_edges = TreeEdges(TreeOrder::kOdometryFirst, graph);
  const std::unordered_set<const Edge*> tree(tree_edges.begin(), tree_edges.end());
  std::vector<LoopVerdict> loops;
  for (const auto& edge : graph.Edges()) {
    if (MeasurementOf(*edge) && tree.count(edge.get()) == 0)
      loops.push_back({edge.get(), scale * scale, scale * scale});
  }
  // P(all n good loops below their limits) = (1 − tail)ⁿ
  const double tail = -std::expm1(std::log(kNoneLost) / static_cast<double>(loops.size()));
  for (LoopVerdict& loop : loops) {
    if (scale > 0.0) continue;
    loop.c2 = ChiSquaredLimit(loop.edge->ResidualDimension(), kDoubtful);
    loop.limit = std::max(loop.c2, ChiSquaredLimit(loop.edge->ResidualDimension(), tail));
  }
  return loops;
}

void MeasureLoops(std::vector<LoopVerdict>* loops) {
  for (LoopVerdict& loop : *loops) {
    loop.edge->ComputeResidual();
    loop.chi2 = loop.edge->Chi2();
  }
}

bool SeparateFalseLoops(const std::vector<LoopVerdict>& loops) {
  bool has_moved = false;
  for (const LoopVerdict& loop : loops) {
    const int level = loop.IsFalse() ? 1 : 0;
    has_moved |= loop.edge->Level() != level;
    loop.edge->SetLevel(level);
  }
  return has_moved;
}

std::vector<LoopVerdict> GiveUpFalseLoops(const GraduatedOptions& options, Graph* graph,
                                          const std::function<void()>& solve) {
  constexpr double kPace = 1.4, kMostMu = 1e6;  // at μ = 1e6 no weight is left between 0 and 1 but at u = 1
  constexpr int kMostRounds = 300;
  const bool truncated = options.surrogate == Surrogate::kTruncated;
  std::vector<LoopVerdict> loops = FindLoops(*graph, options.scale);
  MeasureLoops(&loops);
  std::vector<std::shared_ptr<WeightLoss>> losses;
  for (const LoopVerdict& loop : loops) loop.edge->SetLossFunction(losses.emplace_back(std::make_shared<WeightLoss>()));

  const double u_max = LargestRatio(loops);
  double mu = truncated ? 1.0 / std::max(2.0 * u_max - 1.0, 1.0 / kMostMu) : std::max(2.0 * u_max, 1.0);
  for (int round = 0; round < kMostRounds; ++round) {
    bool between = false;
    for (size_t k = 0; k < loops.size(); ++k) {
      loops[k].weight = losses[k]->weight = GraduatedWeight(options.surrogate, loops[k].chi2 / loops[k].c2, mu);
      between |= loops[k].weight > 0.0 && loops[k].weight < 1.0;
    }
    solve();
    MeasureLoops(&loops);
    if (truncated ? !between || mu > kMostMu : mu == 1.0) break;
    mu = truncated ? kPace * mu : std::max(mu / kPace, 1.0);
  }
  for (const LoopVerdict& loop : loops) loop.edge->SetLossFunction(nullptr);
  SeparateFalseLoops(loops);
  return loops;
}

}  // namespace ch5
