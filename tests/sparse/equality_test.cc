// Both rooms on the same scenes: the dense one is the oracle.
#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>

#include "ch5_backend/dense/plain_block_solver.h"
#include "ch5_backend/dense/problem.h"
#include "ch5_backend/sparse/sparse_optimizer.h"
#include "ch5_backend/world/simulate/random.h"
#include "tests/scenes.h"

namespace ch5::test {
namespace {

using DynamicSolver = BlockSolver<Eigen::Dynamic, Eigen::Dynamic>;

double RelativeError(const MatXX& actual, const MatXX& expected) {
  if (actual.rows() != expected.rows() || actual.cols() != expected.cols()) return INFINITY;
  return expected.size() == 0 ? 0.0 : (actual - expected).norm() / std::max(expected.norm(), 1e-300);
}

VecX RandomVector(int size) {
  Random random(3);
  VecX v(size);
  for (int i = 0; i < size; ++i) v[i] = random.Normal();
  return v;
}

// All systems of one scene, each with its own copy of the graph. The first is the oracle.
class Rooms : public testing::TestWithParam<Scene> {
 protected:
  struct Room {
    std::string name;
    std::unique_ptr<Graph> graph = std::make_unique<Graph>();
    std::unique_ptr<SparseOptimizer> optimizer;  // owner of `system` where it is the optimizer's choice
    std::unique_ptr<NormalEquations> own;
    NormalEquations* system = nullptr;
    BlockSolverBase* block = nullptr;
    Problem* dense = nullptr;
    PlainBlockSolver* plain = nullptr;
  };

  Room& Add(const std::string& name) {
    rooms_.emplace_back();
    rooms_.back().name = name;
    GetParam().build(rooms_.back().graph.get());
    return rooms_.back();
  }
  void AddDense(const std::string& name, LinearSolver solver) {
    Room& room = Add(name);
    auto problem = std::make_unique<Problem>(room.graph.get(), solver);
    room.dense = problem.get();
    room.system = problem.get();
    room.own = std::move(problem);
  }
  void AddPlain(const std::string& name) {
    Room& room = Add(name);
    auto solver = std::make_unique<PlainBlockSolver>(room.graph.get());
    solver->SetOrdering();
    room.plain = solver.get();
    room.system = solver.get();
    room.own = std::move(solver);
  }
  void AddChosen(const std::string& name, int threads, ReducedSolverType type, const IterativeOptions& options = {}) {
    Room& room = Add(name);
    room.optimizer = std::make_unique<SparseOptimizer>(room.graph.get(), threads);
    room.optimizer->SetReducedSolver(type, options);
    room.block = &room.optimizer->GetSolver();
    room.system = room.block;
  }
  void AddDynamic(const std::string& name, int threads) {
    Room& room = Add(name);
    auto solver = std::make_unique<DynamicSolver>(room.graph.get(), threads);
    room.block = solver.get();
    room.system = solver.get();
    room.own = std::move(solver);
  }

  void SetUp() override {
    AddDense("dense, LDLT", LinearSolver::kLdlt);
    AddDense("dense, PCG", LinearSolver::kPcg);
    AddChosen("block, 1 thread", 1, ReducedSolverType::kDenseCholesky);
    AddChosen("block, 2 threads", 2, ReducedSolverType::kDenseCholesky);
    AddChosen("block, sparse Cholesky", 2, ReducedSolverType::kSparseCholesky);
    AddChosen("block, PCG", 1, ReducedSolverType::kPcg);
    AddChosen("block, implicit PCG", 2, ReducedSolverType::kImplicitPcg, IterativeOptions::Exact());
    AddChosen("block, power series", 1, ReducedSolverType::kPowerSeries, IterativeOptions::Exact());
    AddPlain("plain blocks");
    AddDynamic("dynamic block, 1 thread", 1);
    AddDynamic("dynamic block, 3 threads", 3);
  }

