#include "ch5_backend/linear/bayes_tree.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "ch5_backend/linear/pivot_rule.h"
#include "ch5_backend/linear/row_run.h"
#include "ch5_backend/math/dense_kernels.h"
#include "ch5_backend/math/vector_kernels.h"

namespace ch5 {
namespace {

void SortAndDropRepeated(std::vector<int>* numbers) {
  std::sort(numbers->begin(), numbers->end());
  numbers->erase(std::unique(numbers->begin(), numbers->end()), numbers->end());
}

}  // namespace

// ---- Variables and factors -------------------------------------------------------------------------------------

int BayesTree::AddVariable(int dim) {
  offset_.push_back(offset_.back() + dim);
  delta_.resize(offset_.back(), 0.0);
  min_pivot_.resize(offset_.back());
  clique_of_.push_back(-1);
  factors_of_.emplace_back();
  number_.push_back(-1);
  row_.push_back(-1);
  has_changed_.push_back(false);
  return NumVariables() - 1;
}

int BayesTree::AddFactor(std::vector<int> variables, const std::vector<int>& dims) {
  const int number = static_cast<int>(factors_.size());
  Factor factor;
  int column = 0;
  for (size_t k = 0; k < variables.size(); column += dims[k++]) {
    if (variables[k] < 0) continue;
    factor.variables.push_back(variables[k]);
    factor.columns.push_back(column);
    factors_of_[variables[k]].push_back(number);
    observed_.push_back(variables[k]);
  }
  factor.size = column + 1;
  SetZeros(factor.size * factor.size, &factor.values);
  factors_.push_back(std::move(factor));
  return number;
}

double* BayesTree::ChangeFactor(int factor) {
  for (const int variable : factors_[factor].variables) CutPathFrom(variable);
  return factors_[factor].values.data();
}

// ---- Update: which part of the tree is eliminated again -----------------------------------------------------------

// The clique of a variable and all above.  Kaess (2012), incremental inference
void BayesTree::CutPathFrom(int variable) {
  if (clique_of_[variable] < 0 && number_[variable] < 0) {
    number_[variable] = 0;
    affected_.push_back(variable);
  }
  for (int c = clique_of_[variable]; c >= 0 && !cliques_[c].is_cut; c = cliques_[c].parent) {
    cliques_[c].is_cut = true;
    cut_.push_back(c);
  }
}

// Takes the cut cliques out of the tree. Orphans: the subtrees that hung below them.
void BayesTree::CutTop(std::vector<int>* orphans) {
  for (const int c : cut_) {
    Clique& clique = cliques_[c];
    affected_.insert(affected_.end(), clique.variables.begin(), clique.variables.begin() + clique.num_frontal);
    for (const int child : clique.children) {
      if (!cliques_[child].is_cut) orphans->push_back(child);
    }
  }
  for (const int c : cut_) cliques_[c].is_cut = false;
  for (const int c : cut_) spare_.emplace(cliques_[c].matrix.capacity(), std::move(cliques_[c].matrix));
  if (spare_.size() > cliques_.size()) spare_.clear();
  free_cliques_.insert(free_cliques_.end(), cut_.begin(), cut_.end());
  cut_.clear();
  std::sort(orphans->begin(), orphans->end());
}

// The variables of new factors first, which Plan puts last; then the newer before the older.
void BayesTree::NumberAffected() {
  SortAndDropRepeated(&observed_);
  const auto rank = [&](int variable) {
    return std::pair(!std::binary_search(observed_.begin(), observed_.end(), variable), -variable);
  };
  std::sort(affected_.begin(), affected_.end(), [&](int a, int b) { return rank(a) < rank(b); });
  for (size_t k = 0; k < affected_.size(); ++k) number_[affected_[k]] = static_cast<int>(k);
}

// The factors all of whose variables are affected; those of others are in the messages of orphans.
// min_pivot_ gets, for the affected variables, what their pivots must exceed (pivot_rule.h).
std::vector<int> BayesTree::FactorsWithin() {
  std::vector<int> within;
  const double rounding = PivotRounding(static_cast<int>(delta_.size()));
  for (const int variable : affected_) {
    std::fill_n(min_pivot_.begin() + offset_[variable], Dim(variable), 0.0);
    for (const int f : factors_of_[variable]) {
      const Factor& factor = factors_[f];
      bool is_within = true;
      for (size_t k = 0; k < factor.variables.size(); ++k) {
        is_within = is_within && number_[factor.variables[k]] >= 0;
        if (factor.variables[k] != variable) continue;
        for (int i = 0; i < Dim(variable); ++i) {
          min_pivot_[offset_[variable] + i] -= rounding * factor.values[(factor.columns[k] + i) * (factor.size + 1)];
        }
      }
      if (is_within && factor.variables[0] == variable) within.push_back(f);
    }
  }
  return within;
}

EliminationPlan BayesTree::Plan(const std::vector<int>& factors, const std::vector<int>& orphans) const {
  std::vector<std::vector<int>> neighbors(affected_.size());
  const auto connect = [&](const std::vector<int>& variables, size_t begin) {
    for (size_t i = begin; i < variables.size(); ++i) {
      for (size_t j = begin; j < variables.size(); ++j) {
        if (i != j) neighbors[number_[variables[i]]].push_back(number_[variables[j]]);
      }
    }
  };
  for (const int f : factors) connect(factors_[f].variables, 0);
  for (const int c : orphans) connect(cliques_[c].variables, cliques_[c].num_frontal);
  for (auto& list : neighbors) SortAndDropRepeated(&list);
  Array<int> dims;
  for (const int variable : affected_) dims.push_back(Dim(variable));
  const size_t observed = observed_.size();  // where that is all or none, the newest alone
  const size_t last = observed > 0 && observed < affected_.size() ? observed : 1;
  return PlanElimination(dims, neighbors, static_cast<int>(last));
}

int BayesTree::NewClique(const EliminationPlan& plan, const Front& front) {
  int c = static_cast<int>(cliques_.size());
  if (free_cliques_.empty()) {
    cliques_.emplace_back();
  } else {
    c = free_cliques_.back();
    free_cliques_.pop_back();
  }
  Clique& clique = cliques_[c] = Clique();
  const auto variable_of = [&](int block) { return affected_[plan.order[block]]; };
  for (int k = front.first; k < front.last; ++k) {
    clique.variables.push_back(variable_of(k));
    clique_of_[variable_of(k)] = c;
  }
  for (const int k : front.below) clique.variables.push_back(variable_of(k));
  clique.num_frontal = front.last - front.first;
  clique.pivots = front.pivots;
  clique.size = front.pivots + front.rows_below + 1;
  clique.is_new = true;
  return c;
}

// The affected part becomes a factor graph again, is ordered, eliminated, and takes the orphans back.  Kaess (2012),
// incremental inference and incremental variable ordering
int BayesTree::Update() {
  std::vector<int> orphans;
  CutTop(&orphans);
  NumberAffected();
  const std::vector<int> factors = FactorsWithin();
  const EliminationPlan plan = Plan(factors, orphans);
  const Array<int> front_of = plan.FrontOfEachBlock();
  const auto front_of_first = [&](const std::vector<int>& variables, size_t begin) {
    int first = plan.position[number_[variables[begin]]];
    for (size_t k = begin; k < variables.size(); ++k) first = std::min(first, plan.position[number_[variables[k]]]);
    return front_of[first];
  };
  new_cliques_.clear();
  for (const Front& front : plan.fronts) new_cliques_.push_back(NewClique(plan, front));
  const auto hang = [&](int child, int front) {
    cliques_[child].parent = new_cliques_[front];
    cliques_[new_cliques_[front]].children.push_back(child);
  };
  for (size_t f = 0; f < plan.fronts.size(); ++f) {
    if (plan.fronts[f].parent >= 0) hang(new_cliques_[f], plan.fronts[f].parent);
  }
  for (const int c : orphans) hang(c, front_of_first(cliques_[c].variables, cliques_[c].num_frontal));
  std::vector<std::vector<int>> factors_of_front(plan.fronts.size());
  for (const int f : factors) factors_of_front[front_of_first(factors_[f].variables, 0)].push_back(f);

  int undetermined = -1;
  for (size_t f = 0; f < new_cliques_.size() && undetermined < 0; ++f) {
    undetermined = Eliminate(&cliques_[new_cliques_[f]], factors_of_front[f]);
  }
  for (const int variable : affected_) number_[variable] = -1;
  num_eliminated_ = static_cast<int>(affected_.size());
  observed_.clear();
  affected_.clear();
  return undetermined;
}

// ---- Update: a clique ------------------------------------------------------------------------------------------

// Of a clique that was cut, if there is one of about this size: the first touch of new memory costs more than its use.
void BayesTree::TakeMemory(size_t numbers, AlignedVector* matrix) {
  const auto found = spare_.lower_bound(numbers);
  if (found != spare_.end() && found->first < 4 * numbers) {
    *matrix = std::move(found->second);
    spare_.erase(found);
  } else {
    matrix->reserve(numbers + numbers / 2);
  }
}

// The sum of its factors and of the messages from below.
void BayesTree::Assemble(Clique* clique, const std::vector<int>& factors) {
  const size_t numbers = static_cast<size_t>(clique->size) * clique->size + kernels::kOverread;
  if (clique->matrix.capacity() < numbers) TakeMemory(numbers, &clique->matrix);
  SetZeros(numbers, &clique->matrix);
  int row = 0;
  for (const int variable : clique->variables) {
    row_[variable] = row;
    row += Dim(variable);
  }
  for (const int f : factors) AddFactor(factors_[f], clique);
  for (const int child : clique->children) AddMessage(cliques_[child], clique);
}

void BayesTree::AddFactor(const Factor& factor, Clique* clique) const {
  const int m = clique->size;
  for (size_t j = 0; j < factor.variables.size(); ++j) {
    const int to_j = row_[factor.variables[j]], dim_j = Dim(factor.variables[j]);
    for (int c = 0; c < dim_j; ++c) {
      const double* from = factor.values.data() + (factor.columns[j] + c) * factor.size;
      double* to = clique->matrix.data() + (to_j + c) * m;
      to[m - 1] += from[factor.size - 1];  // b
      for (int r = c; r < dim_j; ++r) to[to_j + r] -= from[factor.columns[j] + r];
      for (size_t i = j + 1; i < factor.variables.size(); ++i) {
        const int to_i = row_[factor.variables[i]], dim_i = Dim(factor.variables[i]);
        const double* block = from + factor.columns[i];
        for (int r = 0; r < dim_i; ++r) {
          if (to_i > to_j) to[to_i + r] -= block[r];
          if (to_i < to_j) clique->matrix[(to_i + r) * m + to_j + c] -= block[r];
        }
      }
    }
  }
}

// U and u of a clique below. Its separator may come in another order here, if it is an orphan.
void BayesTree::AddMessage(const Clique& child, Clique* clique) const {
  const int m = clique->size;
  std::vector<RowRun> runs;
  int from = child.pivots;
  for (size_t k = child.num_frontal; k < child.variables.size(); ++k) {
    const int to = row_[child.variables[k]], dim = Dim(child.variables[k]);
    if (!runs.empty() && runs.back().to + runs.back().length == to) {
      runs.back().length += dim;
    } else {
      runs.push_back({from, to, dim});
    }
    from += dim;
  }
  runs.push_back({from, m - 1, 1});
  for (size_t a = 0; a < runs.size(); ++a) {
    for (int c = 0; c < runs[a].length; ++c) {
      const double* column = child.matrix.data() + static_cast<ptrdiff_t>(runs[a].from + c) * child.size;
      double* target = clique->matrix.data() + static_cast<ptrdiff_t>(runs[a].to + c) * m;
      Add(column + runs[a].from + c, runs[a].length - c, target + runs[a].to + c);
      for (size_t b = a + 1; b < runs.size(); ++b) {
        if (runs[b].to > runs[a].to) {
          Add(column + runs[b].from, runs[b].length, target + runs[b].to);
        } else {
          for (int r = 0; r < runs[b].length; ++r) {
            clique->matrix[(runs[b].to + r) * m + runs[a].to + c] += column[runs[b].from + r];
          }
        }
      }
    }
  }
}

// All frontal variables of a clique at once.  @return −1, or the frontal variable that is not determined
int BayesTree::Eliminate(Clique* clique, const std::vector<int>& factors) {
  Assemble(clique, factors);
  const int m = clique->size;
  std::vector<double> min_pivots;
  for (int k = 0; k < clique->num_frontal; ++k) {
    const int variable = clique->variables[k];
    min_pivots.insert(min_pivots.end(), &min_pivot_[offset_[variable]], &min_pivot_[offset_[variable]] + Dim(variable));
  }
  // Eliminates the pivots [first, first + k).
  const auto eliminate = [&](int first, int k) {
    double* L_11 = clique->matrix.data() + static_cast<ptrdiff_t>(first) * (m + 1);
    if (!kernels::Factor(k, L_11, m, &min_pivots[first])) return false;
    kernels::Eliminate(m - first - k, k, L_11, L_11 + k, m, L_11 + static_cast<ptrdiff_t>(k) * (m + 1), m,
                       kernels::Accumulate::kYes, nullptr);
    return true;
  };
  if (eliminate(0, clique->pivots)) return -1;
  Assemble(clique, factors);  // once more, one variable at a time: which is it?
  for (int k = 0, first = 0; k < clique->num_frontal; first += Dim(clique->variables[k++])) {
    if (!eliminate(first, Dim(clique->variables[k]))) return clique->variables[k];
  }
  return clique->variables[0];
}

// ---- Solve -----------------------------------------------------------------------------------------------------

// L_11ᵀ δ_F = y − L_21ᵀ δ_S.
void BayesTree::SolveClique(const Clique& clique, double threshold) {
  const int k = clique.pivots, m = clique.size;
  gathered_.resize(std::max<ptrdiff_t>(gathered_.size(), m));
  auto x = gathered_.head(k), below = gathered_.segment(k, m - 1 - k);
  int row = 0;
  for (size_t i = clique.num_frontal; i < clique.variables.size(); ++i) {
    const int dim = Dim(clique.variables[i]);
    below.segment(row, dim) = Delta(clique.variables[i]);
    row += dim;
  }
  for (int c = 0; c < k; ++c) x[c] = clique.matrix[static_cast<ptrdiff_t>(c) * m + m - 1];
  kernels::SubtractProductAtx(m - 1 - k, k, clique.matrix.data() + k, m, below.data(), x.data());
  kernels::SolveLowerTranspose(k, clique.matrix.data(), m, x.data());
  row = 0;
  for (int i = 0; i < clique.num_frontal; ++i) {
    const int variable = clique.variables[i], dim = Dim(variable);
    Eigen::Map<VecX> delta(&delta_[offset_[variable]], dim);
    if (clique.is_new || (x.segment(row, dim) - delta).lpNorm<Eigen::Infinity>() > threshold) {
      delta = x.segment(row, dim);
      has_changed_[variable] = true;
      changed_.push_back(variable);
    }
    row += dim;
  }
}

// From the root down, as long as something changes.  Kaess (2012), partial state updates
const std::vector<int>& BayesTree::Solve(double threshold) {
  changed_.clear();
  std::vector<int> stack;
  for (const int c : new_cliques_) {
    if (cliques_[c].parent < 0) stack.push_back(c);
  }
  while (!stack.empty()) {
    Clique& clique = cliques_[stack.back()];
    stack.pop_back();
    const auto has_changed = [&](int variable) { return has_changed_[variable] != 0; };
    if (!clique.is_new &&
        !std::any_of(clique.variables.begin() + clique.num_frontal, clique.variables.end(), has_changed))
      continue;
    SolveClique(clique, threshold);
    clique.is_new = false;
    stack.insert(stack.end(), clique.children.begin(), clique.children.end());
  }
  new_cliques_.clear();
  for (const int variable : changed_) has_changed_[variable] = false;
  return changed_;
}

// With Z = L⁻¹ E, E the identity's columns of the variable:  Σ = Eᵀ (L Lᵀ)⁻¹ E = ZᵀZ. Z is zero but on the path to the root.
MatXX BayesTree::Covariance(int variable) const {
  const int dim = Dim(variable);
  MatXX covariance = MatXX::Zero(dim, dim);
  std::vector<MatXX> rows(1, MatXX::Identity(dim, dim));  // of E − L Z, of the variables on the path so far
  std::vector<int> variables(1, variable);
  for (int c = clique_of_[variable]; c >= 0; c = cliques_[c].parent) {
    const Clique& clique = cliques_[c];
    MatXX rest = MatXX::Zero(clique.size - 1, dim);
    int row = 0;
    for (const int own : clique.variables) row_[own] = row, row += Dim(own);
    for (size_t k = 0; k < variables.size(); ++k) rest.middleRows(row_[variables[k]], rows[k].rows()) = rows[k];
    const Eigen::Map<const MatXX> L(clique.matrix.data(), clique.size, clique.size);
    MatXX Z = rest.topRows(clique.pivots);
    L.topLeftCorner(clique.pivots, clique.pivots).triangularView<Eigen::Lower>().solveInPlace(Z);
    covariance += Z.transpose() * Z;
    rest.bottomRows(clique.size - 1 - clique.pivots) -=
        L.block(clique.pivots, 0, clique.size - 1 - clique.pivots, clique.pivots) * Z;
    variables.assign(clique.variables.begin() + clique.num_frontal, clique.variables.end());
    rows.clear();
    for (const int own : variables) rows.push_back(rest.middleRows(row_[own], Dim(own)));
  }
  return covariance;
}

}  // namespace ch5
