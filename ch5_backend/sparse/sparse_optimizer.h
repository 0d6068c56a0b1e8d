#pragma once
/// The sparse solver for a whole optimization: what to solve with, which part of the graph, and the algorithm.
///
///   SparseOptimizer optimizer(&graph, /*threads=*/2);
///   const Summary summary = optimizer.Solve(options);
///
/// or in g2o's words, here with a second round without the outliers of the first:
///
///   optimizer.SetReducedSolver(ReducedSolverType::kSparseCholesky);  // g2o's linear solver
///   optimizer.SetAlgorithm(Algorithm::kDogleg);                      // g2o's BlockSolver<p, l> is found from the graph
///   optimizer.InitializeOptimization();
///   optimizer.Optimize(10);
///   for (const auto& edge : graph.Edges()) {
///     edge->ComputeResidual();
///     edge->SetLevel(edge->Chi2() > 5.991 ? 1 : 0);
///   }
///   optimizer.InitializeOptimization(/*level=*/0);
///   optimizer.Optimize(10);
///
/// Threads: an optimizer and its graph are used by one thread at a time. With `threads` > 1 it starts its own, which call
/// different edges at once, but never two functions of one edge; so an edge must not change what it shares with others.
/// Edges whose Jacobians are numeric are linearized one after the other. Any number of threads gives the same bits.

#include <memory>

#include "ch5_backend/linear/reduced_solver.h"
#include "ch5_backend/solve/minimizer.h"
#include "ch5_backend/sparse/covariance.h"

namespace ch5 {

class SparseSolver;

class SparseOptimizer {
 public:
  /// The graph must outlive the optimizer; it may change between calls of Solve.
  explicit SparseOptimizer(Graph* graph, int threads = 1);
  ~SparseOptimizer();

  /// Diagonal unless set, whatever the units of the unknowns; kIdentity is the course's and g2o's.
  void SetDamping(Damping damping);
  /// Automatic unless set, and inexact where it is implicit; see reduced_solver.h.
  void SetReducedSolver(ReducedSolverType type, const IterativeOptions& options = {});

  /// Parts of vertices that stay as they are; see graph/ordering.h. ComputeMarginals knows them: their variance is zero. A
  /// Covariance of one's own does not, unless it is given them too.
  void Hold(std::vector<HeldDirections> held);
  /// One of the caller's own for the poses' system, such as MakePseudoInverse.
  void SetReducedSolver(std::unique_ptr<ReducedSolver> solver);

  /// Minimizes by the algorithm that the options name, or by the one that suits the graph (Algorithm::kAutomatic): over the
  /// edges of level 0, or what InitializeOptimization chose.
  /// @throws GraphError if an edge ties two free landmarks, or adds edges to the graph while it is evaluated
  /// @throws std::logic_error if another thread solves the same graph
  Summary Solve(const SolveOptions& options = {});

  /// Chooses the edges of a level (all, if it is negative) whose vertices are all in the set, and numbers the vertices.
  /// An edge is active if it is chosen and has a free vertex; a vertex without active edges has no part.
  /// @return false if no edge is active
  /// @throws GraphError if a vertex is null or not in the graph
  bool InitializeOptimization(int level = 0) { return Initialize({level, true, {}}); }
  bool InitializeOptimization(std::vector<std::shared_ptr<Vertex>> vertices, int level = 0) {
    return Initialize({level, false, std::move(vertices)});
  }
  /// Of the last InitializeOptimization: the active edges in order of id, and the free vertices that they touch, poses
  /// first (g2o's indexMapping).
  const std::vector<std::shared_ptr<Edge>>& ActiveEdges() const { return active_edges_; }
  const std::vector<std::shared_ptr<Vertex>>& IndexMapping() const { return index_mapping_; }
  /// Σ rᵀWr over the active edges at the present states, whose residuals are left computed.
  double ActiveChi2() const;

  /// For Optimize. Without an action nothing but the number of iterations ends it, or that there is no lower cost.
  void SetAlgorithm(Algorithm algorithm) { algorithm_ = algorithm; }
  void SetTerminateAction(TerminateAction action) { terminate_action_ = action; }
  /// @return −1 if not initialized, or if nothing is active; 0 if it failed, with the states as they were before the
  ///         failing iteration; else the iterations done
  int Optimize(int iterations);
  /// Of the last Optimize.
  const Summary& GetSummary() const { return summary_; }

  /// True if no vertex of the largest dimension is fixed or has a prior of its own of full dimension. A count, no
  /// measurement: two relative scales or an IMU are not seen.
  bool GaugeFreedom() const;
  /// The first vertex of the largest dimension, the one to be fixed; null in an empty graph.
  std::shared_ptr<Vertex> FindGauge() const;

  /// Σ blocks of the chosen part of the graph at the present states, see sparse/covariance.h (g2o's computeMarginals).
  std::vector<MatXX> ComputeMarginals(const std::vector<VertexPair>& pairs) const {
    return Covariance(graph_.Get(), selection_, CovarianceFactor::kSparse, threads_, held_).Blocks(pairs);
  }

  /// The system that is solved (sparse_solver.h), ordered and fit for the graph as it is now.
  SparseSolver& GetSolver();

 private:
  bool Initialize(Selection selection);

  GraphPointer graph_;
  int threads_;
  std::unique_ptr<SparseSolver> solver_;
  Selection selection_;
  std::vector<HeldDirections> held_;
  std::vector<std::shared_ptr<Edge>> active_edges_;
  std::vector<std::shared_ptr<Vertex>> index_mapping_;
  Algorithm algorithm_ = Algorithm::kLevenbergMarquardt;
  std::function<bool(const IterationInfo&)> terminate_action_;
  Summary summary_;
};

}  // namespace ch5
