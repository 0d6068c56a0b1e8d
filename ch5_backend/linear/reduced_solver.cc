#include "ch5_backend/linear/reduced_solver.h"

#include <Eigen/Cholesky>
#include <stdexcept>

#include "ch5_backend/linear/conjugate_gradients.h"
#include "ch5_backend/linear/pivot_rule.h"
#include "ch5_backend/linear/sparse_cholesky.h"
#include "ch5_backend/math/dense_kernels.h"
#include "ch5_backend/math/option_checks.h"
#include "ch5_backend/math/psd.h"
#include "ch5_backend/math/vector_kernels.h"

namespace ch5 {
namespace {

void MinPivots(const VecX& scale, VecX* min_pivot) {
  *min_pivot = PivotRounding(static_cast<int>(scale.size())) * scale;
}

class DenseCholesky : public ReducedSolver {
 public:
  void Prepare(const SymmetricBlockMatrix& S, ThreadPool* pool) override {
    A_.resize(S.Size(), S.Size() + NumChunks(kernels::kOverread, std::max(1, S.Size())));
    A_.topRows(std::min(S.Size(), kernels::kOverread)).setZero();  // which are read behind the column before
    min_pivot_.resize(S.Size());
    pool_ = pool;
  }

  bool Solve(const SymmetricBlockMatrix& S, const VecX& b, const VecX& scale, VecX* x) override {
    S.CopyLower(A_.data());
    MinPivots(scale, &min_pivot_);
    if (!kernels::Factor(S.Size(), A_.data(), S.Size(), min_pivot_.data(), pool_)) return false;
    *x = b;
    kernels::SolveLower(S.Size(), A_.data(), S.Size(), x->data());
    kernels::SolveLowerTranspose(S.Size(), A_.data(), S.Size(), x->data());
    return x->allFinite();
  }

 private:
  MatXX A_;  // with kOverread numbers more, see dense_kernels.h
  VecX min_pivot_;
  ThreadPool* pool_ = nullptr;
};

class SparseCholeskySolver : public ReducedSolver {
 public:
  void Prepare(const SymmetricBlockMatrix& S, ThreadPool* pool) override { Prepare(S, PlanElimination(S), pool); }
  void Prepare(const SymmetricBlockMatrix& S, EliminationPlan plan, ThreadPool* pool) {
    cholesky_.Analyze(S, std::move(plan), pool);
    min_pivot_.resize(S.Size());
  }

  bool Solve(const SymmetricBlockMatrix& S, const VecX& b, const VecX& scale, VecX* x) override {
    MinPivots(scale, &min_pivot_);
    if (!cholesky_.Factorize(S, min_pivot_)) return false;
    cholesky_.Solve(b, x);
    return x->allFinite();
  }

 private:
  SparseCholesky cholesky_;
  VecX min_pivot_;
};

// Everything that a plan depends on: two matrices of equal patterns have the same plan.
Array<int> PatternOf(const SymmetricBlockMatrix& S) {
  Array<int> pattern;
  pattern.reserve(static_cast<size_t>(2 * S.NumColumns() + S.NumBlocks()));
  for (int j = 0; j < S.NumColumns(); ++j) {
    pattern.push_back(S.Dim(j));
    pattern.push_back(S.ColumnBegin(j + 1));
    for (int block = S.ColumnBegin(j); block < S.ColumnBegin(j + 1); ++block) pattern.push_back(S.Row(block));
  }
  return pattern;
}

class AutomaticCholesky : public ReducedSolver {
 public:
  void Prepare(const SymmetricBlockMatrix& S, ThreadPool* pool) override {
    Array<int> pattern = PatternOf(S);
    if (chosen_ && pattern == pattern_) return;  // one solver's pool stays the same
    pattern_ = std::move(pattern);
    constexpr double kSmall = 100.0;
    const double n = S.Size(), columns = S.NumColumns();
    const bool dense = n <= kSmall || S.NumBlocks() > 0.7 * columns * (columns + 1.0) / 2.0;
    EliminationPlan plan;
    if (!dense) plan = PlanElimination(S);
    if (dense || plan.multiplications > 0.5 * n * n * n / 6.0) {
      dense_.Prepare(S, pool);
      chosen_ = &dense_;
    } else {
      sparse_.Prepare(S, std::move(plan), pool);
      chosen_ = &sparse_;
    }
  }

  bool Solve(const SymmetricBlockMatrix& S, const VecX& b, const VecX& scale, VecX* x) override {
    return chosen_->Solve(S, b, scale, x);
  }

 private:
  Array<int> pattern_;
  DenseCholesky dense_;
  SparseCholeskySolver sparse_;
  ReducedSolver* chosen_ = nullptr;  // one of the two
};

class BlockPcg : public ReducedSolver {
 public:
  explicit BlockPcg(double tolerance) : tolerance_(tolerance) {}

