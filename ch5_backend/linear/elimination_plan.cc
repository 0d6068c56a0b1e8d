#include "ch5_backend/linear/elimination_plan.h"

#include <Eigen/OrderingMethods>
#include <Eigen/SparseCore>
#include <algorithm>
#include <numeric>

namespace ch5 {
namespace {

// All neighbors of each block, on both sides of the diagonal, without itself.
Lists Neighbors(const SymmetricBlockMatrix& A) {
  return MakeLists(A.NumColumns(), [&A](const auto& add) {
    for (int j = 0; j < A.NumColumns(); ++j) {
      for (int block = A.ColumnBegin(j) + 1; block < A.ColumnBegin(j + 1); ++block) {
        add(A.Row(block), j);
        add(j, A.Row(block));
      }
    }
  });
}

Array<int> Invert(const Array<int>& order) {
  Array<int> position(order.size());
  for (size_t k = 0; k < order.size(); ++k) position[order[k]] = static_cast<int>(k);
  return position;
}

// Blocks by their distance from the first one, the farthest first; each component of the graph for itself.
Array<int> FarthestFirst(const Lists& neighbors) {
  Array<int> order;
  order.reserve(static_cast<size_t>(neighbors.size()));
  Array<bool> seen(static_cast<size_t>(neighbors.size()), false);
  for (int start = 0; start < neighbors.size(); ++start) {
    if (seen[start]) continue;
    seen[start] = true;
    size_t next = order.size();
    for (order.push_back(start); next < order.size(); ++next) {
      for (const int i : neighbors[order[next]]) {
        if (!seen[i]) order.push_back(i);
        seen[i] = true;
      }
    }
  }
  std::reverse(order.begin(), order.end());
  return order;
}

// Approximate minimum degree. Among equals it takes the first that it is given, and on meshes nearly all are equal:
// given farthest first, sphere2500 needs half the multiplications of the natural order, and fewer than METIS finds.
// The first `last` blocks come last: while the order is found, a clique of blocks that do not exist keeps their degree high,
// so that their neighbors are not taken for the ends of a chain.
Array<int> MinimumDegreeOrder(const Lists& neighbors, int last) {
  constexpr int kClique = 6;
  const int n = neighbors.size(), m = n + (last > 0 ? kClique : 0);
  const Array<int> names = FarthestFirst(neighbors), new_name = Invert(names);
  Eigen::SparseMatrix<double> pattern(m, m);
  pattern.reserve(Eigen::VectorXi::NullaryExpr(
      m, [&](Eigen::Index k) { return 1 + kClique + (k < n ? neighbors[names[k]].size() : 0); }));
  for (int k = 0; k < m; ++k) {
    pattern.insert(k, k) = 1.0;
    if (k >= n || names[k] < last) {
      for (int i = std::max(n, k + 1); i < m; ++i) pattern.insert(i, k) = 1.0;
    }
    if (k >= n) continue;
    for (const int i : neighbors[names[k]]) {
      if (new_name[i] > k) pattern.insert(new_name[i], k) = 1.0;
    }
  }
  Eigen::PermutationMatrix<Eigen::Dynamic, Eigen::Dynamic, int> permutation;
  Eigen::AMDOrdering<int>()(pattern.selfadjointView<Eigen::Lower>(), permutation);
  Array<int> order;
  order.reserve(static_cast<size_t>(n));
  for (int k = 0; k < m; ++k) {
    if (permutation.indices()[k] < n) order.push_back(names[permutation.indices()[k]]);
  }
  std::stable_partition(order.begin(), order.end(), [&](int block) { return block >= last; });
  return order;
}

// parent[k] = the first later neighbor of block k, fill-in included (Liu's algorithm, with path compression).
Array<int> EliminationTree(const Lists& neighbors, const Array<int>& order) {
  const Array<int> position = Invert(order);
  Array<int> parent(order.size(), -1), ancestor(order.size(), -1);
  for (int k = 0; k < static_cast<int>(order.size()); ++k) {
    for (const int neighbor : neighbors[order[k]]) {
      int i = position[neighbor];
      while (i != -1 && i < k) {
        const int next = ancestor[i];
        ancestor[i] = k;
        if (next == -1) parent[i] = k;
        i = next;
      }
    }
  }
  return parent;
}

// Children before parents, and each subtree without gaps. The largest child comes last: a front can be merged with
// the child just before it.
Array<int> Postorder(const Array<int>& parent) {
  const int n = static_cast<int>(parent.size());
  Array<int> size(parent.size(), 1), postorder, stack;
  postorder.reserve(parent.size());
  for (int k = 0; k < n; ++k) {
    if (parent[k] >= 0) size[parent[k]] += size[k];
  }
  Lists children = ChildrenOf(parent);
  const auto is_smaller = [&](int a, int b) { return size[a] != size[b] ? size[a] < size[b] : a < b; };
  for (int k = 0; k < n; ++k) {
    std::sort(children.items.begin() + children.begin[k], children.items.begin() + children.begin[k + 1], is_smaller);
  }
  // Reversed, a preorder that visits the last child first is a postorder.
  for (const int root : children[n]) {
    const size_t begin = postorder.size();
    stack.assign(1, root);
    while (!stack.empty()) {
      const int k = stack.back();
      stack.pop_back();
      postorder.push_back(k);
      stack.insert(stack.end(), children[k].begin(), children[k].end());
    }
    std::reverse(postorder.begin() + static_cast<long>(begin), postorder.end());
  }
  return postorder;
}

// Fronts of consecutive blocks with exactly the same later neighbors; a block without such a partner is one alone.
Array<Front> ExactFronts(const Lists& neighbors, const EliminationPlan& plan, const Array<int>& parent) {
  const int n = static_cast<int>(plan.order.size());
  const Lists children = ChildrenOf(parent);
  Array<int> seen_by(plan.order.size(), -1), front_of(plan.order.size()), found;
  Array<Front> fronts;
  size_t below_last = 0;  // the length of block k − 1's list
  for (int k = 0; k < n; ++k) {
    const auto add = [&](int i) {
      if (i <= k || seen_by[i] == k) return;
      seen_by[i] = k;
      found.push_back(i);
    };
    found.clear();
    for (const int neighbor : neighbors[plan.order[k]]) add(plan.position[neighbor]);
    for (const int child : children[k]) {  // the last block of its front
      for (const int i : fronts[front_of[child]].below) add(i);
    }
    std::sort(found.begin(), found.end());
    const bool like_last = k > 0 && parent[k - 1] == k && below_last == found.size() + 1;
    if (!like_last) fronts.push_back({k, k, {}});
    front_of[k] = static_cast<int>(fronts.size()) - 1;
    fronts.back().last = k + 1;
    fronts.back().below = found;
    below_last = found.size();
  }
  return fronts;
}

void SetSizes(const EliminationPlan& plan, Front* front) {
  front->pivots = plan.offset[front->last] - plan.offset[front->first];
  front->rows_below = 0;
  for (const int block : front->below) front->rows_below += plan.Dim(block);
}

double Multiplications(double k, double r) { return k * (k * k / 6.0 + 0.5 * k * r + 0.5 * r * r); }

// What a front costs, in multiplications: small ones are dominated by copying and bookkeeping.
double Cost(double k, double r) {
  constexpr double kMovedNumber = 12.0, kFront = 3000.0;
  return Multiplications(k, r) + kMovedNumber * (0.5 * r * r + k * (0.5 * k + r)) + kFront;
}

// Merges a front with the child just before it wherever the stored zeros cost less than the merging saves.
Array<Front> MergeFronts(Array<Front> exact) {
  Array<Front> merged;  // backwards
  for (auto front = exact.rbegin(); front != exact.rend(); ++front) {
    if (!merged.empty() && !front->below.empty()) {
      Front& next = merged.back();
      const bool is_child = front->below[0] >= next.first && front->below[0] < next.last;
      const double k = next.pivots, r = next.rows_below, k_child = front->pivots, r_child = front->rows_below;
      if (is_child && Cost(k + k_child, r) < Cost(k, r) + Cost(k_child, r_child)) {
        next.first = front->first;
        next.pivots += front->pivots;
        continue;
      }
    }
    merged.push_back(std::move(*front));
  }
  std::reverse(merged.begin(), merged.end());
  return merged;
}

}  // namespace

Lists ChildrenOf(const Array<int>& parent) {
  const int n = static_cast<int>(parent.size());  // the list of roots is behind all others
  return ListByKey(n, n + 1, [&](int k) { return parent[k] < 0 ? n : parent[k]; });
}

Array<int> EliminationPlan::FrontOfEachBlock() const {
  Array<int> front_of(order.size());
  for (size_t f = 0; f < fronts.size(); ++f) {
    std::fill(front_of.begin() + fronts[f].first, front_of.begin() + fronts[f].last, static_cast<int>(f));
  }
  return front_of;
}

EliminationPlan PlanElimination(const SymmetricBlockMatrix& A) {
  Array<int> dims(static_cast<size_t>(A.NumColumns()));
  for (int block = 0; block < A.NumColumns(); ++block) dims[block] = A.Dim(block);
  return PlanElimination(dims, Neighbors(A));
}

EliminationPlan PlanElimination(const Array<int>& dims, const Lists& neighbors, int last) {
  EliminationPlan plan;
  if (dims.empty()) return plan;
  const Array<int> order = MinimumDegreeOrder(neighbors, last);
  plan.order.reserve(dims.size());
  for (const int k : Postorder(EliminationTree(neighbors, order))) plan.order.push_back(order[k]);
  plan.position = Invert(plan.order);
  plan.offset.reserve(dims.size() + 1);
  plan.offset.push_back(0);
  for (const int block : plan.order) plan.offset.push_back(plan.offset.back() + dims[block]);

  // A postorder of the tree has the same fill-in as the order that gave the tree, and the same tree, renumbered.
  Array<Front> exact = ExactFronts(neighbors, plan, EliminationTree(neighbors, plan.order));
  for (Front& front : exact) SetSizes(plan, &front);
  plan.fronts = MergeFronts(std::move(exact));
  const Array<int> front_of = plan.FrontOfEachBlock();
  for (Front& front : plan.fronts) {
    if (!front.below.empty()) front.parent = front_of[front.below[0]];
    plan.num_factor_values += front.pivots * (0.5 * (front.pivots + 1.0) + front.rows_below);
    plan.multiplications += Multiplications(front.pivots, front.rows_below);
  }
  return plan;
}

EliminationPlan PlanOneFront(const SymmetricBlockMatrix& A) {
  const int n = A.NumColumns();
  EliminationPlan plan;
  plan.order.resize(static_cast<size_t>(n));
  std::iota(plan.order.begin(), plan.order.end(), 0);
  plan.position = plan.order;
  for (int i = 0; i <= n; ++i) plan.offset.push_back(A.Offset(i));
  const double size = A.Size();
  plan.num_factor_values = size * size;
  plan.multiplications = size * size * size / 6.0;
  if (n > 0) plan.fronts.push_back({0, n, {}, -1, A.Size(), 0});
  return plan;
}

}  // namespace ch5
