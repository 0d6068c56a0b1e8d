/// Stage 1.1: H and b equal a dense −JᵀWr and JᵀWJ that is built in another way.
/// From simple to hard; the first failure ends the check (--gtest_fail_fast).

#include <gtest/gtest.h>

#include "ch5_homework/judge/ask.h"
#include "ch5_homework/judge/oracle.h"
#include "ch5_homework/judge/right/assembly.h"
#include "ch5_homework/judge/scenes/bundle.h"

namespace ch5::homework {
namespace {

// Compares H and b of MakeHessian.
void CheckSystem(const Graph& graph, const System& got, const Text& scene) {
  const Ordering ordering = MakeOrdering(graph);
  right::Loop loop{graph.Edges(), ordering.Size(), -1.0};
  loop.todo_block = "1.1c 1.1a";
  loop.todo_first = "1.1a";
  loop.todo_mirror = "1.1b";
  loop.todo_b = "1.1d 1.1b";
  const right::AssembledSystem right(loop);
  const Names names = RowNames(ordering);
  Require({{"scene.H_of", {{"what", scene}}}, "1.1a", "H", names}, right.H, got.H);
  Require({{"scene.b_of", {{"what", scene}}}, "1.1b", "b", names}, right.b, got.b);
}

// After an earlier call, which has left `before`. Of so many edges no slips are tried: the scenes above have shown them.
void CheckSecondCall(const Graph& graph, const System& got, const Text& scene, const System& before) {
  const Ordering ordering = MakeOrdering(graph);
  const System right = StackedNormalEquations(graph, ordering.Size());
  const Names names = RowNames(ordering);
  const auto not_zeroed = [](const char* it, const MatXX& sum) {
    return Mistakes{{"", {"1.1.not_zeroed", {{"it", Word(std::string(it))}}}, sum}};
  };
  Require({{"scene.H_of", {{"what", scene}}}, "1.1a", "H", names, 1e-10, not_zeroed("H", before.H + right.H)}, right.H,
          got.H);
  Require({{"scene.b_of", {{"what", scene}}}, "1.1b", "b", names, 1e-10, not_zeroed("b", before.b + right.b)}, right.b,
          got.b);
}

void CheckMakeHessian(Scene* scene, const Text& words) {
  const Answer got = Ask("MakeHessian", *scene);
  CheckSystem(scene->GetGraph(), {got["H"], got.Vector("b")}, words);
}

void CheckMakeHessian(const std::string& name, const Text& words) {
  GraphScene scene(name);
  CheckMakeHessian(&scene, words);
}

TEST(Stage11, OneEdgeBetweenTwoPoses) { CheckMakeHessian("one edge", "1.1.one_edge_between_two_poses"); }

TEST(Stage11, EdgesOnTheSamePairAddUp) { CheckMakeHessian("one pair", "1.1.five_edges_between_three_poses"); }

TEST(Stage11, TheSlidesChainOfThreeScalars) {
  // H = [100 −100 0; −100 136.111 −11.1111; 0 −11.1111 11.1111], the matrix that stage 2 begins with.
  CheckMakeHessian("chain", "1.1.slides_chain_three_scalars");
}

TEST(Stage11, LandmarksOfDimensionOne) {
  BundleScene scene(3, Vary(5, 9, 17), false);
  CheckMakeHessian(&scene, {"1.1.poses_and_inverse_depths", {{"n", Word(scene.ba.landmarks.size())}}});
}

TEST(Stage11, LandmarksOfDimensionThree) {
  CheckMakeHessian("points and a depth", "1.1.points_and_an_inverse_depth");
  GraphScene light("light row", {false}), heavy("heavy row", {false});
  CheckMakeHessian(&light, "scene.light_row");
  CheckMakeHessian(&heavy, "scene.heavy_row");
}

TEST(Stage11, FixedVerticesHaveNoRows) { CheckMakeHessian("fixed vertices", "1.1.some_vertices_fixed"); }

TEST(Stage11, RobustLossWeighsTheEdges) { CheckMakeHessian("Cauchy losses", "1.1.cauchy_loss"); }

TEST(Stage11, SecondCallStartsAfresh) {
  BundleScene scene(4, Vary(200, 220, 18), true);
  const double step = 1e-3;
  const Answer got = Ask("MakeHessian", scene, {{"step", step}});
  const System before{got["H_before"], got.Vector("b_before")};
  const Ordering ordering = MakeOrdering(scene.ba.graph);
  Update(ordering, VecX::Constant(ordering.Size(), step));
  CheckSecondCall(scene.ba.graph, {got["H"], got.Vector("b")},
                  {"1.1.second_call", {{"n", Word(scene.ba.landmarks.size())}}}, before);
}

}  // namespace
}  // namespace ch5::homework
