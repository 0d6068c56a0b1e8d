// Problems with known answers, by each algorithm, with the dense and with the sparse solver.
#include <gtest/gtest.h>

#include <cmath>
#include <tuple>

#include "ch5_backend/dense/problem.h"
#include "ch5_backend/simulate/random.h"
#include "ch5_backend/sparse/sparse_optimizer.h"
#include "ch5_backend/types/edge_curve_fitting.h"

namespace ch5::test {
namespace {

class KnownAnswers : public testing::TestWithParam<std::tuple<Algorithm, bool>> {
 protected:
  Summary Solve(Graph* graph, SolveOptions options) {
    options.algorithm = std::get<0>(GetParam());
    return std::get<1>(GetParam()) ? SparseOptimizer(graph).Solve(options) : Problem(graph).Solve(options);
  }
};

// r = a·x − c, linear.
class LineEdge : public SizedEdge<1, VertexVector<3>> {
 public:
  LineEdge(std::shared_ptr<VertexVector<3>> x, const Vec3& a, double c) : SizedEdge(std::move(x)), a_(a), c_(c) {}
  void ComputeResidual() override { r_[0] = a_.dot(GetVertex<0>().GetEstimate()) - c_; }
  void ComputeJacobians() override { J<0>() = a_.transpose(); }
  std::string TypeInfo() const override { return "LineEdge"; }

