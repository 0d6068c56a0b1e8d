#include <gtest/gtest.h>

#include <filesystem>
#include <ostream>

#include "ch5_backend/dense/problem.h"
#include "ch5_backend/experiments/studies/homework/graded_priors.h"
#include "ch5_backend/experiments/studies/window_graph.h"
#include "ch5_backend/files/tables/text_writer.h"
#include "ch5_backend/marginalize/marginalize.h"
#include "ch5_backend/marginalize/qr_elimination.h"
#include "ch5_backend/sparse/sparse_optimizer.h"
#include "ch5_backend/sparse/sparse_solver.h"
#include "tests/data_folder.h"
#include "tests/files/made_up_window.h"
#include "tests/temporary_folder.h"

namespace ch5 {
namespace {

// Reference costs by Ceres 2.1 with analytic Jacobians (½ Σ ρ): at the start, converged. Those of the made-up window, which
// is there without data, are a closed form and the dense solver's.
struct Reference {
  const char* name;
  double initial, converged;
};
void PrintTo(const Reference& reference, std::ostream* out) { *out << reference.name; }
constexpr char kMadeUp[] = "made_up";

class WindowDumps : public testing::TestWithParam<Reference> {
 protected:
  void SetUp() override {
    if (reference_.name == std::string(kMadeUp)) {
      const test::MadeUpWindow made = test::MakeWindow();
      path_ = folder_ / "made_up.txt";
      WriteFileAtomically(path_, made.text);
      reference_.initial = made.cost;
      WindowGraph window = BuildWindowGraph(ReadWindowDump(path_));
      reference_.converged = Problem(&window.graph).Solve(ToTheEnd()).final_cost;
    } else {
      path_ = DataFolder() / "windows" / (std::string(reference_.name) + ".txt");
      CH5_NEEDS(path_);
    }
  }
  static SolveOptions ToTheEnd() {
    SolveOptions options;
    options.max_iterations = 200;
    options.cost_tolerance = 1e-9;
    return options;
  }
  test::TemporaryFolder folder_;
  std::filesystem::path path_;
  Reference reference_ = GetParam();
};

// The same cost at the start proves the conventions of IMU, prior and loss.
TEST_P(WindowDumps, InitialCostIsTheReference) {
  WindowGraph window = BuildWindowGraph(ReadWindowDump(path_));
  EXPECT_NEAR(Cost(window.graph) / reference_.initial, 1.0, 1e-6);
}

TEST_P(WindowDumps, DenseAndSparseSolverAgreeOnTheFirstStep) {
  WindowGraph window = BuildWindowGraph(ReadWindowDump(path_));
  Problem dense(&window.graph);
  SparseOptimizer sparse(&window.graph);
  NormalEquations& fast = sparse.GetSolver();
  dense.MakeHessian();
  fast.MakeHessian();
  EXPECT_LT((dense.RightHandSide() - fast.RightHandSide()).norm(), 1e-10 * dense.RightHandSide().norm());
  const VecX v = VecX::LinSpaced(dense.Size(), -1.0, 1.0);
  EXPECT_LT((dense.MultiplyHessian(v) - fast.MultiplyHessian(v)).norm(), 1e-10 * dense.MultiplyHessian(v).norm());
}

TEST_P(WindowDumps, ConvergesToTheReference) {
  WindowGraph window = BuildWindowGraph(ReadWindowDump(path_));
  SparseOptimizer optimizer(&window.graph);
  optimizer.SetDamping(Damping::kDiagonal);
  const Summary summary = optimizer.Solve(ToTheEnd());
  EXPECT_LE(summary.final_cost, reference_.converged * (1.0 + 1e-4)) << summary.message;
  RecordProperty("iterations", summary.iterations);
  RecordProperty("milliseconds", std::to_string(1e3 * summary.seconds));
}

// The oldest frame marginalized in three ways is one prior: the same H and b on the same vertices.
TEST_P(WindowDumps, MarginalizingTheOldestFrameEqualsVins) {
  const WindowDump dump = ReadWindowDump(path_);
  const WindowGraph window = BuildWindowGraph(dump);
  if (dump.imu.empty()) GTEST_SKIP() << "a window without IMU";
  const auto [edges, drop] = OldestFrameOf(dump, window);
  const Prior vins = PriorByMarginalizationInfo(edges, drop)->GetPrior();
  const MatXX H = vins.J.transpose() * vins.J;
  const VecX b = vins.J.transpose() * vins.r0;
  for (const Prior& prior : {Marginalize(edges, drop), MarginalizeQr<double>(edges, drop)}) {
    ASSERT_EQ(prior.vertices, vins.vertices);
    EXPECT_LT((prior.J.transpose() * prior.J - H).norm(), 1e-6 * H.norm());
    EXPECT_LT((prior.J.transpose() * prior.r0 - b).norm(), 1e-6 * b.norm());
  }
}

// Values that no file holds: the reader refuses them (files/window_dump.h).
TEST(WindowGraph, RefusesAPriorOnSpeedsWithoutImu) {
  WindowDump dump;
  dump.frames.resize(1);
  dump.prior_blocks.push_back({WindowDump::BlockKind::kSpeedBias, 0, VecX::Zero(9)});
  dump.prior_r = VecX::Zero(1);
  dump.prior_J = MatXX::Zero(1, 9);
  EXPECT_EQ(test::Refusal<std::invalid_argument>([&] { BuildWindowGraph(dump); }),
            "the prior holds speed and biases of frame 0, but the window has no IMU");
}

INSTANTIATE_TEST_SUITE_P(, WindowDumps,
                         testing::Values(Reference{kMadeUp, 0.0, 0.0},
                                         Reference{"vio_S", 3.394001e+02, 2.799642868e+02},
                                         Reference{"vio_M", 6.118261e+02, 4.760831319e+02},
                                         Reference{"vio_L", 1.051793e+03, 8.178433323e+02},
                                         Reference{"vio_Md", 6.114825e+02, 4.757463687e+02},
                                         Reference{"real_euroc_sub2", 1.572934e+08, 2.259314504e+02},
                                         Reference{"real_tango_100", 1.587520e+10, 4.573231082e+02},
                                         Reference{"mono_3_20", 5.698152e+03, 1.868353921e+01},
                                         Reference{"mono_10_500", 3.935362e+05, 1.745162987e+03},
                                         Reference{"mono_20_1500", 2.440128e+06, 9.778462418e+03}),
                         [](const auto& test) { return std::string(test.param.name); });

}  // namespace
}  // namespace ch5
