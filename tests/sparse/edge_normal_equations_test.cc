// One edge's normal equations, by hand and against J and W.
#include "ch5_backend/sparse/steps/edge_normal_equations.h"

#include <gtest/gtest.h>

#include "ch5_backend/graph/fast_edge.h"
#include "ch5_backend/sparse/sparse_solver.h"
#include "ch5_backend/types/edge_se3_prior.h"
#include "tests/sparse/scalar_graph.h"

namespace ch5::test {
namespace {

TEST(EdgeNormalEquations, OfADistanceByHand) {
  ScalarGraph line(2, 0);
  line.Tie(line.poses[0], line.poses[1], 0.5);
  Edge& edge = *line.graph.Edges()[0];
  edge.SetInformation(MatXX::Constant(1, 1, 4.0));
  const Structure structure = BuildStructure(MakeOrdering(line.graph));
  // x_0 = 0, x_1 = 1:  r = 0.5, J = (−1, 1), W = 4.
  VecX step(1);
  step << 1.0;
  line.poses[1]->Plus(step.data());
  MatXX C = MatXX::Zero(3, 3), expected(3, 3);
  LinearizeAndMultiplyOut(structure, 0, C.data());
  expected << 4, -4, -2,  //
      -4, 4, 2,           //
      -2, 2, 1;
  EXPECT_LT((MatXX(C.triangularView<Eigen::Lower>()) - MatXX((-expected).triangularView<Eigen::Lower>())).norm(),
            1e-15);
  line.poses[1]->Plus(step.data());  // r = 1.5, which MultiplyOut alone does not see
  MatXX same = MatXX::Zero(3, 3);
  MultiplyOut(structure, 0, same.data());
  EXPECT_EQ(MatXX(same.triangularView<Eigen::Lower>()), MatXX(C.triangularView<Eigen::Lower>()));
  LinearizeAndMultiplyOut(structure, 0, C.data());
  EXPECT_DOUBLE_EQ(C(2, 2), -9.0);
  EXPECT_DOUBLE_EQ(C(2, 1), -6.0);
}

struct PriorOnAPose {
  Graph graph;
  std::shared_ptr<EdgeSE3Prior> edge;
  Structure structure;

  PriorOnAPose() {
    auto pose = std::make_shared<VertexPose>(ExpSO3({0.3, -0.2, 0.1}), Vec3(1, 2, 3));
    graph.AddVertex(pose);
    edge = std::make_shared<EdgeSE3Prior>(pose, Qd::Identity(), Vec3(0.5, 2, 3));
    MatXX W = 3.0 * MatXX::Identity(6, 6);
    W(0, 3) = W(3, 0) = 1.0;
    edge->SetInformation(W);
    graph.AddEdge(edge);
    structure = BuildStructure(MakeOrdering(graph));
  }
};

// C = −[J r]ᵀ [W_ρ J  ρ'W r].
TEST(EdgeNormalEquations, AreThoseOfJAndW) {
  const PriorOnAPose prior;
  for (const bool robust : {false, true}) {
    if (robust) prior.edge->SetLossFunction(std::make_shared<CauchyLoss>(0.7));
    MatXX C = MatXX::Zero(7, 7);
    LinearizeAndMultiplyOut(prior.structure, 0, C.data());
    double drho;
    MatXX W_rho;
    prior.edge->RobustInfo(&drho, &W_rho);
    const MatXX J = prior.edge->Jacobian(0), H = J.transpose() * W_rho * J;
    const VecX g = drho * J.transpose() * prior.edge->Information() * prior.edge->Residual();
    EXPECT_LT(
        (MatXX(C.topLeftCorner(6, 6).triangularView<Eigen::Lower>()) + MatXX(H.triangularView<Eigen::Lower>())).norm(),
        1e-13 * H.norm());
    EXPECT_LT((C.bottomLeftCorner(1, 6).transpose() + g).norm(), 1e-13 * g.norm());
  }
}

// An edge that has products of its own: r and J are constants.
class EdgeOfConstants : public SizedEdge<3, VertexVector<2>, VertexVector<3>>, public FastEdge {
 public:
  EdgeOfConstants(std::shared_ptr<VertexVector<2>> a, std::shared_ptr<VertexVector<3>> b)
      : SizedEdge(std::move(a), std::move(b)) {}
  void ComputeResidual() override { r_ = Vec3(0.5, -1.0, 2.0); }
  void ComputeJacobians() override {
    J<0>() << 1, 2, 6, 7, 11, 12;
    J<1>() << 3, 4, 5, 8, 9, 10, 14, 14, 16;
  }
  bool NegativeProductsInto(double* C) override {
    if (!has_products) return false;
    Linearize();
    MatXX J_r(3, 6);
    J_r << J<0>(), J<1>(), r_;
    // Only the lower half is promised.
    Eigen::Map<MatXX>(C, 6, 6).setConstant(std::nan(""));
    Eigen::Map<MatXX>(C, 6, 6).triangularView<Eigen::Lower>() = -J_r.transpose() * J_r;
    return true;
  }
  std::string TypeInfo() const override { return "EdgeOfConstants"; }

  bool has_products = true;
};

// Whatever the order of its vertices in H, and whichever of them is fixed.
TEST(EdgeNormalEquations, AreAddedWhereTheVerticesAre) {
  for (const bool in_order : {true, false}) {
    for (const int fixed : {-1, 0, 1}) {
      for (const bool has_products : {true, false}) {
        Graph graph;
        const auto a = std::make_shared<VertexVector<2>>(Vec2::Zero());
        const auto b = std::make_shared<VertexVector<3>>(Vec3::Zero());
        const std::vector<std::shared_ptr<Vertex>> vertices{a, b};
        for (const int k : {0, 1}) graph.AddVertex(vertices[in_order ? k : 1 - k]);
        const auto edge = std::make_shared<EdgeOfConstants>(a, b);
        edge->has_products = has_products;
        graph.AddEdge(edge);
        if (fixed >= 0) vertices[fixed]->SetFixed();
        SparseSolver solver(&graph);
        solver.SetOrdering();
        solver.MakeHessian();

        edge->Linearize();
        MatXX J(3, solver.Size());
        for (const int k : {0, 1}) {
          if (k == fixed) continue;
          J.middleCols(vertices[k]->OrderingId(), vertices[k]->LocalDimension()) = edge->Jacobian(k);
        }
        EXPECT_EQ(solver.DenseHessian(), J.transpose() * J) << in_order << fixed << has_products;
        EXPECT_EQ(solver.RightHandSide(), -J.transpose() * edge->Residual()) << in_order << fixed << has_products;
      }
    }
  }
}

}  // namespace
}  // namespace ch5::test
