#include "ch5_backend/linear/cholmod/cholmod_solver.h"

#include <cholmod.h>

#include <numeric>

namespace ch5 {
namespace {

// S in CHOLMOD's compressed columns, lower half.
class CholmodSolver : public ReducedSolver {
 public:
  CholmodSolver() {
    cholmod_start(&common_);
    common_.print = 0;
    common_.supernodal = CHOLMOD_AUTO;
    common_.final_ll = 1;  // an LDLᵀ would take negative pivots
    common_.quick_return_if_not_posdef = 1;
    common_.nmethods = 1;  // the order that Prepare gives
    common_.method[0].ordering = CHOLMOD_GIVEN;
    common_.postorder = 1;
  }
  ~CholmodSolver() override {
    Clear();
    cholmod_finish(&common_);
  }
  CholmodSolver(const CholmodSolver&) = delete;
  CholmodSolver& operator=(const CholmodSolver&) = delete;

  void Prepare(const SymmetricBlockMatrix& S, ThreadPool* /*pool*/) override {
    Clear();
    if (S.Size() == 0) return;
    std::vector<int> order = OrderBlocks(S);
    std::vector<int> rows;  // of numbers
    rows.reserve(static_cast<size_t>(S.Size()));
    for (const int block : order) {
      for (int i = 0; i < S.Dim(block); ++i) rows.push_back(S.Offset(block) + i);
    }
    A_ = Pattern(S);
    factor_ = cholmod_analyze_p(A_, rows.data(), nullptr, 0, &common_);
  }

  bool Solve(const SymmetricBlockMatrix& S, const VecX& b, const VecX&, VecX* x) override {
    if (S.Size() == 0) return true;
    CopyValues(S);
    if (!factor_ || !cholmod_factorize(A_, factor_, &common_) || common_.status != CHOLMOD_OK) return false;
    cholmod_dense rhs{};
    rhs.nrow = rhs.d = rhs.nzmax = static_cast<size_t>(b.size());
    rhs.ncol = 1;
    rhs.x = const_cast<double*>(b.data());  // read only
    rhs.xtype = CHOLMOD_REAL;
    rhs.dtype = CHOLMOD_DOUBLE;
    cholmod_dense* solution = cholmod_solve(CHOLMOD_A, factor_, &rhs, &common_);
    if (!solution) return false;
    *x = Eigen::Map<const VecX>(static_cast<const double*>(solution->x), b.size());
    cholmod_free_dense(&solution, &common_);
    return x->allFinite();
  }

 private:
  void Clear() {
    if (A_) cholmod_free_sparse(&A_, &common_);
    if (factor_) cholmod_free_factor(&factor_, &common_);
  }

  // Approximate minimum degree on the graph of blocks: a matrix with one number for each.
  std::vector<int> OrderBlocks(const SymmetricBlockMatrix& S) {
    const auto n = static_cast<size_t>(S.NumColumns());
    cholmod_sparse* blocks =
        cholmod_allocate_sparse(n, n, static_cast<size_t>(S.NumBlocks()), 1, 1, -1, CHOLMOD_PATTERN, &common_);
    int *begin = static_cast<int*>(blocks->p), *row = static_cast<int*>(blocks->i);
    for (int j = 0; j <= S.NumColumns(); ++j) begin[j] = S.ColumnBegin(j);
    for (int block = 0; block < S.NumBlocks(); ++block) row[block] = S.Row(block);
    std::vector<int> order(n);
    if (!cholmod_amd(blocks, nullptr, 0, order.data(), &common_)) std::iota(order.begin(), order.end(), 0);
    cholmod_free_sparse(&blocks, &common_);
    return order;
  }

  // The lower half column by column; a diagonal block gives its lower half only.
  cholmod_sparse* Pattern(const SymmetricBlockMatrix& S) {
    std::vector<int> begin{0}, rows;
    for (int j = 0; j < S.NumColumns(); ++j) {
      for (int c = 0; c < S.Dim(j); ++c) {
        for (int block = S.ColumnBegin(j); block < S.ColumnBegin(j + 1); ++block) {
          const int i = S.Row(block);
          for (int r = i == j ? c : 0; r < S.Dim(i); ++r) rows.push_back(S.Offset(i) + r);
        }
        begin.push_back(static_cast<int>(rows.size()));
      }
    }
    const auto n = static_cast<size_t>(S.Size());
    cholmod_sparse* A = cholmod_allocate_sparse(n, n, rows.size(), 1, 1, -1, CHOLMOD_REAL, &common_);
    std::copy(begin.begin(), begin.end(), static_cast<int*>(A->p));
    std::copy(rows.begin(), rows.end(), static_cast<int*>(A->i));
    return A;
  }

  void CopyValues(const SymmetricBlockMatrix& S) {
    double* value = static_cast<double*>(A_->x);
    for (int j = 0; j < S.NumColumns(); ++j) {
      for (int c = 0; c < S.Dim(j); ++c) {
        for (int block = S.ColumnBegin(j); block < S.ColumnBegin(j + 1); ++block) {
          const int i = S.Row(block), first = i == j ? c : 0;
          const double* column = S.Values(block) + c * Stride(S.Dim(i));
          value = std::copy(column + first, column + S.Dim(i), value);
        }
      }
    }
  }

  cholmod_common common_;
  cholmod_sparse* A_ = nullptr;
  cholmod_factor* factor_ = nullptr;
};

}  // namespace

std::unique_ptr<ReducedSolver> MakeCholmodSolver() { return std::make_unique<CholmodSolver>(); }

}  // namespace ch5
