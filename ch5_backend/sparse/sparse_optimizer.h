#pragma once
/// The fast room's front: looks at a graph and takes the BlockSolver that is made for its blocks.
///
///   SparseOptimizer optimizer(&graph, /*threads=*/2);
///   optimizer.SetDamping(Damping::kDiagonal);
///   const Summary summary = optimizer.Solve(options);
///
/// or in g2o's words, here a round that puts the outliers of the first one aside:
///
///   optimizer.SetReducedSolver(ReducedSolverType::kSparseCholesky);  // step 1, the linear solver
///   optimizer.SetAlgorithm(Algorithm::kDogleg);                      // step 3; step 2, BlockSolver<p, l>, is ours
///   optimizer.InitializeOptimization();
///   optimizer.Optimize(10);
///   for (const auto& edge : graph.Edges()) {
///     edge->ComputeResidual();
///     edge->SetLevel(edge->Chi2() > 5.991 ? 1 : 0);
///   }
///   optimizer.InitializeOptimization(/*level=*/0);
///   optimizer.Optimize(10);

#include <memory>

#include "ch5_backend/solve/minimizer.h"
#include "ch5_backend/sparse/block_solver.h"
#include "ch5_backend/sparse/covariance.h"

namespace ch5 {

class SparseOptimizer {
 public:
  /// The graph must outlive the optimiser; it may change between calls of Solve.
  explicit SparseOptimizer(Graph* graph, int threads = 1) : graph_(graph), threads_(threads) {}

  void SetDamping(Damping damping) { damping_ = damping; }
  /// Automatic unless set, and inexact where it is implicit; see reduced_solver.h.
  void SetReducedSolver(ReducedSolverType type, const IterativeOptions& options = {});
  /// The coupling of poses and landmarks in float; see BlockSolverBase::SetSinglePrecision.
  void SetSinglePrecision(bool single_precision) { single_precision_ = single_precision; }

  /// Minimises with Levenberg-Marquardt unless the options say otherwise: over the edges of level 0, or what
  /// InitializeOptimization chose.
  /// @throws GraphError if an edge ties two free landmarks
  Summary Solve(const SolveOptions& options = {});

  /// Chooses the edges of a level (all, if it is negative) whose vertices are all in the set, and numbers the vertices.
  /// An edge is active if it is chosen and has a free vertex; a vertex without active edges has no part.
  /// @return false if no edge is active
  bool InitializeOptimization(int level = 0) { return Initialize({level, true, {}}); }
  bool InitializeOptimization(std::vector<std::shared_ptr<Vertex>> vertices, int level = 0) {
    return Initialize({level, false, std::move(vertices)});
  }
  /// Of the last InitializeOptimization: the active edges in order of id, and the free vertices that they touch, poses
  /// first (g2o's indexMapping).
  const std::vector<std::shared_ptr<Edge>>& ActiveEdges() const { return active_edges_; }
  const std::vector<std::shared_ptr<Vertex>>& IndexMapping() const { return index_mapping_; }
  /// Σ rᵀWr and Σ ρ(rᵀWr) over the active edges at the present states, whose residuals are left computed.
  double ActiveChi2() const;
  double ActiveRobustChi2() const { return 2.0 * ComputeCost(active_edges_); }

  /// For Optimize. Without an action nothing but the number of iterations ends it, or that there is no lower cost.
  void SetAlgorithm(Algorithm algorithm) { algorithm_ = algorithm; }
  void SetTerminateAction(TerminateAction action) { terminate_action_ = action; }
  /// @return −1 if not initialised, or if nothing is active; 0 if it failed, with the states as they were before the
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
    return Covariance(graph_, selection_, CovarianceFactor::kSparse, threads_).Blocks(pairs);
  }

  /// The system behind the door, ordered and fit for the graph as it is now: 6/1 and 6/3 (poses with inverse depths or
  /// points), 9/3 (BAL), or any other sizes, also mixed.
  BlockSolverBase& GetSolver();

 private:
  bool Initialize(Selection selection);
  void ChooseSolver();

  Graph* graph_;
  int threads_;
  Selection selection_;
  std::vector<std::shared_ptr<Edge>> active_edges_;
  std::vector<std::shared_ptr<Vertex>> index_mapping_;
  Algorithm algorithm_ = Algorithm::kLevenbergMarquardt;
  std::function<bool(const IterationInfo&)> terminate_action_;
  Summary summary_;
  Damping damping_ = Damping::kIdentity;
  ReducedSolverType reduced_solver_ = ReducedSolverType::kAutomatic;
  IterativeOptions iterative_;
  bool single_precision_ = false;
  std::unique_ptr<BlockSolverBase> solver_;
  int pose_dim_ = 0, landmark_dim_ = 0;  // of solver_
};

}  // namespace ch5
