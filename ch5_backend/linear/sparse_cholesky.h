#pragma once
/// Sparse Cholesky A = L Lᵀ of a symmetric block matrix, by dense fronts (the multifrontal method).
///
///   for each front, children first:
///     gather      its columns of A and of the children's U
///     factor      its pivots:  L_11, L_21          (dense, see math/dense_kernels.h)
///     update      U = −L_21 L_21ᵀ + the rest of the children's U
///
/// See elimination_plan.h for the picture. Analyze once per pattern; Factorize and Solve allocate no memory.

#include <vector>

#include "ch5_backend/linear/elimination_plan.h"
#include "ch5_backend/linear/row_run.h"
#include "ch5_backend/math/parallel.h"

namespace ch5 {

class SparseCholesky {
 public:
  /// Takes the pattern of A and the plan for it, and allocates all memory that the rest needs.
  /// @param pool  shares Factorize's work; null: the calling thread alone. Any number of threads gives the same bits.
  void Analyze(const SymmetricBlockMatrix& A, EliminationPlan plan, ThreadPool* pool);
  void Analyze(const SymmetricBlockMatrix& A, ThreadPool* pool = nullptr) { Analyze(A, PlanElimination(A), pool); }

  /// @param A  the pattern is that of Analyze
  /// @param min_pivot  Size() numbers, in A's order: the square of a diagonal entry of L must exceed its own
  /// @return false if A is not positive definite by that measure; there is then no L
  bool Factorize(const SymmetricBlockMatrix& A, const VecX& min_pivot);

  /// x = A⁻¹ b with the last factorization, which must have succeeded.
  void Solve(const VecX& b, VecX* x);

  const EliminationPlan& Plan() const { return plan_; }
  /// [L_11; L_21] of front f in the last factorization; the numbers above the diagonal of L_11 have no meaning.
  Eigen::Map<const MatXX, 0, Eigen::OuterStride<>> Columns(int f) const {
    const int pivots = plan_.fronts[f].pivots, rows = pivots + plan_.fronts[f].rows_below;
    return {L_.data() + places_[f].columns, rows, pivots, Eigen::OuterStride<>(rows)};
  }

 private:
  /// A block of A and where it goes in a front's columns of L.
  struct Copy {
    int block, dim_i, dim_j;  // of A: dim_i×dim_j
    ptrdiff_t target;
    bool transposed;
  };
  /// Where a front is stored. Its pivot columns have pivots + rows_below rows, U is rows_below square.
  struct FrontMemory {
    ptrdiff_t columns, update;
    int copies_begin, copies_end;
    int runs_begin, runs_below, runs_end;  // from runs_below on they are below the parent's pivots
  };

  void PlaceColumns();
  void PlanGathering(const SymmetricBlockMatrix& A);
  void PlanRuns(int child, int parent_pivots, const Array<int>& row_of);
  void PlanTasks();
  void PlaceUpdates();
  bool FactorFront(const SymmetricBlockMatrix& A, int f, ThreadPool* pool);
  void CopyBlocks(const SymmetricBlockMatrix& A, const FrontMemory& place, ptrdiff_t m);
  void AddToColumns(int child, int parent);
  void AddToUpdate(int child, int parent);
  void AddRuns(int child, int begin, int end, double* target, ptrdiff_t ld, ptrdiff_t first);

  EliminationPlan plan_;
  ThreadPool* pool_ = nullptr;
  Array<FrontMemory> places_;
  Lists children_;  // of each front
  Array<Copy> copies_;
  Array<RowRun> runs_;
  Lists tasks_;  // fronts that one thread works through, children first; the last waits for all
  AlignedVector L_, updates_;
  Array<int> permutation_;                  // number i in elimination order is number permutation_[i] of A
  AlignedVector min_pivot_, x_, gathered_;  // the first two in elimination order; the rows below a front
};

}  // namespace ch5
