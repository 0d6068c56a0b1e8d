#pragma once
/// The right formulas of all stages, as the handout writes them; NAME.cc has those of the student's NAME.cc. A student's file
/// must never reach them.

#include <vector>

#include "ch5_backend/graph/ordering.h"
#include "ch5_backend/math/eigen_types.h"
#include "ch5_backend/solve/normal_equations.h"
#include "ch5_homework/judge/formula/slips.h"
#include "ch5_homework/judge/oracle.h"

namespace ch5::homework::right {

using namespace formula;  // in whose words all of it is written

/// The rows of each pose and landmark.
std::vector<Part> PartsOf(const Ordering& ordering, bool numbered = false);

/// The rows of each vertex.
std::vector<int> SizesOf(const std::vector<std::shared_ptr<Vertex>>& vertices);

/// H + λD.
MatXX Damped(const MatXX& H, double lambda, Damping damping);
VecX Solve(const MatXX& A, const VecX& b);

/// "b_" changed, in place of "b_schur_".
Text ChangedInPlace(const char* it, const char* meant);
/// "Δx of the scene, λ = 0.5, D = diag(H)"
Text With(const Text& quantity, const Text& scene, double lambda, Damping damping);

/// 1.2: SolveLinearSystem.
struct SchurSolve {
  Formula S, b_S, delta_x;

  /// @param got_b_S  if it is right, so is the H_pm that is read
  SchurSolve(const System& system, const Ordering& ordering, double lambda, Damping damping, const VecX& got_b_S);
};

/// Which row of the given one stands at each place.
using Order = std::vector<int>;

/// 2: variables idx … idx + dim − 1 go behind all others, in H and b.
struct Moved {
  Order order;
  Formula H, b;

  /// @param exchanging  they change places with the last ones; otherwise the others keep their order
  Moved(const System& given, int idx, int dim, bool exchanging);
};

/// 2: the prior, once the rows that go are the last `dim` ones.
struct Prior {
  Formula H, b;

  /// @param given  before the move
  Prior(const System& moved, const System& given, int dim);
};

/// 5.1: InsertBlock, by which H and b₀ get `dim` rows of zeros from row `idx` on.
struct OpenedTerm {
  Formula H, b;

  OpenedTerm(const MatXX& H, const VecX& b0, int idx, int dim);
};

/// 5.2: what goes has V and b_b, W beside what stays.
struct SchurUpdate {
  Formula U, b_a;

  SchurUpdate(const MatXX& V, const MatXX& W, const VecX& b_b, const MatXX& U, const VecX& b_a);
};

/// 5.3: J and e₀ from P⁻¹HP⁻¹ = U S Uᵀ, as JᵀJ = H and Jᵀe₀ = −b₀ in units of the diagonal, which are all the same.
struct SquareRoot {
  VecX p;
  Formula JtJ, Jte0;

  SquareRoot(const MatXX& H, const VecX& b0);
};

/// 5.4
Formula Residual(const MatXX& J, const VecX& e0, const VecX& delta_chi);

/// 6b: the first rows of all blocks, in order of id, then m and n: how often each block is counted there, times the sizes.
struct Numbering {
  Formula rows;

  /// @param parameters  how many numbers a block has, which may be more than its size
  Numbering(const VecX& sizes, const VecX& parameters, const std::vector<bool>& dropped);
};

/// 6d: what is left of A and b once the first m rows are dropped.
struct KeptRows {
  Formula A_r, b_r;

  KeptRows(const MatXX& A, const VecX& b, int m);
};

/// 6e: J and r₀ from A_r = V S Vᵀ, as JᵀJ = A_r and Jᵀr₀ = b_r.
struct Factored {
  VecX eigenvalues;  ///< S, and 0 where they count as zero
  VecX r0;
  Formula JtJ, Jtr0;

  Factored(const MatXX& A, const VecX& b);
};

/// 7d, 7e: PlainBlockSolver::Solve, dense, and pose by pose and landmark by landmark.
struct BlockSolve {
  Formula S, b_S, delta_x;

  BlockSolve(const System& system, const Ordering& ordering, double lambda, Damping damping);
};

}  // namespace ch5::homework::right
