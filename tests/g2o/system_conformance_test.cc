// What g2o promises of its BlockSolver: H and b, their structure, damping, the file of H. optimizer_conformance_test.cc lists all rows.
#include <gtest/gtest.h>

#include <map>
#include <sstream>

#include "ch5_backend/sparse/save_hessian.h"
#include "ch5_backend/sparse/sparse_optimizer.h"
#include "ch5_backend/types/edge_se3_prior.h"
#include "ch5_backend/types/pose_graph/edge_between.h"
#include "tests/g2o/bundle.h"
#include "tests/g2o/point_chain.h"
#include "tests/graph_error.h"

namespace ch5::test {
namespace {

TEST(G2o, G3_ShuffledInsertionGivesTheSameBits) {
  for (const int threads : {1, 2}) {
    Bundle ordered(8, 90), shuffled(8, 90, 1.0, 0.02, /*shuffled=*/true);
    SparseOptimizer a(&ordered.graph, threads), b(&shuffled.graph, threads);
    a.GetSolver().MakeHessian();
    b.GetSolver().MakeHessian();
    EXPECT_EQ(a.GetSolver().RightHandSide(), b.GetSolver().RightHandSide());
    EXPECT_EQ(a.GetSolver().DenseHessian(), b.GetSolver().DenseHessian());
    const Summary of_a = a.Solve(), of_b = b.Solve();
    ASSERT_EQ(of_a.trace.size(), of_b.trace.size());
    for (size_t k = 0; k < of_a.trace.size(); ++k) EXPECT_EQ(of_a.trace[k].cost, of_b.trace[k].cost);
    for (size_t i = 0; i < ordered.truth.size(); ++i) {
      EXPECT_EQ(VecX(ordered.graph.Vertices()[i]->Parameters()), VecX(shuffled.graph.Vertices()[i]->Parameters()));
    }
  }
}

TEST(G2o, G4_AnEdgeBetweenLandmarksIsAnErrorThatNamesBoth) {
  Bundle bundle(4, 10);
  bundle.graph.AddEdge(std::make_shared<PointDifference>(bundle.points[2], bundle.points[5], Vec3::Zero()));
  SparseOptimizer optimizer(&bundle.graph);
  ASSERT_TRUE(optimizer.InitializeOptimization()) << "the structure is allowed; solving it is not";
  ExpectGraphError([&] { optimizer.Optimize(3); }, "PointDifference 30");
  ExpectGraphError([&] { optimizer.Optimize(3); }, "VertexPointXYZ 6 and VertexPointXYZ 9");
  bundle.points[5]->SetFixed();  // then it ties one free landmark only
  EXPECT_TRUE(IsConverged(optimizer.Solve().termination));
  bundle.points[5]->SetFixed(false);
  bundle.points[5]->SetRole(Role::kPose);  // or the landmark is not eliminated
  EXPECT_TRUE(IsConverged(optimizer.Solve().termination));
}

// The same edge, as if it had brought no Jacobians of its own.
template <typename EdgeType>
class WithoutJacobians : public EdgeType {
 public:
  using EdgeType::EdgeType;
  void ComputeJacobians() override { this->ComputeJacobiansNumerically(); }
  void Linearize() override {
    this->ComputeResidual();
    ComputeJacobians();
  }
};

template <typename EdgeType, typename... Arguments>
void ExpectNumericJacobians(const Arguments&... arguments) {
  EdgeType analytic(arguments...);
  WithoutJacobians<EdgeType> numeric(arguments...);
  analytic.Linearize();
  numeric.Linearize();
  EXPECT_TRUE(numeric.HasNumericJacobians());
  EXPECT_FALSE(analytic.HasNumericJacobians());
  for (size_t i = 0; i < analytic.Vertices().size(); ++i) {
    const double scale = std::max(1.0, analytic.Jacobian(i).cwiseAbs().maxCoeff());
    EXPECT_LT((analytic.Jacobian(i) - numeric.Jacobian(i)).cwiseAbs().maxCoeff(), 1e-6 * scale) << analytic.TypeInfo();
  }
}

TEST(G2o, G5_NumericJacobiansAgreeWithAnalyticOnes) {
  const auto a = std::make_shared<VertexPose>(ExpSO3({0.3, -0.2, 0.5}), Vec3(0.1, 0.2, 0.3));
  const auto b = std::make_shared<VertexPose>(ExpSO3({-0.1, 0.4, 0.2}), Vec3(1.1, -0.2, 0.1));
  const auto point = std::make_shared<VertexPointXYZ>(Vec3(0.4, -0.3, 5.0));
  const auto depth = std::make_shared<VertexInverseDepth>(0.2);
  const Qd q = ExpSO3({0.2, 0.1, -0.3});
  ExpectNumericJacobians<EdgeReprojectionXYZ>(point, a, Vec2(0.1, 0.2));
  ExpectNumericJacobians<EdgeReprojection>(depth, a, b, Vec2(0.1, 0.2), Vec2(-0.2, 0.1));
  ExpectNumericJacobians<EdgeSE3Prior>(a, q, Vec3(0.3, 0.1, 0.2));
  ExpectNumericJacobians<EdgeSE3Between>(a, b, q, Vec3(0.9, -0.3, 0.1));
}

TEST(G2o, G6_EveryKernelWeighsHAndBWithItsSlope) {
  constexpr auto kIrls = LossCorrection::kIrls;
  const std::map<std::string, std::shared_ptr<LossFunction>> kernels = {
      {"Huber", std::make_shared<HuberLoss>(0.7, kIrls)},
      {"PseudoHuber", std::make_shared<PseudoHuberLoss>(0.7, kIrls)},
      {"Cauchy", std::make_shared<CauchyLoss>(0.7, kIrls)},
      {"GemanMcClure", std::make_shared<GemanMcClureLoss>(0.7, kIrls)},
      {"Welsch", std::make_shared<WelschLoss>(0.7, kIrls)},
      {"Fair", std::make_shared<FairLoss>(0.7, kIrls)},
      {"Tukey", std::make_shared<TukeyLoss>(0.7, kIrls)},
      {"Saturated", std::make_shared<SaturatedLoss>(0.7, kIrls)},
      {"Dcs", std::make_shared<DcsLoss>(0.7, kIrls)},
      {"ScaleDelta", std::make_shared<ScaleDeltaLoss>(std::make_shared<HuberLoss>(1.0, kIrls), 0.7)}};
  for (const auto& [name, kernel] : kernels) {
    for (const double length : {0.1, 0.65, 3.0}) {  // of the residual, below and above the threshold
      PointChain chain(2);
      chain.points[0]->SetFixed();
      chain.points[1]->SetEstimate(Vec3(1, length, 0));
      chain.edges[0]->SetLossFunction(kernel);
      const double slope = kernel->Evaluate(length * length)[1];
      SparseSolver solver(&chain.graph);
      solver.SetOrdering();
      solver.MakeHessian();
      EXPECT_LT((solver.DenseHessian() - slope * MatXX::Identity(3, 3)).norm(), 1e-8) << name << " at " << length;
      EXPECT_NEAR(solver.RightHandSide()[1], -slope * length, 1e-8) << name << " at " << length;
    }
  }
}

TEST(G2o, BuildStructure_TheSchurPatternIsWhichPosesShareALandmark) {
  Bundle bundle(9, 70);  // pose i shares landmarks with i ± 1 and i ± 2, no other
  SparseSolver solver(&bundle.graph);
  solver.SetOrdering();
  const SymmetricBlockMatrix& S = solver.GetEliminated().S;
  ASSERT_EQ(S.NumColumns(), 7);
  for (int j = 0; j < 7; ++j) {
    for (int i = j; i < 7; ++i) EXPECT_EQ(S.Find(i, j) >= 0, i - j <= 2) << i << ", " << j;
  }
}

TEST(G2o, SaveHessian_ReadsBackToTheSameBits) {
  Bundle bundle(4, 12);
  SparseSolver solver(&bundle.graph);
  solver.SetOrdering();
  solver.MakeHessian();
  std::stringstream file;
  SaveHessian(solver, "H", &file);
  std::string word, line;
  std::getline(file, line);
  EXPECT_EQ(line, "# name: H");
  std::getline(file, line);
  EXPECT_EQ(line, "# type: sparse matrix");
  int nnz = 0, rows = 0, columns = 0;
  file >> word >> word >> nnz >> word >> word >> rows >> word >> word >> columns;
  ASSERT_EQ(rows, solver.Size());
  ASSERT_EQ(columns, solver.Size());
  MatXX H = MatXX::Zero(rows, columns);
  int count = 0, row, column, last = 0;
  for (double value; file >> row >> column >> value; ++count) {
    H(row - 1, column - 1) = value;
    EXPECT_LT(last, column * rows + row) << "column by column";
    last = column * rows + row;
  }
  EXPECT_EQ(count, nnz);
  EXPECT_EQ(H, solver.DenseHessian());
  EXPECT_EQ(nnz, (H.array() != 0.0).count());
}

}  // namespace
}  // namespace ch5::test
