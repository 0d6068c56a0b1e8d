// Steps of each landmark alone, against the same steps edge by edge.
#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <limits>

#include "ch5_backend/graph/loss.h"
#include "ch5_backend/math/median.h"
#include "ch5_backend/sparse/sparse_optimizer.h"
#include "ch5_backend/sparse/sparse_solver.h"
#include "tests/scenes.h"

namespace ch5::test {
namespace {

std::vector<VecX> Parameters(const Graph& graph) {
  std::vector<VecX> all;
  for (const auto& vertex : graph.Vertices()) all.push_back(vertex->Parameters());
  return all;
}

struct Case {
  std::string scene;
  bool has_losses;
};
void PrintTo(const Case& one, std::ostream* out) { *out << one.scene << (one.has_losses ? " with losses" : ""); }

// A scene; with losses, of which half of the residuals feel something.
void Build(const Case& one, Graph* graph) {
  SceneNamed(one.scene).build(graph);
  if (!one.has_losses) return;
  std::vector<Edge*> edges;
  std::vector<double> squares;
  for (const auto& edge : graph->Edges()) {
    if (edge->ResidualDimension() != 2) continue;
    edge->ComputeResidual();
    edges.push_back(edge.get());
    squares.push_back(edge->Chi2());
  }
  const double delta = std::sqrt(Median(squares));
  const std::shared_ptr<LossFunction> losses[] = {std::make_shared<CauchyLoss>(delta),
                                                  std::make_shared<HuberLoss>(delta), nullptr};
  for (size_t e = 0; e < edges.size(); ++e) edges[e]->SetLossFunction(losses[e % 3]);
}

class RefineLandmarks : public testing::TestWithParam<Case> {
 protected:
  void SetUp() override {
    Build(GetParam(), &graph_);
    solver_.SetOrdering();
  }

  Graph graph_;
  SparseSolver solver_{&graph_};
};

// Σ ρ'JᵀWJ δ = −Σ ρ'JᵀWr over the landmark's edges.
VecX StepOf(const std::vector<Edge*>& edges, const Vertex& landmark) {
  const int dim = landmark.LocalDimension();
  MatXX H = MatXX::Zero(dim, dim);
  VecX b = VecX::Zero(dim);
  for (Edge* edge : edges) {
    edge->Linearize();
    size_t position = 0;
    while (edge->Vertices()[position].get() != &landmark) ++position;
    const MatXX J = edge->Jacobian(position), JtW = J.transpose() * edge->Information();
    const VecX r = edge->Residual();
    const LossFunction* loss = edge->GetLossFunction();
    const double slope = loss ? loss->Evaluate(r.dot(edge->Information() * r))[1] : 1.0;
    H += slope * (JtW * J);
    b -= slope * (JtW * r);
  }
  return H.ldlt().solve(b);
}

double CostOf(const std::vector<Edge*>& edges) {
  double cost = 0.0;
  for (Edge* edge : edges) {
    edge->ComputeResidual();
    cost += edge->Cost();
  }
  return cost;
}

TEST_P(RefineLandmarks, TakesGaussNewtonStepsOfEachAlone) {
  const std::vector<VecX> start = Parameters(graph_);
  solver_.RefineLandmarks(1);
  const std::vector<VecX> moved = Parameters(graph_);
  for (size_t i = 0; i < start.size(); ++i) graph_.Vertices()[i]->Parameters() = start[i];
  int steps = 0;
  for (size_t i = 0; i < start.size(); ++i) {
    Vertex& vertex = *graph_.Vertices()[i];
    if (vertex.GetRole() != Role::kLandmark || vertex.IsFixed()) {
      EXPECT_EQ(moved[i], start[i]) << "poses stay";
      continue;
    }
    std::vector<Edge*> edges;
    for (const auto& edge : graph_.Edges()) {
      for (const auto& one : edge->Vertices())
        if (one.get() == &vertex) edges.push_back(edge.get());
    }
    const double before = CostOf(edges);
    const VecX delta = StepOf(edges, vertex);
    vertex.Plus(delta.data());
    const bool is_better = CostOf(edges) < before;
    if (moved[i] == start[i]) {
      vertex.Parameters() = start[i];
      continue;
    }
    ++steps;
    EXPECT_TRUE(is_better);
    EXPECT_LT((vertex.Parameters() - moved[i]).norm(), 1e-9 * (1.0 + moved[i].norm())) << i;
    vertex.Parameters() = start[i];
  }
  EXPECT_GT(steps, 0);
}

TEST_P(RefineLandmarks, LowersTheCostByAtLeastWhatItSays) {
  double cost = solver_.Cost();
  for (int call = 0; call < 3; ++call) {
    const double decrease = solver_.RefineLandmarks(2), now = solver_.Cost();
    EXPECT_GE(decrease, 0.0);
    EXPECT_GE(cost - now, decrease - 1e-9 * cost);
    cost = now;
  }
}

TEST_P(RefineLandmarks, GivesTheSameBitsForAnyNumberOfThreads) {
  Graph graph;
  Build(GetParam(), &graph);
  SparseSolver solver(&graph, 3);
  solver.SetOrdering();
  EXPECT_EQ(solver.RefineLandmarks(2), solver_.RefineLandmarks(2));
  EXPECT_EQ(Parameters(graph), Parameters(graph_));
}

TEST_P(RefineLandmarks, IsRolledBackWithTheStep) {
  const std::vector<VecX> before = Parameters(graph_);
  solver_.UpdateStates(VecX::Constant(solver_.Size(), 1e-6));
  EXPECT_GT(solver_.RefineLandmarks(1), 0.0);
  solver_.RollbackStates();
  EXPECT_EQ(Parameters(graph_), before);
}

TEST_P(RefineLandmarks, EndsOnceNoLandmarkMoves) {
  EXPECT_GT(solver_.RefineLandmarks(std::numeric_limits<int>::max()), 0.0);
  EXPECT_LT(solver_.RefineLandmarks(1), 1e-9 * solver_.Cost());
}

TEST_P(RefineLandmarks, LeadsToTheSameMinimum) {
  Graph graph;
  Build(GetParam(), &graph);
  SolveOptions options;
  options.max_iterations = 50;
  options.cost_tolerance = 1e-12;
  const Summary plain = SparseOptimizer(&graph).Solve(options);
  options.landmark_steps = 2;
  const Summary refined = SparseOptimizer(&graph_).Solve(options);
  EXPECT_NEAR(refined.final_cost, plain.final_cost, 1e-8 * plain.final_cost);
  EXPECT_LE(refined.trace[1].cost, plain.trace[1].cost) << "after the first iteration";
}

INSTANTIATE_TEST_SUITE_P(Scenes, RefineLandmarks,
                         testing::Values(Case{"Mono3x20Fixed", false}, Case{"Mono10x50Fixed", false},
                                         Case{"Mono10x50Priors", false}, Case{"Mono10x50Priors", true},
                                         Case{"Bal", false}, Case{"Bal", true}),
                         [](const auto& info) {
                           return info.param.scene + (info.param.has_losses ? "WithLosses" : "");
                         });

TEST(RefineLandmarksTest, LeavesLandmarksOutsideOfBatches) {
  Graph graph;
  Build({"PointsWithCorrelatedNoise", false}, &graph);
  SparseSolver solver(&graph);
  solver.SetOrdering();
  const std::vector<VecX> before = Parameters(graph);
  EXPECT_EQ(solver.RefineLandmarks(2), 0.0);
  EXPECT_EQ(Parameters(graph), before);
}

}  // namespace
}  // namespace ch5::test
