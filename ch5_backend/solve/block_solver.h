#pragma once
/// The fast room: the normal equations in fixed-size blocks, landmarks eliminated one by one (g2o's BlockSolver).
///
///      ┌───────┬──────┐        H_pp  sparse blocks: poses that share an edge
///      │ H_pp  │ H_pm │        H_pm  a block for each slot (landmark, pose that sees it)
///      ├───────┼──────┤        H_mm  block diagonal, so that its inverse is cheap
///      │ H_pmᵀ │ H_mm │
///      └───────┴──────┘        S = H_pp − Σ_l  H_pl H_ll⁻¹ H_plᵀ
///
/// The structure is found once per ordering; an iteration takes no memory. Each block is the work of one task and is
/// summed in the order of the graph, so the result is the same to the bit for any number of threads.
/// Same meaning as the dense room (solve/problem.h) in everything: λ, damping, robust weights, order of the unknowns.

#include <memory>

#include "ch5_backend/math/parallel.h"
#include "ch5_backend/solve/block_structure.h"
#include "ch5_backend/solve/normal_equations.h"
#include "ch5_backend/solve/reduced_solver.h"

namespace ch5 {

/// What does not depend on the blocks' sizes: states, costs, threads.
class BlockSolverBase : public NormalEquations {
 public:
  /// The graph must outlive the solver.
  BlockSolverBase(Graph* graph, int threads);

  /// g2o's buildStructure: numbers the unknowns, sorts the edges by landmark, finds the patterns and takes all memory.
  /// @throws GraphError if an edge ties two free landmarks, or a vertex does not have the solver's dimension
  void SetOrdering() override;
  int Size() const override { return structure_.Size(); }
  double ComputeChi() override;
  void UpdateStates(const VecX& delta_x) override;
  void RollbackStates() override;
  double StateNorm() const override;

  const VecX& RightHandSide() const override { return b_; }
  VecX HessianDiagonal() const override;

  /// H with all its zeros: for tests and small problems.
  MatXX DenseHessian() const;
  /// The reduced system of the last SolveLinearSystem.
  MatXX SchurComplement() const { return S_.Dense(); }
  const BlockStructure& Structure() const { return structure_; }

  /// Chosen by MakeCholesky's rule unless set; takes effect at the next SetOrdering.
  void SetReducedSolver(std::unique_ptr<ReducedSolver> solver) { reduced_solver_ = std::move(solver); }

 protected:
  virtual int PoseDimension() const = 0;
  virtual int LandmarkDimension() const = 0;

  Graph* graph_;
  mutable ThreadPool pool_;
  mutable std::vector<double> parts_;  // of sums
  BlockStructure structure_;
  std::unique_ptr<ReducedSolver> reduced_solver_;
  bool linearize_in_parallel_ = true;

  std::vector<double> linear_;  // the edges' linear parts
  SymmetricBlockMatrix H_pp_, S_;
  std::vector<double> H_pm_;  // a block per slot
  std::vector<double> H_mm_, H_mm_inverse_, H_mm_factor_;
  VecX b_, b_schur_, pose_scale_, delta_poses_;
  VecX H_mm_inverse_b_;  // rows of the landmarks only

 private:
  void CheckDimensions() const;
  void FindNumericJacobians();
};

/// @tparam PoseDim, LandmarkDim  the vertices' local dimensions (a pose: 6), or Eigen::Dynamic: any, also mixed
template <int PoseDim, int LandmarkDim>
class BlockSolver : public BlockSolverBase {
 public:
  explicit BlockSolver(Graph* graph, int threads = 1) : BlockSolverBase(graph, threads) { this->SetOrdering(); }

  /// g2o's buildSystem.
  void MakeHessian() override;
  bool SolveLinearSystem(double lambda, VecX* delta_x) override;
  VecX MultiplyHessian(const VecX& v) const override;

 protected:
  int PoseDimension() const override { return PoseDim; }
  int LandmarkDimension() const override { return LandmarkDim; }

 private:
  void LinearizeLandmark(int l);
  void SumColumn(int j);
  bool InvertLandmarks(double lambda);
  void SchurColumn(int j, double lambda);
  void SolveLandmark(int l, VecX* delta_x) const;
};

extern template class BlockSolver<6, 1>;
extern template class BlockSolver<6, 3>;
extern template class BlockSolver<9, 3>;
extern template class BlockSolver<Eigen::Dynamic, Eigen::Dynamic>;

}  // namespace ch5
