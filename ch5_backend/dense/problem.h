#pragma once
/// The dense solver: the course's `Problem` with the course's names, on ordinary Eigen matrices. Small and plain, it is
/// what the sparse solver's results are compared with.
///
/// Three functions are the homework (chapter 5, stages 1.1, 1.2 and 2) and live in solutions/problem.cc or
/// ch5_homework/problem.cc; all else is in problem_core.cc.

#include <map>

#include "ch5_backend/graph/ordering.h"
#include "ch5_backend/solve/minimizer.h"
#include "ch5_backend/solve/normal_equations.h"

namespace ch5 {

/// How the reduced system is solved: LDLᵀ, or conjugate gradients.
enum class LinearSolver { kLdlt, kPcg };

/// What TestMarginalize returns: the system with the marginalized variable moved to the end, and what remains.
struct MarginalizeResult {
  MatXX H_moved;  ///< n×n, order of variables: the remaining ones, then the marginalized one
  VecX b_moved;   ///< n×1
  MatXX H_prior;  ///< (n−dim)×(n−dim):  H_rr − H_rm H_mm⁻¹ H_mr
  VecX b_prior;   ///< (n−dim)×1:  b_r − H_rm H_mm⁻¹ b_m
};

class Problem : public NormalEquations {
 public:
  /// The graph must outlive the problem.
  explicit Problem(Graph* graph, LinearSolver linear_solver = LinearSolver::kLdlt);
  ~Problem() override;

  /// Minimizes with Levenberg-Marquardt unless the options say otherwise.
  Summary Solve(const SolveOptions& options = {}) { return Minimize(this, options); }

  /// @throws GraphError if an edge ties two free landmarks: H_mm would not be block diagonal
  void SetOrdering() override;
  void CheckOrdering() const override { ch5::CheckOrdering(ordering_); }
  int Size() const override { return ordering_.Size(); }
  double Cost() override { return ch5::Cost(ordering_.edges); }
  double ComputeChi() { return Cost(); }  ///< the course's name

  /// Stage 1.1.  H = Σ JᵀW_ρJ,  b = −Σ ρ'JᵀWr  over all edges; fixed vertices have no columns.
  void MakeHessian() override;

  /// Stage 1.2.  Solves (H + λD) Δx = b by the Schur complement of the landmarks.
  bool SolveLinearSystem(double lambda, VecX* delta_x) override;

  /// Stage 2.  Marginalizes the variables [idx, idx + dim) out of H Δx = b: moves them behind the others, which keep
  /// their order, and takes the Schur complement.
  /// @param H_marg  n×n symmetric;  @param b_marg  n×1;  0 ≤ idx, 0 < dim, idx + dim ≤ n
  static MarginalizeResult TestMarginalize(MatXX H_marg, VecX b_marg, int idx, int dim);

  const VecX& RightHandSide() const override { return b_; }
  VecX HessianDiagonal() const override { return Hessian_.diagonal(); }
  VecX MultiplyHessian(const VecX& v) const override { return Hessian_ * v; }
  void UpdateStates(const VecX& delta_x) override { Update(ordering_, delta_x); }
  void RollbackStates() override { RollBack(ordering_); }
  double StateNorm() const override { return ch5::StateNorm(ordering_); }
  std::string WhatIsNotFinite() override { return ch5::WhatIsNotFinite(ordering_.edges); }

  /// H of the last MakeHessian; its b is RightHandSide().
  const MatXX& Hessian() const { return Hessian_; }
  /// H_pp − H_pm H_mm⁻¹ H_mp of the last SolveLinearSystem, damped.
  const MatXX& SchurComplement() const { return H_pp_schur_; }
  const Ordering& GetOrdering() const { return ordering_; }

 protected:
  /// H + λD, ready for the Schur complement: the landmarks' block is damped before it is inverted.
  const MatXX& DampedHessian(double lambda);
  /// H_pp_schur_ Δx_p = b_pp_schur_ by the solver chosen at construction.
  /// @throws std::logic_error if their sizes are not the poses'
  bool SolvePoses(VecX* delta_x_pp) const;
  /// A x = b of a symmetric dense system by the same solver.
  bool SolveDense(const MatXX& A, const VecX& b, VecX* x) const;

  GraphPointer graph_;
  LinearSolver linear_solver_;
  Ordering ordering_;

  MatXX Hessian_;               // n×n, n = ordering_poses_ + ordering_landmarks_
  VecX b_;                      // n×1
  int ordering_poses_ = 0;      // dimension of all free poses, the first rows of H
  int ordering_landmarks_ = 0;  // dimension of all free landmarks, the last rows of H
  // Free landmarks by vertex id.
  std::map<int, std::shared_ptr<Vertex>> idx_landmark_vertices_;
  MatXX H_damped_;  // of DampedHessian, a member so that its memory is taken once
  MatXX H_pp_schur_;
  VecX b_pp_schur_;
};

}  // namespace ch5