  std::vector<Room> rooms_;
};

TEST_P(Rooms, AgreeOnHessianAndGradient) {
  Problem& oracle = *rooms_[0].dense;
  oracle.MakeHessian();
  const VecX v = RandomVector(oracle.Size());
  for (Room& room : rooms_) {
    SCOPED_TRACE(room.name);
    ASSERT_EQ(room.system->Size(), oracle.Size());
    room.system->MakeHessian();
    EXPECT_LT(RelativeError(room.system->RightHandSide(), oracle.RightHandSide()), 1e-12);
    EXPECT_LT(RelativeError(room.system->HessianDiagonal(), oracle.HessianDiagonal()), 1e-12);
    EXPECT_LT(RelativeError(room.system->MultiplyHessian(v), oracle.MultiplyHessian(v)), 1e-12);
    EXPECT_NEAR(room.system->ComputeChi(), oracle.ComputeChi(), 1e-12 * oracle.ComputeChi());
    EXPECT_NEAR(room.system->StateNorm(), oracle.StateNorm(), 1e-12 * oracle.StateNorm());
    if (room.block) {
      EXPECT_LT(RelativeError(room.block->DenseHessian(), oracle.Hessian()), 1e-12);
    }
    if (room.plain) {
      EXPECT_LT(RelativeError(room.plain->DenseHessian(), oracle.Hessian()), 1e-12);
    }
  }
}

TEST_P(Rooms, AgreeOnSchurComplementAndStep) {
  Problem& oracle = *rooms_[0].dense;
  for (Room& room : rooms_) room.system->MakeHessian();
  const double largest = oracle.HessianDiagonal().maxCoeff();
  for (const Damping damping : {Damping::kIdentity, Damping::kDiagonal}) {
    const double scale = damping == Damping::kIdentity ? largest : 1.0;
    for (const double lambda : {0.0, 1e-5 * scale, 1e-2 * scale, 10.0 * scale}) {
      if (lambda == 0.0 && GetParam().has_gauge_freedom) continue;
      SCOPED_TRACE("lambda = " + std::to_string(lambda));
      oracle.SetDamping(damping);
      VecX expected;
      ASSERT_TRUE(oracle.SolveLinearSystem(lambda, &expected));
      // The rooms sum in other orders: their steps differ by rounding times the condition of the damped system.
      MatXX H = oracle.Hessian();
      for (int i = 0; i < H.rows(); ++i) H(i, i) += lambda * oracle.DampingEntry(H(i, i));
      const VecX d = H.diagonal().cwiseSqrt().cwiseInverse();
      const VecX S = Eigen::SelfAdjointEigenSolver<MatXX>(d.asDiagonal() * H * d.asDiagonal()).eigenvalues();
      const double tolerance = std::max(1e-10, 1e-14 * S.maxCoeff() / S.minCoeff());
      for (Room& room : rooms_) {
        SCOPED_TRACE(room.name);
        room.system->SetDamping(damping);
        VecX step;
        ASSERT_TRUE(room.system->SolveLinearSystem(lambda, &step));
        EXPECT_LT(RelativeError(d.cwiseInverse().asDiagonal() * step, d.cwiseInverse().asDiagonal() * expected),
                  tolerance);
        EXPECT_NEAR(room.system->PredictedDecrease(step), oracle.PredictedDecrease(expected),
                    tolerance * oracle.PredictedDecrease(expected));
        if (room.block && !room.block->IsImplicit() && oracle.GetOrdering().dim_landmarks > 0) {
          EXPECT_LT(RelativeError(room.block->SchurComplement(), oracle.SchurComplement()), 1e-10);
        }
      }
    }
  }
}

TEST_P(Rooms, AgreeOnWholeRuns) {
  for (const Algorithm algorithm : {Algorithm::kLevenbergMarquardt, Algorithm::kDogleg, Algorithm::kGaussNewton}) {
    if (GetParam().has_gauge_freedom && algorithm != Algorithm::kLevenbergMarquardt) continue;
    SolveOptions options;
    options.algorithm = algorithm;
    options.max_iterations = 6;                            // a slow descent magnifies rounding from step to step
    if (GetParam().has_gauge_freedom) options.tau = 1e-2;  // a gauge held by λ₀ alone would magnify rounding by 1/τ
    Summary expected;
    for (Room& room : rooms_) {
      SCOPED_TRACE(room.name + ", algorithm " + std::to_string(static_cast<int>(algorithm)));
      Graph fresh;
      GetParam().build(&fresh);
      for (size_t i = 0; i < fresh.Vertices().size(); ++i) {
        room.graph->Vertices()[i]->Parameters() = fresh.Vertices()[i]->Parameters();
      }
      const Summary summary = Minimize(room.system, options);
      if (&room == &rooms_[0]) expected = summary;
      ASSERT_EQ(summary.trace.size(), expected.trace.size()) << summary.message << "; " << expected.message;
      EXPECT_EQ(summary.termination, expected.termination);
      for (size_t k = 0; k < summary.trace.size(); ++k) {
        EXPECT_NEAR(summary.trace[k].cost, expected.trace[k].cost, 1e-10 * expected.trace[k].cost) << "iteration " << k;
      }
    }
  }
}

TEST_P(Rooms, DoNotDependOnTheNumberOfThreads) {
  std::vector<VecX> steps;
  std::vector<Summary> summaries;
  for (const int threads : {1, 2, 3}) {
    Graph graph;
    GetParam().build(&graph);
    SparseOptimizer optimizer(&graph, threads);
    BlockSolverBase& solver = optimizer.GetSolver();
    solver.MakeHessian();
    VecX step;
    ASSERT_TRUE(solver.SolveLinearSystem(1e-3, &step));
    steps.push_back(step);
    summaries.push_back(optimizer.Solve());
    EXPECT_EQ(steps.back(), steps.front());
    ASSERT_EQ(summaries.back().trace.size(), summaries.front().trace.size());
    for (size_t k = 0; k < summaries.back().trace.size(); ++k) {
      EXPECT_EQ(summaries.back().trace[k].cost, summaries.front().trace[k].cost);
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Scenes, Rooms, testing::ValuesIn(AllScenes()),
                         [](const testing::TestParamInfo<Scene>& info) { return info.param.name; });

}  // namespace
}  // namespace ch5::test
