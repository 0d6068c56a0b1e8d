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
/// Same meaning as the dense room (dense/problem.h) in everything: λ, damping, robust weights, order of the unknowns.

#include <memory>

#include "ch5_backend/linear/reduced_solver.h"
#include "ch5_backend/math/parallel.h"
#include "ch5_backend/solve/normal_equations.h"
#include "ch5_backend/sparse/block_passes.h"
#include "ch5_backend/sparse/implicit_solver.h"
#include "ch5_backend/sparse/schur_eliminator.h"

namespace ch5 {

class BlockSolverBase : public NormalEquations {
 public:
  /// The graph must outlive the solver. Nothing else may be asked before SetOrdering, which Minimize calls.
  /// @param pose_dim, landmark_dim  the vertices' local dimensions (a pose: 6), or Eigen::Dynamic: any, also mixed
  BlockSolverBase(Graph* graph, int pose_dim, int landmark_dim, int threads);

  /// g2o's buildStructure: numbers the unknowns, sorts the edges by landmark, finds the patterns and takes all memory.
  /// Does nothing but number the unknowns where vertices, edges and selection are those of the last time.
  /// @throws GraphError if an edge ties two free landmarks, or a vertex does not have the solver's dimension
  void SetOrdering() override;
  /// The part of the graph that takes part, from the next SetOrdering on.
  void Select(Selection selection) { selection_ = std::move(selection); }
  int Size() const override { return system_.structure.Size(); }
  double ComputeChi() override;
  /// g2o's buildSystem.
  void MakeHessian() override;
  bool SolveLinearSystem(double lambda, VecX* delta_x) override;
  void UpdateStates(const VecX& delta_x) override;
  void RollbackStates() override;
  double StateNorm() const override;

  const VecX& RightHandSide() const override { return system_.b; }
  VecX HessianDiagonal() const override;
  VecX MultiplyHessian(const VecX& v) const override;
  /// Costs nothing for the last solution of SolveLinearSystem, and a MultiplyHessian for another step.
  double PredictedDecrease(const VecX& delta_x) const override;

  /// H with all its zeros: for tests and small problems.
  MatXX DenseHessian() const;
  /// The reduced system of the last SolveLinearSystem; empty if the reduced solver is implicit.
  MatXX SchurComplement() const { return system_.S.Dense(); }
  const BlockStructure& Structure() const { return system_.structure; }
  /// All numbers of the last MakeHessian and SolveLinearSystem.
  const BlockSystem& System() const { return system_; }

  /// Automatic unless set; takes effect at the next SetOrdering. The options are for the implicit solvers.
  void SetReducedSolver(ReducedSolverType type, const IterativeOptions& options = {});
  /// One of the caller's own; S is formed for it.
  void SetReducedSolver(std::unique_ptr<ReducedSolver> solver);
  /// H_pm in float, the largest part of the memory, where all blocks have sizes with code of their own and S is formed;
  /// all else, b among it, stays in double, and so does the optimum. Takes effect at the next SetOrdering.
  void SetSinglePrecision(bool single_precision);
  /// What the rule chose, or the caller set.
  bool IsImplicit() const { return implicit_ != nullptr; }
  /// Products with S in the last SolveLinearSystem, if it is implicit.
  int ReducedProducts() const { return implicit_ ? implicit_->Products() : 0; }

 private:
  void CheckDimensions() const;
  ReducedSolverType ReducedType() const;
  void PrepareReducedSolver();
  bool SolveReduced(const DampingRule& rule);
  void TakeSums();
  void ChoosePasses();
  void PackEdges();
  void FindNumericJacobians();
  int NumLandmarks() const { return static_cast<int>(system_.structure.landmarks.size()); }
  int NumPoses() const { return static_cast<int>(system_.structure.poses.size()); }

  Graph* graph_;
  Selection selection_;
  int pose_dim_, landmark_dim_;
  const BlockPasses* passes_ = nullptr;
  TakeSchurGroup take_group_ = nullptr;
  SchurEliminator schur_;
  mutable ThreadPool pool_;
  mutable std::vector<double> parts_;  // of sums
  ThreadPool one_thread_;
  ThreadPool* linearizing_pool_ = &pool_;
  ReducedSolverType reduced_type_ = ReducedSolverType::kAutomatic;
  IterativeOptions iterative_;
  bool single_precision_ = false;                  // wanted
  std::unique_ptr<ReducedSolver> reduced_solver_;  // this one, or
  std::unique_ptr<ImplicitSolver> implicit_;       // that one
  BlockSystem system_;
  bool ordered_ = false;  // system_ fits its ordering
  VecX delta_poses_, H_delta_poses_;
  VecX solution_;  // the last Δx of this Hessian
  bool has_solution_ = false;
  double solution_decrease_ = 0.0;  // what the model promises for it
};

/// The solver for poses and landmarks of these local dimensions. 6/1, 6/3 and 9/3 have code of their own; all others
/// share one for any sizes.
template <int PoseDim, int LandmarkDim>
class BlockSolver : public BlockSolverBase {
 public:
  explicit BlockSolver(Graph* graph, int threads = 1) : BlockSolverBase(graph, PoseDim, LandmarkDim, threads) {
    this->SetOrdering();
  }
};

}  // namespace ch5
