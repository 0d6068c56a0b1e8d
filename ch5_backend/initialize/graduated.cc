#include "ch5_backend/initialize/graduated.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <map>
#include <memory>
#include <unordered_set>

#include "ch5_backend/initialize/spanning_tree.h"
#include "ch5_backend/math/chi_squared.h"
#include "ch5_backend/math/median.h"
#include "ch5_backend/math/option_checks.h"
#include "ch5_backend/sparse/joint_covariance.h"
#include "ch5_backend/types/pose_graph/as_transform.h"

namespace ch5 {
namespace {

// ρ(s) = w s
class WeightLoss : public LossFunction {
 public:
  Rho Evaluate(double s) const override { return {weight * s, weight, 0.0}; }
  double weight = 1.0;
};

bool HasFreeVertex(const Edge& edge) {
  return std::any_of(edge.Vertices().begin(), edge.Vertices().end(), [](const auto& v) { return !v->IsFixed(); });
}

double LargestRatio(const std::vector<LoopVerdict>& loops) {
  double largest = 0.0;
  for (const LoopVerdict& loop : loops) largest = std::max(largest, loop.chi2 / loop.c2);
  return largest;
}

// rᵀ(W⁻¹ + J Σ Jᵀ)⁻¹ r of a loop that takes no part, with Σ the covariance of its ends by all others:  W (I + J Σ Jᵀ W)⁻¹.
double Chi2OfPrediction(Edge* edge, Covariance* covariance) {
  edge->Linearize();
  const VecX r = edge->Residual();
  const MatXX W = edge->Information();
  MatXX J(r.size(), 0);
  std::vector<std::shared_ptr<Vertex>> free;
  for (size_t k = 0; k < edge->Vertices().size(); ++k) {
    if (edge->Vertices()[k]->IsFixed()) continue;
    free.push_back(edge->Vertices()[k]);
    const MatXX J_k = edge->Jacobian(k);
    J.conservativeResize(Eigen::NoChange, J.cols() + J_k.cols());
    J.rightCols(J_k.cols()) = J_k;
  }
  const MatXX S = J * JointCovariance(free, covariance) * J.transpose();
  return r.dot(W * (MatXX::Identity(r.size(), r.size()) + S * W).partialPivLu().solve(r));
}

// rᵀWr of one loop if another, one step of odometry further at both ends, were exact:  T_i_j = T_i_k T_k_l T_l_j.
double Chi2OfNeighbor(const Edge& loop, const Transform& predicted) {
  const Transform off = Inverse(*MeasurementOf(loop)) * predicted;
  const Vec3 half = std::copysign(1.0, off.q.w()) * off.q.vec();  // of the rotation vector, as EdgeSE3Between has it
  VecX r(loop.ResidualDimension());
  if (r.size() == 3) {
    r << off.p.head<2>(), 2.0 * std::asin(std::clamp(half.z(), -1.0, 1.0));
  } else {
    r << off.p, half;
  }
  return r.dot(loop.Information() * r);
}

// Information matrices that claim much less than is known let false loops pass. How far two loops that follow each other differ
// is known before any solution, and whatever else is false: twice the noise of one, and the steps' between. Of this, in place of
// what W says, a limit leaves room for tails: in parking-garage the largest good loop is 11 times beyond Gaussian noise.
double ShareOfLimit(const std::vector<LoopVerdict>& loops, const Graph& graph) {
  constexpr double kTail = 15.0, kLeast = 1e-6;
  constexpr size_t kFewest = 20;
  const std::vector<int> number = NumberPoses(graph);
  std::map<std::pair<int, int>, Transform> steps;  // T_i_j of neighbors, in both directions
  const auto ends = [&](const Edge& edge) {
    return std::pair(number[graph.PositionOf(*edge.Vertices()[0])], number[graph.PositionOf(*edge.Vertices()[1])]);
  };
  for (const auto& edge : graph.Edges()) {
    const auto T_i_j = MeasurementOf(*edge);
    if (!T_i_j) continue;
    const auto [i, j] = ends(*edge);
    if (std::abs(i - j) == 1) steps[{i, j}] = *T_i_j, steps[{j, i}] = Inverse(*T_i_j);
  }
  std::map<std::pair<int, int>, const Edge*> by_ends;
  for (const LoopVerdict& loop : loops) by_ends.emplace(ends(*loop.edge), loop.edge);
  std::vector<double> ratios;
  for (const auto& [i_j, loop] : by_ends) {
    const auto [i, j] = i_j;
    if (const int n = loop->ResidualDimension(); n != 3 && n != 6) continue;
    for (const int step : {1, -1}) {
      const auto other = by_ends.find({i + 1, j + step});
      const auto from = steps.find({i, i + 1}), to = steps.find({j + step, j});
      if (other == by_ends.end() || from == steps.end() || to == steps.end()) continue;
      const Transform predicted = from->second * *MeasurementOf(*other->second) * to->second;
      ratios.push_back(0.5 * Chi2OfNeighbor(*loop, predicted) / ChiSquaredLimit(loop->ResidualDimension(), 0.5));
    }
  }
  return ratios.size() < kFewest ? 1.0 : std::clamp(kTail * Median(ratios), kLeast, 1.0);
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
    if (MeasurementOf(*edge) && tree.count(edge.get()) == 0 && HasFreeVertex(*edge))
      loops.push_back({edge.get(), scale * scale, scale * scale});
  }
  if (scale > 0.0) return loops;
  // P(all n good loops below their limits) = (1 − tail)ⁿ
  const double tail = -std::expm1(std::log(kNoneLost) / static_cast<double>(loops.size()));
  const double share = ShareOfLimit(loops, graph);
  for (LoopVerdict& loop : loops) {
    loop.c2 = share * ChiSquaredLimit(loop.edge->ResidualDimension(), kDoubtful);
    loop.limit = std::max(loop.c2, share * ChiSquaredLimit(loop.edge->ResidualDimension(), tail));
  }
  return loops;
}

void MeasureLoops(std::vector<LoopVerdict>* loops) {
  for (LoopVerdict& loop : *loops) {
    loop.edge->ComputeResidual();
    loop.chi2 = loop.edge->Chi2();
  }
}

void ReadmitLoops(Graph* graph, std::vector<LoopVerdict>* loops) {
  constexpr double kFar = 25.0;
  constexpr size_t kMost = 100;
  std::vector<LoopVerdict*> near;
  for (LoopVerdict& loop : *loops)
    if (loop.edge->Level() != 0 && loop.IsFalse() && loop.chi2 < kFar * loop.limit) near.push_back(&loop);
  if (near.empty()) return;
  std::sort(near.begin(), near.end(), [](const LoopVerdict* a, const LoopVerdict* b) { return a->chi2 < b->chi2; });
  if (near.size() > kMost) near.resize(kMost);
  try {
    Covariance covariance(graph);
    for (LoopVerdict* loop : near) {
      const double chi2 = Chi2OfPrediction(loop->edge, &covariance);
      if (chi2 <= loop->limit) loop->chi2 = chi2;
    }
  } catch (const CovarianceError&) {
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
  if (!graph) throw GraphError("GiveUpFalseLoops: the graph is null");
  if (!solve) throw std::invalid_argument("GiveUpFalseLoops: what solves the graph is missing");
  CheckNotNegative("GraduatedOptions::scale", options.scale);
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
