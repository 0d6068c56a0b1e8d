#include "ch5_backend/linear/sparse_cholesky.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <atomic>
#include <cstdlib>
#include <limits>
#include <new>

#include "ch5_backend/linear/reduced_solver.h"
#include "ch5_backend/math/dense_kernels.h"
#include "ch5_backend/world/simulate/random.h"

namespace {
std::atomic<long> allocations{0};
}

// Every allocation of this program is counted. Not inlined: the compiler would see new meet free.
[[gnu::noinline]] void* operator new(size_t size) {
  ++allocations;
  if (void* memory = std::malloc(size)) return memory;
  throw std::bad_alloc();
}
[[gnu::noinline]] void* operator new(size_t size, const std::nothrow_t&) noexcept {
  ++allocations;
  return std::malloc(size);
}
[[gnu::noinline]] void operator delete(void* memory) noexcept { std::free(memory); }
[[gnu::noinline]] void operator delete(void* memory, size_t) noexcept { std::free(memory); }

namespace ch5 {
namespace {

using Ties = std::vector<std::pair<int, int>>;  // i > j

// Symmetric with random blocks where there are ties; diagonally dominant, so positive definite.
SymmetricBlockMatrix MakeMatrix(const std::vector<int>& dims, const Ties& ties, uint64_t seed) {
  std::vector<std::vector<int>> rows(dims.size());
  std::vector<double> degree(dims.size(), 1.0);
  for (size_t j = 0; j < dims.size(); ++j) rows[j].push_back(static_cast<int>(j));
  for (const auto& [i, j] : ties) {
    rows[j].push_back(i);
    degree[i] += dims[j];
    degree[j] += dims[i];
  }
  for (auto& column : rows) {
    std::sort(column.begin(), column.end());
    column.erase(std::unique(column.begin(), column.end()), column.end());
  }
  SymmetricBlockMatrix A;
  A.SetPattern(dims, rows);
  Random random(seed);
  for (int j = 0; j < A.NumColumns(); ++j) {
    for (int block = A.ColumnBegin(j); block < A.ColumnBegin(j + 1); ++block) {
      const int i = A.Row(block), stride = Stride(A.Dim(i));
      for (int c = 0; c < A.Dim(j); ++c) {
        for (int r = i == j ? c : 0; r < A.Dim(i); ++r) {
          const double value = i == j && r == c ? degree[j] + A.Dim(j) : random.Uniform(-1.0, 1.0);
          A.Values(block)[c * stride + r] = value;
          if (i == j) A.Values(block)[r * stride + c] = value;
        }
      }
    }
  }
  return A;
}

Ties Chain(int n) {
  Ties ties;
  for (int i = 1; i < n; ++i) ties.emplace_back(i, i - 1);
  return ties;
}

Ties Grid(int side) {
  Ties ties;
  for (int y = 0; y < side; ++y) {
    for (int x = 0; x < side; ++x) {
      if (x > 0) ties.emplace_back(y * side + x, y * side + x - 1);
      if (y > 0) ties.emplace_back(y * side + x, (y - 1) * side + x);
    }
  }
  return ties;
}

Ties Everything(int n) {
  Ties ties;
  for (int i = 0; i < n; ++i) {
    for (int j = 0; j < i; ++j) ties.emplace_back(i, j);
  }
  return ties;
}

Ties Chance(int n, int count, uint64_t seed) {
  Random random(seed);
  Ties ties;
  for (int k = 0; k < count; ++k) {
    const int i = static_cast<int>(random.Uniform(0, n)), j = static_cast<int>(random.Uniform(0, n));
    if (i != j) ties.emplace_back(std::max(i, j), std::min(i, j));
  }
  return ties;
}

std::vector<int> MixedDims(int n) {
  constexpr int kDims[] = {6, 3, 1, 9, 2, 6, 15};
  std::vector<int> dims;
  for (int i = 0; i < n; ++i) dims.push_back(kDims[i % 7]);
  return dims;
}

VecX RandomVector(int n, uint64_t seed) {
  Random random(seed);
  return VecX::NullaryExpr(n, [&] { return random.Normal(); });
}

std::vector<SymmetricBlockMatrix> Matrices() {
  std::vector<SymmetricBlockMatrix> matrices;
  for (const int dim : {1, 3, 6, 9}) {
    matrices.push_back(MakeMatrix(std::vector<int>(1, dim), {}, 1));
    matrices.push_back(MakeMatrix(std::vector<int>(40, dim), Chain(40), 2));
    matrices.push_back(MakeMatrix(std::vector<int>(144, dim), Grid(12), 3));
    matrices.push_back(MakeMatrix(std::vector<int>(30, dim), Everything(30), 4));
  }
  matrices.push_back(MakeMatrix(MixedDims(50), Chain(50), 5));
  matrices.push_back(MakeMatrix(MixedDims(100), Grid(10), 6));
  matrices.push_back(MakeMatrix(MixedDims(80), Chance(80, 60, 7), 8));  // several parts, and single blocks
  matrices.push_back(MakeMatrix(MixedDims(60), Chance(60, 400, 9), 10));
  return matrices;
}

VecX SolveDense(const SymmetricBlockMatrix& A, const VecX& b) { return A.Dense().llt().solve(b); }

TEST(SparseCholesky, SolvesLikeTheDenseOracle) {
  for (const SymmetricBlockMatrix& A : Matrices()) {
    const VecX b = RandomVector(A.Size(), 20), expected = SolveDense(A, b);
    SparseCholesky cholesky;
    cholesky.Analyze(A);
    ASSERT_TRUE(cholesky.Factorize(A, VecX::Zero(A.Size())));
    VecX x;
    cholesky.Solve(b, &x);
    // The matrices are dominated by their diagonals: nothing is lost but the last digits.
    EXPECT_LT((x - expected).norm(), 1e-13 * expected.norm()) << A.NumColumns() << " blocks of " << A.Dim(0);
  }
}

TEST(SparseCholesky, EveryReducedSolverGivesTheSameAnswer) {
  for (const SymmetricBlockMatrix& A : Matrices()) {
    const VecX b = RandomVector(A.Size(), 21), expected = SolveDense(A, b);
    for (const auto type : {ReducedSolverType::kAutomatic, ReducedSolverType::kDenseCholesky,
                            ReducedSolverType::kSparseCholesky, ReducedSolverType::kPcg}) {
      const auto solver = MakeReducedSolver(type, 1);
      solver->Prepare(A);
      VecX x;
      ASSERT_TRUE(solver->Solve(A, b, A.Diagonal(), &x));
      EXPECT_LT((x - expected).norm(), 1e-12 * expected.norm()) << static_cast<int>(type);
    }
  }
}

TEST(SparseCholesky, AnyNumberOfThreadsGivesTheSameBits) {
  const SymmetricBlockMatrix A = MakeMatrix(std::vector<int>(900, 6), Grid(30), 11);
  const VecX b = RandomVector(A.Size(), 22);
  VecX x_1;
  for (const int threads : {1, 2, 5}) {
    SparseCholesky cholesky(threads);
    cholesky.Analyze(A);
    ASSERT_TRUE(cholesky.Factorize(A, VecX::Zero(A.Size())));
    VecX x;
    cholesky.Solve(b, &x);
    if (threads == 1) x_1 = x;
    EXPECT_EQ(x, x_1) << threads << " threads";
  }
}

TEST(SparseCholesky, FactorisesOftenWithoutTakingMemory) {
  const SymmetricBlockMatrix A = MakeMatrix(std::vector<int>(400, 6), Grid(20), 12);
  const VecX b = RandomVector(A.Size(), 23), min_pivot = VecX::Zero(A.Size());
  for (const int threads : {1, 2}) {
    SparseCholesky cholesky(threads);
    cholesky.Analyze(A);
    VecX x(A.Size());
    const long before = allocations;
    for (int repeat = 0; repeat < 3; ++repeat) {
      ASSERT_TRUE(cholesky.Factorize(A, min_pivot));
      cholesky.Solve(b, &x);
    }
    EXPECT_EQ(allocations, before) << threads << " threads";
  }
}

TEST(SparseCholesky, NewValuesInTheOldPattern) {
  const SymmetricBlockMatrix first = MakeMatrix(MixedDims(64), Grid(8), 13);
  const SymmetricBlockMatrix second = MakeMatrix(MixedDims(64), Grid(8), 14);
  const VecX b = RandomVector(first.Size(), 24);
  SparseCholesky cholesky;
  cholesky.Analyze(first);
  ASSERT_TRUE(cholesky.Factorize(first, VecX::Zero(first.Size())));
  ASSERT_TRUE(cholesky.Factorize(second, VecX::Zero(first.Size())));
  VecX x;
  cholesky.Solve(b, &x);
  EXPECT_LT((x - SolveDense(second, b)).norm(), 1e-13 * x.norm());
}

// One diagonal entry, anywhere, is made too small: that must show, and leave nothing behind.
TEST(SparseCholesky, IndefiniteMatricesAreRefused) {
  const SymmetricBlockMatrix good = MakeMatrix(std::vector<int>(100, 6), Grid(10), 15);
  const VecX b = RandomVector(good.Size(), 25), none = VecX::Zero(good.Size());
  for (const int threads : {1, 2}) {
    SparseCholesky cholesky(threads);
    cholesky.Analyze(good);
    for (int j = 0; j < 100; j += 9) {
      for (const double bad : {-1.0, 0.0, std::numeric_limits<double>::quiet_NaN()}) {
        SymmetricBlockMatrix A = good;
        A.Values(A.ColumnBegin(j))[(j % 6) * (Stride(6) + 1)] = bad;
        EXPECT_FALSE(cholesky.Factorize(A, none)) << "block " << j << ", entry " << bad;
      }
    }
    ASSERT_TRUE(cholesky.Factorize(good, none));
    VecX x;
    cholesky.Solve(b, &x);
    EXPECT_LT((x - SolveDense(good, b)).norm(), 1e-13 * x.norm());
  }
}

// A chain whose ends are free is singular: the last pivot is rounding, and the solver's measure must see it.
TEST(SparseCholesky, RoundingIsNotAPivot) {
  std::vector<std::vector<int>> rows;
  for (int j = 0; j < 400; ++j) rows.push_back(j + 1 < 400 ? std::vector<int>{j, j + 1} : std::vector<int>{j});
  SymmetricBlockMatrix A;
  A.SetPattern(std::vector<int>(400, 1), rows);
  for (int j = 0; j < 400; ++j) {
    A.Values(A.ColumnBegin(j))[0] = j == 0 || j == 399 ? 0.1 : 0.2;
    if (j < 399) A.Values(A.ColumnBegin(j) + 1)[0] = -0.1;
  }
  for (const auto type : {ReducedSolverType::kAutomatic, ReducedSolverType::kSparseCholesky}) {
    const auto solver = MakeReducedSolver(type, 1);
    solver->Prepare(A);
    VecX x;
    EXPECT_FALSE(solver->Solve(A, VecX::Ones(400), A.Diagonal(), &x));
  }
}

TEST(EliminationPlan, ChainAndStarHaveNoFill) {
  // A star's natural order, centre first, would fill the whole matrix.
  Ties star;
  for (int i = 1; i < 50; ++i) star.emplace_back(i, 0);
  for (const Ties& ties : {Chain(50), star}) {
    const SymmetricBlockMatrix A = MakeMatrix(std::vector<int>(50, 20), ties, 16);
    const EliminationPlan plan = PlanElimination(A);
    // 50 triangles of 20·21/2 and 49 blocks of 20². Merging may store the zeros of the last two blocks' triangles.
    const double exact = 50 * 210 + 49 * 400;
    EXPECT_GE(plan.num_factor_values, exact);
    EXPECT_LE(plan.num_factor_values, 1.02 * exact);
  }
}

TEST(EliminationPlan, IsAPermutationWithChildrenBeforeParents) {
  for (const SymmetricBlockMatrix& A : Matrices()) {
    const EliminationPlan plan = PlanElimination(A);
    ASSERT_EQ(plan.order.size(), static_cast<size_t>(A.NumColumns()));
    for (size_t k = 0; k < plan.order.size(); ++k) EXPECT_EQ(plan.position[plan.order[k]], static_cast<int>(k));
    int next = 0;
    for (size_t f = 0; f < plan.fronts.size(); ++f) {
      const Front& front = plan.fronts[f];
      EXPECT_EQ(front.first, next);
      EXPECT_LT(front.first, front.last);
      next = front.last;
      EXPECT_EQ(front.parent < 0, front.below.empty());
      if (front.parent < 0) continue;
      EXPECT_GT(front.parent, static_cast<int>(f));
      const Front& parent = plan.fronts[front.parent];
      for (const int block : front.below) {
        const bool is_pivot = block >= parent.first && block < parent.last;
        EXPECT_TRUE(is_pivot || std::binary_search(parent.below.begin(), parent.below.end(), block));
      }
    }
    EXPECT_EQ(next, A.NumColumns());
  }
}

// ---- the dense loops, in each of their versions ----------------------------------------------------------------

class DenseKernels : public testing::TestWithParam<const char*> {
 protected:
  void SetUp() override {
    if (!kernels::SetInstructionSet(GetParam())) GTEST_SKIP() << "this processor has no " << GetParam();
  }
  void TearDown() override { kernels::SetInstructionSet(best_.c_str()); }

