#pragma once
/// Which loop closures of a pose graph are false, by graduated non-convexity (Yang, Antonante, Tzoumas, Carlone:
/// "Graduated Non-Convexity for Robust Spatial Perception", RA-L 2020).
///
/// Each loop has a weight w. By turns the poses are solved for, with the weights held, and the weights are set from the
/// residuals: the minimum over w of a surrogate cost, which is convex at first and becomes the robust one as μ moves.
/// With u = rᵀWr / c², where c² is the most that a good edge has:
///
///   truncated least squares          Geman–McClure
///   μ = 1/(2 u_max − 1), × 1.4 …     μ = 2 u_max, ÷ 1.4 … 1
///   w = 1              u ≤ μ/(μ+1)   w = (μ/(μ + u))²
///       √(μ(μ+1)/u)−μ  between
///       0              u ≥ (μ+1)/μ
///
/// Edges of the tree that follows the odometry (spanning_tree.h) keep w = 1: nothing else would hold their poses together,
/// so they cannot be judged. The same tree is a start that no false loop spoils.

#include <functional>
#include <vector>

#include "ch5_backend/graph/graph.h"

namespace ch5 {

/// The robust cost that graduated non-convexity ends at.
enum class Surrogate { kTruncated, kGemanMcClure };

/// w of an edge with u = rᵀWr/c² at μ.
double GraduatedWeight(Surrogate surrogate, double u, double mu);

struct GraduatedOptions {
  Surrogate surrogate = Surrogate::kTruncated;
  double scale = 0.0;  ///< c; unless set, one good loop in a thousand has a larger √(rᵀWr)
};

/// What was found of a loop.
struct LoopVerdict {
  Edge* edge;
  double c2;          ///< c²
  double limit;       ///< a loop beyond is false: c², or unless c is set what no good loop has, with probability 0.99
                      ///< (less where loops that follow each other agree far better than their information claims)
  double chi2 = 0.0;  ///< rᵀWr at the end
  double weight = 1.0;  ///< at the end
  bool IsFalse() const { return chi2 > limit; }
  /// Beyond the limit, but by less than a factor two in √(rᵀWr).
  bool IsClose() const { return IsFalse() && chi2 < 4.0 * limit; }
};

/// The edges between poses, not both fixed, that the tree along the odometry does not need, with c² and the limit of each.
std::vector<LoopVerdict> FindLoops(const Graph& graph, double scale = 0.0);

/// Computes chi2 of each loop at the present state.
void MeasureLoops(std::vector<LoopVerdict>* loops);

/// Lowers chi2 of loops given up to what their prediction's uncertainty leaves of it, where that is within the limit: with Σ the
/// covariance of both ends by all that counts, rᵀ(W⁻¹ + J Σ Jᵀ)⁻¹r, which is χ² of a good loop that took no part.
void ReadmitLoops(Graph* graph, std::vector<LoopVerdict>* loops);

/// Moves loops beyond their limit to level 1, which a solver ignores, and the others to level 0.
/// @return whether one has moved
bool SeparateFalseLoops(const std::vector<LoopVerdict>& loops);

/// Finds the false loops and moves them to level 1, which a solver ignores; the loops that are kept count in full.
/// @param graph  at a start that false loops do not spoil: PoseGraphStart::kOdometry
/// @param solve  lowers the cost of the graph from where it is; a few iterations are enough
/// @return all loops
/// @throws std::invalid_argument if the graph or `solve` is missing, or the scale is negative or not a number
std::vector<LoopVerdict> GiveUpFalseLoops(const GraduatedOptions& options, Graph* graph,
                                          const std::function<void()>& solve);

}  // namespace ch5
