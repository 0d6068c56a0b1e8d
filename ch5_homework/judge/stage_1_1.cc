/// Stage 1.1: H and b equal a dense −JᵀWr and JᵀWJ that is built in another way.
/// From simple to hard; the first failure ends the check (--gtest_fail_fast).

#include <gtest/gtest.h>

#include "ch5_backend/types/edge_reprojection.h"
#include "ch5_homework/judge/mistakes/stage_1_1_places.h"
#include "ch5_homework/judge/scenes.h"
#include "ch5_homework/judge/submission.h"

namespace ch5::homework {
namespace {

using namespace stage_1_1;

// Compares H and b of a problem whose MakeHessian has been called; `before`: its H after an earlier call.
void CheckSystem(const Graph& graph, const Problem& problem, const Text& scene, const MatXX& before = {}) {
  const System right = StackedNormalEquations(graph, problem.Size());
  const Names names = RowNames(problem.GetOrdering());
  std::vector<Mistake> mistakes = MistakesInH(graph, problem.Size());
  if (before.size() > 0) {
    mistakes.push_back({"", "1.1.H_not_zeroed", [=] { return MatXX(before + right.H); }});
  }
  if (problem.Hessian().rows() == problem.Size()) mistakes.push_back(FoundPlaces(graph, problem.Hessian()));
  ASSERT_CLAIM(
      {"1.1", {"scene.H_of", {{"what", scene}}}, right.H, problem.Hessian(), names, mistakes, 1e-10, {}, "1.1a", "H"});
  ASSERT_CLAIM({"1.1",
                {"scene.b_of", {{"what", scene}}},
                right.b,
                problem.RightHandSide(),
                names,
                MistakesInB(graph, problem.Size()),
                1e-10,
                {},
                "1.1b",
                "b"});
}

void CheckMakeHessian(Graph* graph, const Text& scene) {
  const auto problem = Chosen().make_problem(graph);
  problem->MakeHessian();
  CheckSystem(*graph, *problem, scene);
}

TEST(Stage11, OneEdgeBetweenTwoPoses) {
  Random random(Seed(11));
  Graph graph;
  const auto poses = AddPoses(&graph, 2);
  AddRandomEdge<4>(&graph, &random, poses[0], poses[1]);
  CheckMakeHessian(&graph, "1.1.one_edge_between_two_poses");
}

TEST(Stage11, EdgesOnTheSamePairAddUp) {
  Random random(Seed(12));
  Graph graph;
  const auto poses = AddPoses(&graph, 3);
  for (int k = 0; k < 3; ++k) AddRandomEdge<4>(&graph, &random, poses[0], poses[2]);
  AddRandomEdge<6>(&graph, &random, poses[2], poses[0]);  // the vertices in the other order
  AddRandomEdge<6>(&graph, &random, poses[1]);
  CheckMakeHessian(&graph, "1.1.five_edges_between_three_poses");
}

TEST(Stage11, TheSlidesChainOfThreeScalars) {
  // H = [100 −100 0; −100 136.111 −11.1111; 0 −11.1111 11.1111], the matrix that stage 2 begins with.
  class Difference : public SizedEdge<1, VertexScalar, VertexScalar> {
   public:
    Difference(std::shared_ptr<VertexScalar> a, std::shared_ptr<VertexScalar> b, double sigma)
        : SizedEdge(std::move(a), std::move(b)) {
      SetInformation(MatXX::Constant(1, 1, 1.0 / (sigma * sigma)));
    }
    void ComputeResidual() override {
      r_ = GetVertex<1>().GetEstimate() - GetVertex<0>().GetEstimate();
      r_[0] -= 1.0;
    }
    void ComputeJacobians() override {
      J<0>()(0) = -1.0;
      J<1>()(0) = 1.0;
    }
    std::string TypeInfo() const override { return "Difference"; }
  };
  Graph graph;
  const auto x =
      AddVertices<VertexScalar>(&graph, 4, [] { return std::make_shared<VertexScalar>(VertexScalar::Estimate(0.0)); });
  x[3]->SetFixed();  // the origin, from which x_1 is measured with σ = 0.2
  graph.AddEdge(std::make_shared<Difference>(x[0], x[1], 0.1));
  graph.AddEdge(std::make_shared<Difference>(x[3], x[1], 0.2));
  graph.AddEdge(std::make_shared<Difference>(x[1], x[2], 0.3));
  CheckMakeHessian(&graph, "1.1.slides_chain_three_scalars");
}

TEST(Stage11, LandmarksOfDimensionOne) {
  Random random(Seed(13));
  MonoBaOptions options;
  options.seed = Seed(options.seed);
  options.points = Vary(5, 9, 17);
  MonoBa ba;
  BuildMonoBa(SimulateMonoBa(options), Gauge::kFree, 1.0, 0.0, &ba);
  for (const auto& edge : ba.graph.Edges()) edge->SetInformation(RandomPositiveDefinite(2, &random));
  CheckMakeHessian(&ba.graph, {"1.1.poses_and_inverse_depths", {{"n", Word(options.points)}}});
}

TEST(Stage11, LandmarksOfDimensionThree) {
  Random random(Seed(14));
  Graph graph;
  const auto points = AddPoints(&graph, 2);  // smaller ids than the poses, later rows
  const auto poses = AddPoses(&graph, 3);
  const auto depths = AddInverseDepths(&graph, 1);
  for (const auto& point : points) {
    for (const auto& pose : poses) AddRandomEdge<2>(&graph, &random, point, pose);
  }
  AddRandomEdge<2>(&graph, &random, poses[1], points[1]);
  AddRandomEdge<2>(&graph, &random, depths[0], poses[0], poses[2]);
  CheckMakeHessian(&graph, "1.1.points_and_an_inverse_depth");
}

TEST(Stage11, FixedVerticesHaveNoRows) {
  Random random(Seed(15));
  Graph graph;
  const auto poses = AddPoses(&graph, 4);
  const auto points = AddPoints(&graph, 3);
  poses[0]->SetFixed();
  poses[2]->SetFixed();
  points[1]->SetFixed();
  for (const auto& point : points) {
    for (const auto& pose : poses) AddRandomEdge<2>(&graph, &random, point, pose);
  }
  AddRandomEdge<6>(&graph, &random, poses[3], poses[0], poses[1]);
  CheckMakeHessian(&graph, "1.1.some_vertices_fixed");
}

TEST(Stage11, RobustLossWeighsTheEdges) {
  Random random(Seed(16));
  Graph graph;
  const auto poses = AddPoses(&graph, 2);
  const auto points = AddPoints(&graph, 2);
  for (const auto& point : points) {
    for (const auto& pose : poses) {
      AddRandomEdge<2>(&graph, &random, point, pose);
      graph.Edges().back()->SetLossFunction(std::make_shared<CauchyLoss>(1.0));
    }
  }
  CheckMakeHessian(&graph, "1.1.cauchy_loss");
}

TEST(Stage11, SecondCallStartsAfresh) {
  MonoBaOptions options;
  options.seed = Seed(options.seed);
  options.frames = 4;
  options.points = Vary(7, 12, 18);
  MonoBa ba;
  BuildMonoBa(SimulateMonoBa(options), Gauge::kFixTwoFrames, 1.0, 0.0, &ba);
  const auto problem = Chosen().make_problem(&ba.graph);
  problem->MakeHessian();
  const MatXX before = problem->Hessian();
  problem->UpdateStates(VecX::Constant(problem->Size(), 1e-3));
  problem->MakeHessian();
  CheckSystem(ba.graph, *problem, {"1.1.second_call", {{"n", Word(options.points)}}}, before);
}

}  // namespace
}  // namespace ch5::homework
