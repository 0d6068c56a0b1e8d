#pragma once
/// A Bayes tree: a Cholesky factorization of normal equations that grow, of which only the part that a change touches is
/// computed again.
///
/// Eliminating a variable conditions it on its later neighbors. Variables that are eliminated together are a clique
/// p(F | S): its frontal variables F given its separator S, all of whose variables are in the clique above. A clique is a
/// front of the multifrontal method (elimination_plan.h), here with the right-hand side as its last row, so that one
/// factorization also makes y and the next message:
///
///         F     S              F     S               R_F δ_F = d_F − T δ_S,  R_F = L_11ᵀ, T = L_21ᵀ, d_F = y
///      ┌─────┬─────┐        ┌──────┬─────┐
///    F │ H   │     │      F │ L_11 │     │           U, u: what the subtree says about S, the message to the clique
///    S │ H   │ H   │  →   S │ L_21 │ U   │           above. They are kept, so that the subtree need not be visited
///      ├─────┼─────┤        ├──────┼─────┤           when that clique is eliminated again.
///    b │ bᵀ  │ bᵀ  │        │ yᵀ   │ uᵀ  │
///      └─────┴─────┘        └──────┴─────┘
///
/// A factor's change touches the clique that eliminates its first variable, and the messages from there up to the root:
/// nothing else. Update eliminates just these cliques again (in an order of their own, the newest variables last), with
/// the messages of the subtrees that hang below. Solve goes down from the root, and stops where nothing changes any more.
///
/// Source: Kaess, Johannsson, Roberts, Ila, Leonard, Dellaert, "iSAM2: incremental smoothing and mapping using the Bayes
/// tree", IJRR 2012: "incremental inference", "incremental variable ordering", "partial state updates".

#include <algorithm>
#include <map>
#include <vector>

#include "ch5_backend/linear/aligned_vector.h"
#include "ch5_backend/linear/elimination_plan.h"
#include "ch5_backend/math/eigen_types.h"

namespace ch5 {

class BayesTree {
 public:
  /// A new variable, δ = 0 until the next Solve.  @return its number, in order from 0
  int AddVariable(int dim);
  /// A new factor ½ δᵀHδ − bᵀδ; its numbers are set by ChangeFactor.
  /// @param variables  of its columns, in their order; −1 for one that is known, whose `dims` columns have no part
  /// @return its number, in order from 0
  int AddFactor(std::vector<int> variables, const std::vector<int>& dims);

  /// @return where to write the factor's numbers, before the next Update: the lower half of [−H b; bᵀ ·], column-major
  ///         (as edge_normal_equations.h has it)
  double* ChangeFactor(int factor);

  /// Eliminates again what the changes touch, with the variables of new factors last.
  /// @return −1, or a variable that is not determined: the factors' sum is singular there (or not finite). The tree is then
  ///         of no use
  int Update();

  /// δ of all variables that change by more than `threshold` (the "wildfire"), and all that have been
  /// eliminated again.  @return these, those above first
  const std::vector<int>& Solve(double threshold);

  Eigen::Map<const VecX> Delta(int variable) const { return {delta_.data() + At(offset_, variable), Dim(variable)}; }
  /// δ ← 0 where the variable's linearization point moves; all its factors are to be changed too.
  void ClearDelta(int variable) { std::fill_n(delta_.begin() + At(offset_, variable), Dim(variable), 0.0); }
  const std::vector<int>& FactorsOf(int variable) const { return At(factors_of_, variable); }
  const std::vector<int>& VariablesOf(int factor) const { return At(factors_, factor).variables; }

  /// False until the next Update for a variable that is new.
  bool HasClique(int variable) const { return At(clique_of_, variable) >= 0; }
  /// The block of H⁻¹ of one variable that has a clique, dim×dim, in time proportional to the path from its clique to the root.
  MatXX Covariance(int variable) const;

  /// How many variables the last Update has eliminated.
  int NumEliminated() const { return num_eliminated_; }
  int NumVariables() const { return static_cast<int>(clique_of_.size()); }

 private:
  struct Factor {
    std::vector<int> variables, columns;  // of its free variables
    int size;                             // of its square matrix
    AlignedVector values;
  };
  struct Clique {
    std::vector<int> variables;  // F, then S
    int num_frontal = 0;
    int pivots = 0, size = 0;  // numbers of F; rows of the square matrix, the right-hand side's included
    AlignedVector matrix;      // as above, column-major
    int parent = -1;
    std::vector<int> children;
    bool is_cut = false, is_new = false;
  };

  template <typename T>
  static const T& At(const std::vector<T>& all, int k) {
    return all[static_cast<size_t>(k)];
  }
  int Dim(int variable) const { return At(offset_, variable + 1) - At(offset_, variable); }
  void CutPathFrom(int variable);
  void CutTop(std::vector<int>* orphans);
  void NumberAffected();
  std::vector<int> FactorsWithin();
  EliminationPlan Plan(const std::vector<int>& factors, const std::vector<int>& orphans) const;
  int NewClique(const EliminationPlan& plan, const Front& front);
  void TakeMemory(size_t numbers, AlignedVector* matrix);
  void Assemble(Clique* clique, const std::vector<int>& factors);
  void AddFactor(const Factor& factor, Clique* clique) const;
  void AddMessage(const Clique& child, Clique* clique) const;
  int Eliminate(Clique* clique, const std::vector<int>& factors);
  void SolveClique(const Clique& clique, double threshold);

  std::vector<int> offset_{0};  // of each variable in δ
  std::vector<double> delta_;
  std::vector<double> min_pivot_;  // of each number in δ, of the last Update that eliminated it
  std::vector<int> clique_of_;     // the one where a variable is frontal, or −1
  std::vector<std::vector<int>> factors_of_;
  std::vector<Factor> factors_;
  std::vector<Clique> cliques_;
  std::vector<int> free_cliques_;
  std::multimap<size_t, AlignedVector> spare_;  // matrices of cut cliques, by capacity

  std::vector<int> cut_;           // cliques that the changes touch
  std::vector<int> affected_;      // their frontal variables, and new ones
  std::vector<int> observed_;      // variables of new factors
  std::vector<int> new_cliques_;   // of the last Update, children first
  std::vector<int> changed_;       // variables of the last Solve
  std::vector<int> number_;        // of a variable among the affected ones, or −1
  mutable std::vector<int> row_;   // of a variable in the clique that is at work
  VecX gathered_;                  // δ of the clique that is at work
  std::vector<char> has_changed_;  // by variable
  int num_eliminated_ = 0;
};

}  // namespace ch5