  void Prepare(const SymmetricBlockMatrix& S, ThreadPool* /*pool*/) override {
    iterate_.Resize(S.Size());
    factors_.clear();
    factors_.reserve(static_cast<size_t>(S.NumColumns()));  // not to be copied before they are computed
    for (int j = 0; j < S.NumColumns(); ++j) factors_.emplace_back(S.Dim(j));
  }

  bool Solve(const SymmetricBlockMatrix& S, const VecX& b, const VecX&, VecX* x) override {
    if (!Factorize(S)) return false;
    const auto multiply = [&](const VecX& v, VecX* Sv) { S.Multiply(v.data(), Sv->data()); };
    const auto precondition = [&](const VecX& r, VecX* z) { Precondition(S, r, z); };
    const double goal = tolerance_ * b.norm();
    const auto is_enough = [&](const LinearIterate& iterate) { return iterate.r.norm() <= goal; };
    x->setZero(b.size());
    iterate_.StartAtZero(b, precondition);
    return ConjugateGradients(multiply, precondition, is_enough, 10 * S.Size() + 100, &iterate_, x) && x->allFinite();
  }

 private:
  bool Factorize(const SymmetricBlockMatrix& S) {
    for (int j = 0; j < S.NumColumns(); ++j) {
      using Block = Eigen::Map<const MatXX, 0, Eigen::OuterStride<>>;
      factors_[j].compute(
          Block(S.Values(S.ColumnBegin(j)), S.Dim(j), S.Dim(j), Eigen::OuterStride<>(Stride(S.Dim(j)))));
      if (factors_[j].info() != Eigen::Success) return false;
    }
    return true;
  }

  // z = M⁻¹ r
  void Precondition(const SymmetricBlockMatrix& S, const VecX& r, VecX* z) const {
    *z = r;
    for (int j = 0; j < S.NumColumns(); ++j) {
      auto z_j = z->segment(S.Offset(j), S.Dim(j));
      factors_[j].solveInPlace(z_j);
    }
  }

  double tolerance_;
  Array<Eigen::LLT<MatXX>> factors_;
  LinearIterate iterate_;
};

class PseudoInverse : public ReducedSolver {
 public:
  explicit PseudoInverse(int nullity) : nullity_(nullity) {}

  void Prepare(const SymmetricBlockMatrix& S, ThreadPool* /*pool*/) override { A_.resize(S.Size(), S.Size()); }
  bool Solve(const SymmetricBlockMatrix& S, const VecX& b, const VecX& /*scale*/, VecX* x) override {
    S.CopyLower(A_.data());
    try {
      *x = PseudoInversePsd(A_.selfadjointView<Eigen::Lower>(), nullity_) * b;
    } catch (const std::invalid_argument&) {
      return false;
    }
    return x->allFinite();
  }

 private:
  int nullity_;
  MatXX A_;
};

}  // namespace

void IterativeOptions::Validate() const {
  CheckOption("IterativeOptions::tolerance", tolerance, 0);
  CheckOption("IterativeOptions::model_tolerance", model_tolerance, 0);
  CheckOption("IterativeOptions::max_iterations", max_iterations, 1);
  CheckOption("IterativeOptions::max_terms", max_terms, 0);
}

ReducedSolverType ChooseReducedSolver(ReducedSolverType type, int num_poses, bool tied_by_landmarks_alone) {
  constexpr int kManyPoses = 400;
  const bool is_implicit = type == ReducedSolverType::kAutomatic && tied_by_landmarks_alone && num_poses > kManyPoses;
  return is_implicit ? ReducedSolverType::kPowerSeries : type;
}

std::unique_ptr<ReducedSolver> MakeReducedSolver(ReducedSolverType type) {
  switch (type) {
    case ReducedSolverType::kDenseCholesky: return std::make_unique<DenseCholesky>();
    case ReducedSolverType::kSparseCholesky: return std::make_unique<SparseCholeskySolver>();
    case ReducedSolverType::kPcg: return MakeBlockPcg(1e-14);
    case ReducedSolverType::kImplicitPcg:
    case ReducedSolverType::kPowerSeries:
    case ReducedSolverType::kAutomatic: break;
  }
  return std::make_unique<AutomaticCholesky>();
}

std::unique_ptr<ReducedSolver> MakeBlockPcg(double tolerance) { return std::make_unique<BlockPcg>(tolerance); }
std::unique_ptr<ReducedSolver> MakePseudoInverse(int nullity) { return std::make_unique<PseudoInverse>(nullity); }

}  // namespace ch5