  // A matrix inside a larger one; what lies around must not change.
  static MatXX RandomMatrix(int rows, int cols, Random* random) {
    return MatXX::NullaryExpr(rows, cols, [&] { return random->Uniform(-1.0, 1.0); });
  }

 private:
  std::string best_ = kernels::InstructionSet();
};

TEST_P(DenseKernels, ProductsAgreeWithEigen) {
  Random random(26);
  for (const int m : {1, 5, 8, 17, 24, 50, 205}) {
    for (const int n : {1, 3, 6, 13, 30}) {
      for (const int k : {0, 1, 6, 65, 130}) {
        const MatXX A = RandomMatrix(m + 4, k + 9, &random), B = RandomMatrix(n + 3, k + 9, &random);
        MatXX C = RandomMatrix(m + 2, n + 1, &random), expected = C;
        expected.topLeftCorner(m, n) -= A.topLeftCorner(m, k) * B.topLeftCorner(n, k).transpose();
        kernels::SubtractProductABt(m, n, k, A.data(), m + 4, B.data(), n + 3, C.data(), m + 2);
        // k products of numbers below 1.
        EXPECT_LT((C - expected).cwiseAbs().maxCoeff(), 1e-15 * (k + 4)) << m << ' ' << n << ' ' << k;
        if (k == 0) continue;
        C.topLeftCorner(m, n).setConstant(std::numeric_limits<double>::quiet_NaN());
        expected.topLeftCorner(m, n) = -A.topLeftCorner(m, k) * B.topLeftCorner(n, k).transpose();
        kernels::SubtractProductABt(m, n, k, A.data(), m + 4, B.data(), n + 3, C.data(), m + 2, kernels::Old::kForget);
        EXPECT_LT((C - expected).cwiseAbs().maxCoeff(), 1e-15 * (k + 4)) << m << ' ' << n << ' ' << k;
      }
    }
  }
}

TEST_P(DenseKernels, SymmetricProductsAgreeWithEigen) {
  Random random(27);
  for (const int n : {1, 5, 6, 8, 23, 48, 200}) {
    for (const int k : {0, 1, 6, 65}) {
      const MatXX A = RandomMatrix(n + 4, k + 9, &random);
      MatXX C = RandomMatrix(n + 3, n + 3, &random), expected = C;
      expected.topLeftCorner(n, n) -= A.topLeftCorner(n, k) * A.topLeftCorner(n, k).transpose();
      kernels::SubtractProductAAt(n, k, A.data(), n + 4, C.data(), n + 3);
      const MatXX wrong = C - expected;
      EXPECT_LT(MatXX(wrong.topLeftCorner(n, n).triangularView<Eigen::Lower>()).cwiseAbs().maxCoeff(), 1e-15 * (k + 4));
      EXPECT_EQ(wrong.rightCols(3).cwiseAbs().maxCoeff(), 0.0);
      EXPECT_EQ(wrong.bottomRows(3).cwiseAbs().maxCoeff(), 0.0);
    }
  }
}

TEST_P(DenseKernels, FactorAndSolveAgreeWithEigen) {
  Random random(28);
  for (const int k : {1, 2, 6, 7, 12, 30, 96, 97, 250}) {
    const MatXX root = RandomMatrix(k, k, &random);
    const MatXX A = root * root.transpose() + k * MatXX::Identity(k, k);
    MatXX L = MatXX::Zero(k + 2, k + 25);
    L.topLeftCorner(k, k) = A.triangularView<Eigen::Lower>();
    ASSERT_TRUE(kernels::Factor(k, L.data(), k + 2, VecX(VecX::Zero(k)).data()));
    L = MatXX(L.topLeftCorner(k, k).triangularView<Eigen::Lower>());
    EXPECT_LT((L * L.transpose() - A).cwiseAbs().maxCoeff(), 1e-14 * A.maxCoeff()) << k;

    for (const int m : {1, 7, 8, 33}) {
      const MatXX X = RandomMatrix(m, k, &random);
      MatXX Y = MatXX::Zero(m + 1, k + 25);
      Y.topLeftCorner(m, k) = X;
      kernels::SolveRows(m, k, L.data(), k, Y.data(), m + 1);
      EXPECT_LT((Y.topLeftCorner(m, k) * L.transpose() - X).cwiseAbs().maxCoeff(), 1e-13) << m << ' ' << k;
      EXPECT_EQ(Y.bottomRows(1).cwiseAbs().maxCoeff(), 0.0);
    }

    MatXX indefinite = MatXX::Zero(k, k + 25);
    indefinite.leftCols(k) = A;
    indefinite(k - 1, k - 1) = -1.0;
    EXPECT_FALSE(kernels::Factor(k, indefinite.data(), k, VecX(VecX::Zero(k)).data()));
  }
}

INSTANTIATE_TEST_SUITE_P(All, DenseKernels, testing::Values("AVX-512", "AVX2", "portable"), [](const auto& info) {
  std::string name = info.param;
  name.erase(std::remove(name.begin(), name.end(), '-'), name.end());
  return name;
});

}  // namespace
}  // namespace ch5
