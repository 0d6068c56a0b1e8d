#include "ch5_backend/linear/reduced_solver.h"

#include <gtest/gtest.h>

#include <limits>
#include <vector>

#include "tests/linear/block_matrices.h"

namespace ch5::test {
namespace {

constexpr ReducedSolverType kExplicit[] = {ReducedSolverType::kAutomatic, ReducedSolverType::kDenseCholesky,
                                           ReducedSolverType::kSparseCholesky, ReducedSolverType::kPcg};

TEST(ReducedSolver, EveryOneGivesTheSameAnswer) {
  for (const SymmetricBlockMatrix& A : Matrices()) {
    const VecX b = RandomVector(A.Size(), 21), expected = SolveByEigen(A, b);
    for (const auto type : kExplicit) {
      const auto solver = MakeReducedSolver(type);
      solver->Prepare(A, nullptr);
      VecX x;
      ASSERT_TRUE(solver->Solve(A, b, A.Diagonal(), &x));
      EXPECT_LT((x - expected).norm(), 1e-12 * expected.norm()) << static_cast<int>(type);
    }
  }
}

// A chain whose ends are free is singular: the last pivot is rounding, and the solver's measure must see it.
TEST(ReducedSolver, RoundingIsNotAPivot) {
  std::vector<std::vector<int>> rows;
  for (int j = 0; j < 400; ++j) rows.push_back(j + 1 < 400 ? std::vector<int>{j, j + 1} : std::vector<int>{j});
  SymmetricBlockMatrix A;
  A.SetPattern(Array<int>(400, 1), rows);
  for (int j = 0; j < 400; ++j) {
    A.Values(A.ColumnBegin(j))[0] = j == 0 || j == 399 ? 0.1 : 0.2;
    if (j < 399) A.Values(A.ColumnBegin(j) + 1)[0] = -0.1;
  }
  for (const auto type :
       {ReducedSolverType::kAutomatic, ReducedSolverType::kDenseCholesky, ReducedSolverType::kSparseCholesky}) {
    const auto solver = MakeReducedSolver(type);
    solver->Prepare(A, nullptr);
    VecX x;
    EXPECT_FALSE(solver->Solve(A, VecX::Ones(400), A.Diagonal(), &x));
  }
}

TEST(ReducedSolver, IndefiniteSystemsAreRefusedAndLeaveNothingBehind) {
  const SymmetricBlockMatrix good = MakeMatrix(MixedDims(30), Chain(30), 33);
  const VecX b = RandomVector(good.Size(), 34), expected = SolveByEigen(good, b);
  for (const auto type : kExplicit) {
    const auto solver = MakeReducedSolver(type);
    solver->Prepare(good, nullptr);
    VecX x;
    for (const double bad : {-5.0, std::numeric_limits<double>::quiet_NaN()}) {
      SymmetricBlockMatrix A = good;
      A.Values(A.ColumnBegin(20))[0] = bad;
      EXPECT_FALSE(solver->Solve(A, b, good.Diagonal(), &x)) << static_cast<int>(type) << ", " << bad;
    }
    ASSERT_TRUE(solver->Solve(good, b, good.Diagonal(), &x));
    EXPECT_LT((x - expected).norm(), 1e-12 * expected.norm()) << static_cast<int>(type);
  }
}

TEST(ReducedSolver, TakesOnePatternAfterAnother) {
  for (const auto type : kExplicit) {
    const auto solver = MakeReducedSolver(type);
    for (const Ties& ties : {Chain(49), Everything(49), Grid(7)}) {
      const SymmetricBlockMatrix A = MakeMatrix(std::vector<int>(49, 6), ties, 35);
      const VecX b = RandomVector(A.Size(), 36), expected = SolveByEigen(A, b);
      solver->Prepare(A, nullptr);
      VecX x;
      ASSERT_TRUE(solver->Solve(A, b, A.Diagonal(), &x));
      EXPECT_LT((x - expected).norm(), 1e-12 * expected.norm()) << static_cast<int>(type);
    }
  }
}

TEST(ReducedSolver, PcgIsAsAccurateAsItIsAsked) {
  const SymmetricBlockMatrix A = MakeMatrix(std::vector<int>(144, 6), Grid(12), 37);
  const VecX b = RandomVector(A.Size(), 38);
  const auto residual = [&](double tolerance) {
    const auto solver = MakeBlockPcg(tolerance);
    solver->Prepare(A, nullptr);
    VecX x, Ax(A.Size());
    EXPECT_TRUE(solver->Solve(A, b, A.Diagonal(), &x));
    A.Multiply(x.data(), Ax.data());
    return (b - Ax).norm() / b.norm();
  };
  EXPECT_LT(residual(1e-2), 1e-2);
  EXPECT_GT(residual(1e-2), 1e-8) << "it stops there";
  EXPECT_LT(residual(1e-8), 1.001e-8);
}

// On  4x₀ + 2x₁ = 8,  2x₀ + 5x₁ = 16;  and on a matrix that is not positive definite.
TEST(ReducedSolver, SolvesAHandWorkedSystem) {
  SymmetricBlockMatrix A;
  A.SetPattern({1, 1}, {{0, 1}, {1}});
  const auto fill = [&A](double a00, double a10, double a11) {
    const double values[] = {a00, a10, a11};
    for (int block = 0; block < 3; ++block) A.Values(block)[0] = values[block];
  };
  const VecX b = Vec2(8.0, 16.0);
  std::vector<std::unique_ptr<ReducedSolver>> solvers;
  for (const auto type : kExplicit) solvers.push_back(MakeReducedSolver(type));
  solvers.push_back(MakePseudoInverse(0));
  for (const auto& solver : solvers) {
    fill(4.0, 2.0, 5.0);
    solver->Prepare(A, nullptr);
    VecX x;
    ASSERT_TRUE(solver->Solve(A, b, A.Diagonal(), &x));
    EXPECT_LT((x - Vec2(0.5, 3.0)).norm(), 1e-14);
    fill(4.0, 2.0, -5.0);
    EXPECT_FALSE(solver->Solve(A, b, Vec2(4.0, 5.0), &x));
  }
}

// Of  x₀ − x₁ = 1,  −x₀ + x₁ = −1  the shortest solution.
TEST(ReducedSolver, ThePseudoInverseMovesNothingAlongTheGauge) {
  SymmetricBlockMatrix A;
  A.SetPattern({1, 1}, {{0, 1}, {1}});
  for (int block = 0; block < 3; ++block) A.Values(block)[0] = block == 1 ? -1.0 : 1.0;
  const auto solver = MakePseudoInverse(1);
  solver->Prepare(A, nullptr);
  VecX x;
  ASSERT_TRUE(solver->Solve(A, Vec2(1.0, -1.0), A.Diagonal(), &x));
  EXPECT_LT((x - Vec2(0.5, -0.5)).norm(), 1e-15);
}

TEST(ReducedSolver, ManyPosesTiedByLandmarksAloneAreSolvedImplicitly) {
  using Type = ReducedSolverType;
  EXPECT_EQ(ChooseReducedSolver(Type::kAutomatic, 401, true), Type::kPowerSeries);
  EXPECT_EQ(ChooseReducedSolver(Type::kAutomatic, 400, true), Type::kAutomatic);
  EXPECT_EQ(ChooseReducedSolver(Type::kAutomatic, 401, false), Type::kAutomatic);
  EXPECT_EQ(ChooseReducedSolver(Type::kSparseCholesky, 401, true), Type::kSparseCholesky);
}

}  // namespace
}  // namespace ch5::test
