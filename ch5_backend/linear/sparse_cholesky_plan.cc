// Everything that depends on the pattern alone: where the fronts are stored, what is copied and added where, and which
// thread does what.

#include <algorithm>

#include "ch5_backend/linear/sparse_cholesky.h"
#include "ch5_backend/math/dense_kernels.h"

namespace ch5 {
void SparseCholesky::Analyze(const SymmetricBlockMatrix& A, EliminationPlan plan, ThreadPool* pool) {
  pool_ = pool;
  plan_ = std::move(plan);
  places_.assign(plan_.fronts.size(), {});
  Array<int> parent(places_.size());
  for (size_t f = 0; f < places_.size(); ++f) parent[f] = plan_.fronts[f].parent;
  children_ = ChildrenOf(parent);
  PlaceColumns();
  PlanGathering(A);
  PlanTasks();
  PlaceUpdates();

  permutation_.clear();
  permutation_.reserve(static_cast<size_t>(A.Size()));
  for (const int block : plan_.order) {
    for (int i = 0; i < A.Dim(block); ++i) permutation_.push_back(A.Offset(block) + i);
  }
  for (AlignedVector* numbers : {&min_pivot_, &x_}) numbers->resize(static_cast<size_t>(A.Size()));
  int most_below = 0;
  for (const Front& front : plan_.fronts) most_below = std::max(most_below, front.rows_below);
  gathered_.resize(static_cast<size_t>(most_below));
}

void SparseCholesky::PlaceColumns() {
  ptrdiff_t size = 0;
  for (size_t f = 0; f < places_.size(); ++f) {
    const Front& front = plan_.fronts[f];
    places_[f].columns = size;
    size += static_cast<ptrdiff_t>(front.pivots + front.rows_below) * front.pivots + kernels::kOverread;
  }
  L_ = AlignedVector(static_cast<size_t>(size));  // unset: Factorize writes what is read
}

// A block (i, j) of A goes to the front that eliminates the earlier of the two; a child's U goes to its parent.
void SparseCholesky::PlanGathering(const SymmetricBlockMatrix& A) {
  Array<int> column(static_cast<size_t>(A.NumBlocks()));  // of each block
  for (int j = 0; j < A.NumColumns(); ++j) {
    std::fill(column.begin() + A.ColumnBegin(j), column.begin() + A.ColumnBegin(j + 1), j);
  }
  const Array<int> front_of = plan_.FrontOfEachBlock();
  const Lists blocks = ListByKey(A.NumBlocks(), static_cast<int>(places_.size()), [&](int block) {  // of each front
    return front_of[std::min(plan_.position[A.Row(block)], plan_.position[column[block]])];
  });

  copies_.clear();
  copies_.reserve(column.size());
  runs_.clear();
  Array<int> row_of(plan_.order.size());  // of a block (in elimination order) in the front at hand
  for (size_t f = 0; f < places_.size(); ++f) {
    const Front& front = plan_.fronts[f];
    int row = 0;
    const auto next_row = [&](int block) {
      row_of[block] = row;
      row += plan_.Dim(block);
    };
    for (int block = front.first; block < front.last; ++block) next_row(block);
    for (const int block : front.below) next_row(block);

    places_[f].copies_begin = static_cast<int>(copies_.size());
    for (const int block : blocks[static_cast<int>(f)]) {
      const int i = A.Row(block), j = column[block];
      const int row_i = row_of[plan_.position[i]], row_j = row_of[plan_.position[j]];
      const ptrdiff_t column = std::min(row_i, row_j);
      const ptrdiff_t target = places_[f].columns + std::max(row_i, row_j) + column * row;
      copies_.push_back({block, A.Dim(i), A.Dim(j), target, row_i < row_j});
    }
    places_[f].copies_end = static_cast<int>(copies_.size());
    for (const int child : children_[static_cast<int>(f)]) PlanRuns(child, front.pivots, row_of);
  }
}

void SparseCholesky::PlanRuns(int child, int parent_pivots, const Array<int>& row_of) {
  const int begin = static_cast<int>(runs_.size());
  int from = 0;
  for (const int block : plan_.fronts[child].below) {
    const int to = row_of[block], length = plan_.Dim(block);
    // A run does not cross from the parent's pivots to the rows below: the two are stored apart.
    const bool continues =
        static_cast<int>(runs_.size()) > begin && to != parent_pivots && runs_.back().to + runs_.back().length == to;
    if (continues) {
      runs_.back().length += length;
    } else {
      runs_.push_back({from, to, length});
    }
    from += length;
  }
  const auto is_below = [&](const RowRun& run) { return run.to >= parent_pivots; };
  places_[child].runs_begin = begin;
  places_[child].runs_below =
      static_cast<int>(std::find_if(runs_.begin() + begin, runs_.end(), is_below) - runs_.begin());
  places_[child].runs_end = static_cast<int>(runs_.size());
}

// Whole subtrees, each a small part of the work, are tasks for any thread; the fronts above them are the last task.
void SparseCholesky::PlanTasks() {
  const int n = static_cast<int>(places_.size());
  Array<double> work(places_.size(), 1.0);
  for (int f = 0; f < n; ++f) {
    const double k = plan_.fronts[f].pivots, m = k + plan_.fronts[f].rows_below;
    work[f] += k * m * m;
    for (const int child : children_[f]) work[f] += work[child];
  }
  double total = 0.0;
  for (int f = 0; f < n; ++f) total += plan_.fronts[f].parent < 0 ? work[f] : 0.0;
  const int threads = pool_ ? pool_->Threads() : 1;
  const double small = threads == 1 ? total : total / (6.0 * threads);

  Array<int> roots;  // of these subtrees, the one with the most work first
  for (int f = n - 1; f >= 0; --f) {
    const int parent = plan_.fronts[f].parent;
    if (work[f] <= small && (parent < 0 || work[parent] > small)) roots.push_back(f);
  }
  std::sort(roots.begin(), roots.end(), [&](int a, int b) { return std::pair(work[a], a) > std::pair(work[b], b); });
  Array<int> task_of(places_.size(), static_cast<int>(roots.size()));
  for (size_t t = 0; t < roots.size(); ++t) task_of[roots[t]] = static_cast<int>(t);
  for (int f = n - 1; f >= 0; --f) {
    const int parent = plan_.fronts[f].parent;
    if (parent >= 0 && work[parent] <= small) task_of[f] = task_of[parent];
  }
  tasks_ = ListByKey(n, static_cast<int>(roots.size()) + 1, [&](int f) { return task_of[f]; });
}

// U is needed from its front until its parent. In a postorder a stack would do, but a front's U is computed while those
// of its children are still needed. So each task has two stacks, for the even and the odd levels of the tree.
void SparseCholesky::PlaceUpdates() {
  const int n = static_cast<int>(places_.size());
  Array<int> generation(places_.size(), 0), task_of(places_.size(), 0);
  for (int f = n - 1; f >= 0; --f) {
    if (plan_.fronts[f].parent >= 0) generation[f] = 1 - generation[plan_.fronts[f].parent];
  }
  for (int t = 0; t < tasks_.size(); ++t) {
    for (const int f : tasks_[t]) task_of[f] = t;
  }
  const auto size = [&](int f) {
    const ptrdiff_t r = plan_.fronts[f].rows_below;
    return r * r + kernels::kOverread;
  };
  ptrdiff_t base = 0;
  for (int t = 0; t < tasks_.size(); ++t) {
    ptrdiff_t top[2] = {0, 0}, peak[2] = {0, 0};
    for (const int f : tasks_[t]) {
      const int g = generation[f];
      places_[f].update = top[g];  // within its stack
      top[g] += size(f);
      peak[g] = std::max(peak[g], top[g]);
      for (const int child : children_[f]) {
        if (task_of[child] == task_of[f]) top[1 - g] -= size(child);
      }
    }
    for (const int f : tasks_[t]) places_[f].update += base + (generation[f] == 0 ? 0 : peak[0]);
    base += peak[0] + peak[1];
  }
  updates_ = AlignedVector(static_cast<size_t>(base));
}

}  // namespace ch5
