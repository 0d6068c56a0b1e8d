/// Stage 1.1: H and b equal a dense −JᵀWr and JᵀWJ that is built in another way.
/// From simple to hard; the first failure ends the check (--gtest_fail_fast).

#include <gtest/gtest.h>

#include "ch5_homework/judge/ask.h"
#include "ch5_homework/judge/mistakes/assembly.h"
#include "ch5_homework/judge/oracle.h"
#include "ch5_homework/judge/scenes/bundle.h"

namespace ch5::homework {
namespace {

// Compares H and b of MakeHessian; `before`: what an earlier call has left.
void CheckSystem(const Graph& graph, const System& got, const Text& scene, const System& before = {}) {
  const Ordering ordering = MakeOrdering(graph);
  const System right = StackedNormalEquations(graph, ordering.Size());
  const Names names = RowNames(ordering);
  const Loop loop{graph.Edges(), ordering.Size()};
  const auto in_H = [&] {
    std::vector<Mistake> mistakes = MistakesInH(loop, "1.1a", "1.1b", "1.1c 1.1a");
    if (before.b.size() > 0) mistakes.push_back({"", {"1.1.not_zeroed", {{"it", Word("H")}}}, before.H + right.H});
    if (got.H.rows() == ordering.Size()) {
      mistakes.push_back(FoundPlaces(loop, got.H, "hessian", "1.1a", "1.1b"));
    }
    return mistakes;
  };
  Require("1.1", {"scene.H_of", {{"what", scene}}}, right.H, got.H, names, in_H, 1e-10, "1.1a", "H");
  const auto in_b = [&] {
    std::vector<Mistake> mistakes = MistakesInB("1.1d 1.1b", loop, -1.0, "formula.sign_of_b");
    if (before.b.size() > 0) mistakes.push_back({"", {"1.1.not_zeroed", {{"it", Word("b")}}}, before.b + right.b});
    return mistakes;
  };
  Require("1.1", {"scene.b_of", {{"what", scene}}}, right.b, got.b, names, in_b, 1e-10, "1.1b", "b");
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
  GraphScene light("light row", {false});
  CheckMakeHessian(&light, "scene.light_row");
}

TEST(Stage11, FixedVerticesHaveNoRows) { CheckMakeHessian("fixed vertices", "1.1.some_vertices_fixed"); }

TEST(Stage11, RobustLossWeighsTheEdges) { CheckMakeHessian("Cauchy losses", "1.1.cauchy_loss"); }

TEST(Stage11, SecondCallStartsAfresh) {
  BundleScene scene(4, Vary(120, 130, 18), true);
  const double step = 1e-3;
  const Answer got = Ask("MakeHessian", scene, {{"step", step}});
  const System before{got["H_before"], got.Vector("b_before")};
  const Ordering ordering = MakeOrdering(scene.ba.graph);
  Update(ordering, VecX::Constant(ordering.Size(), step));
  CheckSystem(scene.ba.graph, {got["H"], got.Vector("b")},
              {"1.1.second_call", {{"n", Word(scene.ba.landmarks.size())}}}, before);
}

}  // namespace
}  // namespace ch5::homework
