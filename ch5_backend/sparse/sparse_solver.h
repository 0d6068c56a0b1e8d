#pragma once
/// The sparse solver: the normal equations in small blocks, landmarks eliminated one by one (g2o's BlockSolver).
///
///   Structure  ─►  Linearized            ─►  Eliminated     ─►  Step
///   what lies      H_pp, H_pl, H_ll, b       H_ll⁻¹, S, b_S     Δx, model cost change
///   where; once    linearize.h               eliminate.h        back_substitute.h
///
/// Each arrow is one file with its formula on top. Same meaning as the dense solver (dense/problem.h) in everything: λ,
/// damping, robust weights, order of the unknowns. The structure is found once per ordering; an iteration takes no memory.
/// Each task writes what is its own, and sums are added in the order of the structure, so the result is the same to the
/// bit for any number of threads.

#include <memory>
#include <optional>

#include "ch5_backend/linear/reduced_solver.h"
#include "ch5_backend/math/parallel.h"
#include "ch5_backend/solve/normal_equations.h"
#include "ch5_backend/sparse/hold_poses.h"
#include "ch5_backend/sparse/steps/back_substitute.h"
#include "ch5_backend/sparse/steps/implicit_solver.h"
#include "ch5_backend/sparse/steps/numeric_edges.h"
#include "ch5_backend/sparse/steps/refine_landmarks.h"

namespace ch5 {

class SparseSolver : public NormalEquations {
 public:
  /// The graph must outlive the solver. Nothing else may be asked before SetOrdering, which Minimize calls.
  explicit SparseSolver(Graph* graph, int threads = 1) : graph_(graph), pool_(threads) {}

  /// g2o's buildStructure: numbers the unknowns, sorts the edges by landmark, finds the patterns and takes all memory.
  /// Only numbers the unknowns where vertices, edges and selection are those of the last time.
  /// @throws GraphError if an edge ties two free landmarks
  void SetOrdering() override;
  /// The part of the graph that takes part, from the next SetOrdering on.
  void Select(Selection selection) { selection_ = std::move(selection); }
  /// Parts of vertices that stay as they are, at most one entry for a vertex; from the next MakeHessian on.
  void Hold(std::vector<HeldDirections> held) { held_ = std::move(held); }
  void CheckOrdering() const override { ch5::CheckOrdering(structure_.ordering); }
  int Size() const override { return structure_.Size(); }
  double Cost() override;
  /// g2o's buildSystem.
  void MakeHessian() override;
  bool MakeHessianAndCost(double* cost) override;
  bool SolveLinearSystem(double lambda, VecX* delta_x) override;
  void UpdateStates(const VecX& delta_x) override;
  void RollbackStates() override;
  /// Landmarks whose edges are not of a fast type (graph/fast_edge.h) stay where they are.
  double RefineLandmarks(int steps) override;
  double StateNorm() const override;
  /// The automatic choice switches from the power series to a Cholesky factorization of S until the next SetOrdering.
  bool SolveExactly() override;
  bool SuitsDogleg() const override { return structure_.NumLandmarks() == 0; }
  std::string WhatIsNotFinite() override { return ch5::WhatIsNotFinite(structure_.ordering.edges); }

  const VecX& RightHandSide() const override { return linearized_.b; }
  VecX HessianDiagonal() const override;
  VecX MultiplyHessian(const VecX& v) const override;
  /// Costs nothing for the last solution of SolveLinearSystem, and a MultiplyHessian for another step.
  double ModelCostChange(const VecX& delta_x) const override;

  /// What the last SetOrdering, MakeHessian and SolveLinearSystem have found.
  const Structure& GetStructure() const { return structure_; }
  const Linearized& GetLinearized() const { return linearized_; }
  const Eliminated& GetEliminated() const { return eliminated_; }
  /// What the last MakeHessian has held.
  const std::vector<HeldPose>& HeldPoses() const { return held_poses_; }
  /// H with all its zeros, and S of the last SolveLinearSystem (empty if it is implicit): for tests and small problems.
  MatXX DenseHessian() const;
  MatXX SchurComplement() const { return eliminated_.S.Dense(); }

  /// Automatic unless set; takes effect at the next SetOrdering. The options are for the implicit solvers.
  void SetReducedSolver(ReducedSolverType type, const IterativeOptions& options = {});
  /// One of the caller's own; S is formed for it.
  void SetReducedSolver(std::unique_ptr<ReducedSolver> solver);
  /// Products with S in the last SolveLinearSystem, if it is implicit.
  int ReducedProducts() const { return implicit_ ? implicit_->Products() : 0; }

 private:
  void PrepareImplicitSolver(ReducedSolverType type);
  void PrepareReducedSolver(ReducedSolverType type, const Lists& S_pattern);
  bool CanFactor(const Lists& S_pattern) const;
  int EdgesInBatch() const { return batches_.Active() ? structure_.num_landmark_edges : 0; }
  bool SolvePoses(const DampingRule& rule, VecX* delta_poses);

  GraphPointer graph_;
  Selection selection_;
  std::vector<HeldDirections> held_;
  std::vector<HeldPose> held_poses_;  // of this Hessian
  mutable ThreadPool pool_;

  ReducedSolverType reduced_type_ = ReducedSolverType::kAutomatic;
  IterativeOptions iterative_;
  std::unique_ptr<ReducedSolver> reduced_solver_;  // this one, or
  std::optional<ImplicitSolver> implicit_;         // that one

  bool is_ordered_ = false;  // all below fits the structure's ordering
  Structure structure_;
  Ordering used_ordering_;      // empty; its memory serves the next one
  NumericEdges numeric_edges_;  // if there are several threads
  LandmarkEdgeBatches batches_;
  Linearized linearized_;
  SchurGroups groups_;
  Eliminated eliminated_;
  VecX delta_poses_;
  Step step_;              // the last solution
  bool has_step_ = false;  // of this Hessian
  LandmarkRefinement refinement_;
  std::vector<double> partial_sums_;
};

}  // namespace ch5
