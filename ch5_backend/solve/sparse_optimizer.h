#pragma once
/// The fast room's front: looks at a graph and takes the BlockSolver that is made for its blocks.
///
///   SparseOptimizer optimizer(&graph, /*threads=*/2);
///   optimizer.SetDamping(Damping::kDiagonal);
///   const Summary summary = optimizer.Solve(options);

#include <memory>

#include "ch5_backend/solve/block_solver.h"
#include "ch5_backend/solve/minimizer.h"

namespace ch5 {

class SparseOptimizer {
 public:
  /// The graph must outlive the optimiser; it may change between calls of Solve.
  explicit SparseOptimizer(Graph* graph, int threads = 1) : graph_(graph), threads_(threads) {}

  void SetDamping(Damping damping) { damping_ = damping; }
  /// Automatic unless set.
  void SetReducedSolver(ReducedSolverType type) { reduced_solver_ = type; }

  /// Minimises with Levenberg-Marquardt unless the options say otherwise.
  /// @throws GraphError if an edge ties two free landmarks
  Summary Solve(const SolveOptions& options = {});

  /// The system behind the door, ordered and fit for the graph as it is now: 6/1 and 6/3 (poses with inverse depths or points),
  /// 9/3 (BAL), or any other sizes, also mixed.
  BlockSolverBase& GetSolver();

 private:
  void ChooseSolver();

  Graph* graph_;
  int threads_;
  Damping damping_ = Damping::kIdentity;
  ReducedSolverType reduced_solver_ = ReducedSolverType::kAutomatic;
  std::unique_ptr<BlockSolverBase> solver_;
  ReducedSolverType prepared_ = ReducedSolverType::kAutomatic;  // of solver_
  int pose_dim_ = 0, landmark_dim_ = 0;                         // of solver_
};

}  // namespace ch5