 private:
  Vec3 a_;
  double c_;
};

TEST_P(KnownAnswers, ALinearProblemTakesOneStep) {
  Random random(4);
  Graph graph;
  auto x = std::make_shared<VertexVector<3>>(Vec3(5, -3, 8));
  graph.AddVertex(x);
  MatXX A(10, 3);
  VecX c(10);
  for (int i = 0; i < 10; ++i) {
    for (int k = 0; k < 3; ++k) A(i, k) = random.Normal();
    c[i] = random.Normal();
    graph.AddEdge(std::make_shared<LineEdge>(x, A.row(i).transpose(), c[i]));
  }
  SolveOptions options;
  options.max_iterations = 1;
  options.tau = 0.0;  // Levenberg-Marquardt without damping is Gauss-Newton
  Solve(&graph, options);
  const VecX expected = (A.transpose() * A).inverse() * (A.transpose() * c);
  EXPECT_LT((x->GetEstimate() - expected).norm(), 1e-12);
}

// Beside the first gradient of the heavy edge, 1e10, those of the others are as nothing, and yet they are to be minimized.
TEST_P(KnownAnswers, AHeavyEdgeDoesNotEndTheRun) {
  Graph graph;
  auto x = std::make_shared<VertexVector<3>>(Vec3(2, 0, 0));
  graph.AddVertex(x);
  const auto add = [&](const Vec3& a, double c, double information) {
    auto edge = std::make_shared<LineEdge>(x, a, c);
    edge->SetInformation(MatXX::Constant(1, 1, information));
    graph.AddEdge(edge);
  };
  add({1, 0, 0}, 1.0, 1e10);
  add({-1, 1, 0}, 2.0, 1.0);
  add({0, -1, 1}, 2.0, 1.0);
  SolveOptions options;
  options.max_iterations = 100;
  const Summary summary = Solve(&graph, options);
  EXPECT_TRUE(IsConverged(summary.termination)) << summary.message;
  EXPECT_LT((x->GetEstimate() - Vec3(1, 3, 5)).norm(), 1e-3) << summary.message;
}

// The heavy edge ties two unknowns to each other: neither promises anything alone, but both together do.
TEST(SparseOptimizer, AHeavyTieDoesNotEndTheRun) {
  Graph graph;
  auto x = std::make_shared<VertexVector<3>>(Vec3(3, 7, 0));
  graph.AddVertex(x);
  const auto add = [&](const Vec3& a, double c, double information) {
    graph.AddEdge(std::make_shared<LineEdge>(x, a, c));
    graph.Edges().back()->SetIsotropicInformation(information);
  };
  add({-1, 1, 0}, 1.0, 1e14);
  add({1, 0, 0}, 0.0, 1.0);
  add({0, 0, 1}, 2.0, 1.0);
  const Summary summary = SparseOptimizer(&graph).Solve();
  EXPECT_TRUE(IsConverged(summary.termination)) << summary.message;
  EXPECT_LT((x->GetEstimate() - Vec3(0, 1, 2)).norm(), 1e-6) << summary.message;
}

TEST_P(KnownAnswers, CurveFitting) {
  Random random(1);
  Graph graph;
  auto abc = std::make_shared<VertexVector<3>>(Vec3::Zero());
  graph.AddVertex(abc);
  for (int i = 0; i < 100; ++i) {
    const double x = i / 100.0;
    graph.AddEdge(std::make_shared<EdgeCurveFitting>(abc, x, std::exp((x + 2.0) * x + 1.0) + random.Normal()));
  }
  SolveOptions options;
  options.max_iterations = 50;
  options.cost_tolerance = 1e-12;
  const Summary summary = Solve(&graph, options);
  EXPECT_TRUE(IsConverged(summary.termination)) << summary.message;
  // 97 degrees of freedom of unit noise: ½χ² = 48.5 ± 7; the parameters' own σ are about 0.07, 0.1 and 0.04.
  EXPECT_NEAR(summary.final_cost, 48.5, 21.0);
  EXPECT_LT((abc->GetEstimate() - Vec3(1, 2, 1)).norm(), 0.4);
}

// Powell's singular function (Moré, Garbow, Hillstrom 1981, no. 13): the Jacobian loses rank at the solution 0.
class PowellEdge : public SizedEdge<4, VertexVector<4>> {
 public:
  explicit PowellEdge(std::shared_ptr<VertexVector<4>> x) : SizedEdge(std::move(x)) {}
  void ComputeResidual() override {
    const Eigen::Vector4d& x = GetVertex<0>().GetEstimate();
    const double u = x[1] - 2.0 * x[2], v = x[0] - x[3];
    r_ << x[0] + 10.0 * x[1], std::sqrt(5.0) * (x[2] - x[3]), u * u, std::sqrt(10.0) * v * v;
  }
  void ComputeJacobians() override {
    const Eigen::Vector4d& x = GetVertex<0>().GetEstimate();
    const double u = x[1] - 2.0 * x[2], v = 2.0 * std::sqrt(10.0) * (x[0] - x[3]), w = std::sqrt(5.0);
    J<0>() << 1, 10, 0, 0, 0, 0, w, -w, 0, 2 * u, -4 * u, 0, v, 0, 0, -v;
  }
  std::string TypeInfo() const override { return "PowellEdge"; }
};

TEST_P(KnownAnswers, PowellsSingularFunction) {
  Graph graph;
  auto x = std::make_shared<VertexVector<4>>(Eigen::Vector4d(3, -1, 0, 1));
  graph.AddVertex(x);
  graph.AddEdge(std::make_shared<PowellEdge>(x));
  SolveOptions options;
  options.max_iterations = 100;
  options.cost_tolerance = options.step_tolerance = 0.0;
  options.gradient_tolerance = 1e-20;
  const Summary summary = Solve(&graph, options);
  EXPECT_DOUBLE_EQ(summary.initial_cost, 107.5);
  EXPECT_LT(summary.final_cost, 1e-16) << summary.message;
  EXPECT_LT(x->GetEstimate().cwiseAbs().maxCoeff(), 1e-4);  // the cost is of fourth order in x
}

std::string NameOf(const testing::TestParamInfo<std::tuple<Algorithm, bool>>& info) {
  constexpr const char* kAlgorithms[] = {"GaussNewton", "LevenbergMarquardt", "Dogleg"};
  const auto [algorithm, sparse] = info.param;
  return std::string(kAlgorithms[static_cast<int>(algorithm)]) + (sparse ? "Sparse" : "Dense");
}

INSTANTIATE_TEST_SUITE_P(Algorithms, KnownAnswers,
                         testing::Combine(testing::Values(Algorithm::kGaussNewton, Algorithm::kLevenbergMarquardt,
                                                          Algorithm::kDogleg),
                                          testing::Bool()),
                         NameOf);

}  // namespace
}  // namespace ch5::test
