#pragma once
/// The interface between the algorithms (Gauss-Newton, Levenberg-Marquardt, Dogleg) and the systems they solve.
///
///   min ½ Σ ρ(rᵀWr),   H = Σ JᵀW_ρJ,   b = −Σ ρ'JᵀWr,   (H + λD) Δx = b,   x ← x ⊞ Δx
///
/// Behind it: Problem (dense, the homework, the oracle), SparseSolver (small blocks, landmarks eliminated one by one) and
/// PlainBlockSolver (the homework of stage 7).

#include <algorithm>
#include <string>

#include "ch5_backend/math/eigen_types.h"

namespace ch5 {

/// D in H + λD. Identity is Levenberg's and the course's; diagonal is Marquardt's, independent of the units of x.
enum class Damping { kIdentity, kDiagonal };

/// One entry of D: 1, or H_ii kept within [1e-6, 1e32] so that a flat direction is damped too.
inline double DampingEntry(Damping damping, double H_ii) {
  return damping == Damping::kIdentity ? 1.0 : std::clamp(H_ii, 1e-6, 1e32);
}

class NormalEquations {
 public:
  virtual ~NormalEquations() = default;

  /// Numbers the unknowns; call it again after the graph or a fixed flag has changed.
  virtual void SetOrdering() = 0;
  /// Asked after a callback.  @throws GraphError if the graph is no longer the one that SetOrdering has numbered
  virtual void CheckOrdering() const {}
  /// Number of unknowns n, the size of Δx and b.
  virtual int Size() const = 0;

  /// ½ Σ ρ(rᵀWr) at the current states; may be infinite or NaN at states that make no sense.
  virtual double Cost() = 0;
  /// Linearizes at the current states; called once per accepted step, unless the next function has done it.
  virtual void MakeHessian() = 0;
  /// Both, for a system that computes them in one pass. Minimize asks for it at states that it expects to keep; if it does
  /// not, it rolls back and calls MakeHessian once more.
  /// @return false if the system has no such pass; nothing has been done then
  virtual bool MakeHessianAndCost(double* /*cost*/) { return false; }
  /// Solves (H + λD) Δx = b; called for several λ with the same H.
  /// @return false if the damped system is not positive definite; `delta_x` is then not to be used
  virtual bool SolveLinearSystem(double lambda, VecX* delta_x) = 0;

  /// The present linearization: b, diag(H), H v.
  virtual const VecX& RightHandSide() const = 0;
  virtual VecX HessianDiagonal() const = 0;
  virtual VecX MultiplyHessian(const VecX& v) const = 0;

  /// x ← x ⊞ Δx, remembering x; RollbackStates undoes the last update to the bit.
  virtual void UpdateStates(const VecX& delta_x) = 0;
  virtual void RollbackStates() = 0;
  /// ‖x‖ over the free vertices, which a step is measured against.
  virtual double StateNorm() const = 0;

  /// Moves each landmark by itself to a lower cost, the poses held, in at most so many steps; RollbackStates undoes this too.
  /// @return by how much the cost fell; 0 from a system that has no such steps
  virtual double RefineLandmarks(int /*steps*/) { return 0.0; }

  /// The decrease that the quadratic model predicts, m(0) − m(Δx) = bᵀΔx − ½ ΔxᵀHΔx: valid for any Δx, so LM's damped
  /// steps and Dogleg's are judged by the same measure.
  virtual double ModelCostChange(const VecX& delta_x) const {
    return RightHandSide().dot(delta_x) - 0.5 * delta_x.dot(MultiplyHessian(delta_x));
  }

  /// Steps that were inexact on purpose are exact from now on; Minimize asks for it near the minimum.
  /// @return false if they are already, or if that would take too long; nothing has changed then
  virtual bool SolveExactly() { return false; }

  /// Whether Dogleg leads to a minimum sooner than damped steps: where a step of Gauss and Newton is good far from it, another
  /// trial would cost a factorization, and the directions that damping holds are those that have far to go.
  virtual bool SuitsDogleg() const { return false; }

  /// What to name where the cost or b is not finite, such as an edge; empty if there is nothing.
  virtual std::string WhatIsNotFinite() { return ""; }

  Damping GetDamping() const { return damping_; }
  void SetDamping(Damping damping) { damping_ = damping; }

  double DampingEntry(double H_ii) const { return ch5::DampingEntry(damping_, H_ii); }

 private:
  Damping damping_ = Damping::kIdentity;
};

}  // namespace ch5
