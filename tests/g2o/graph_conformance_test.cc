// What g2o promises of its graph: active sets, the index mapping, the stack of states, what is refused.
#include <gtest/gtest.h>

#include <limits>

#include "ch5_backend/graph/ordering.h"
#include "ch5_backend/types/vertices.h"
#include "tests/g2o/point_chain.h"
#include "tests/graph_error.h"

namespace ch5::test {
namespace {

std::vector<int> Ids(const std::vector<std::shared_ptr<Edge>>& edges) {
  std::vector<int> ids;
  for (const auto& edge : edges) ids.push_back(edge->Id());
  return ids;
}

Selection AtLevel(int level) {
  Selection selection;
  selection.level = level;
  return selection;
}

// ---- G2: which edges and vertices take part ----------------------------------------------------------------------

TEST(G2o, G2_AnEdgeIsActiveIffItsLevelMatches) {
  PointChain chain(4);  // edges 0, 1, 2 between neighbors
  chain.edges[1]->SetLevel(1);
  EXPECT_EQ(Ids(MakeOrdering(chain.graph).edges), (std::vector<int>{0, 2}));
  EXPECT_EQ(Ids(MakeOrdering(chain.graph, AtLevel(1)).edges), (std::vector<int>{1}));
  EXPECT_EQ(Ids(MakeOrdering(chain.graph, AtLevel(2)).edges), (std::vector<int>{}));
  EXPECT_EQ(Ids(MakeOrdering(chain.graph, AtLevel(-1)).edges), (std::vector<int>{0, 1, 2}));
  EXPECT_THROW(chain.edges[0]->SetLevel(-1), std::invalid_argument);
  EXPECT_EQ(chain.edges[0]->Level(), 0);
}

TEST(G2o, G2_AVertexWithoutAnActiveEdgeDropsOut) {
  PointChain chain(4);
  chain.edges[0]->SetLevel(1);
  const Ordering ordering = MakeOrdering(chain.graph);
  EXPECT_EQ(chain.points[0]->OrderingId(), -1);
  EXPECT_EQ(ordering.Size(), 9);
  EXPECT_EQ(chain.points[1]->OrderingId(), 0);
}

TEST(G2o, G2_AnEdgeIsActiveOnlyIfAllItsVerticesAreInTheSet) {
  PointChain chain(4);
  const auto& p = chain.points;
  EXPECT_EQ(Ids(MakeOrdering(chain.graph, {0, false, {p[2], p[1], p[0]}}).edges), (std::vector<int>{0, 1}));
  EXPECT_EQ(p[3]->OrderingId(), -1);
  EXPECT_EQ(Ids(MakeOrdering(chain.graph, {0, false, {p[0], p[2]}}).edges), (std::vector<int>{}));
  EXPECT_EQ(MakeOrdering(chain.graph, {0, false, {}}).Size(), 0);
}

// ---- G3: the index mapping ---------------------------------------------------------------------------------------

TEST(G2o, G3_IndicesFollowTheIdsPosesFirstLandmarksLastFixedNone) {
  Graph graph;
  const auto landmark = std::make_shared<VertexPointXYZ>(Vec3::Zero());
  const auto late = std::make_shared<VertexPose>(), early = std::make_shared<VertexPose>();
  const auto fixed = std::make_shared<VertexPose>();
  fixed->SetFixed();
  EXPECT_EQ(graph.AddVertex(late, 9), 9);
  EXPECT_EQ(graph.AddVertex(landmark, 1), 1);
  EXPECT_EQ(graph.AddVertex(early, 5), 5);
  EXPECT_EQ(graph.AddVertex(fixed, 3), 3);
  for (const auto& pose : {early, late, fixed}) {
    graph.AddEdge(std::make_shared<PoseSeesPoint>(pose, landmark));
  }
  const Ordering ordering = MakeOrdering(graph);
  EXPECT_EQ(early->OrderingId(), 0);
  EXPECT_EQ(late->OrderingId(), 6);
  EXPECT_EQ(landmark->OrderingId(), 12);
  EXPECT_EQ(fixed->OrderingId(), -1);
  EXPECT_EQ(ordering.Size(), 15);
  EXPECT_EQ(graph.AddVertex(std::make_shared<VertexPose>()), 10) << "the next after the largest";
}

// ---- G12: the stack of states, clear, removeVertex ---------------------------------------------------------------

TEST(G2o, G12_PushAndPopRestoreTheStatesToTheBit) {
  PointChain chain(3);
  const Vec3 first = chain.points[1]->GetEstimate();
  chain.graph.Push();
  chain.points[1]->SetEstimate(Vec3(0.1, 0.2, 0.3));
  chain.graph.Push();
  chain.points[1]->SetEstimate(Vec3(7, 8, 9));
  EXPECT_EQ(chain.graph.StackSize(), 2u);
  chain.graph.Pop();
  EXPECT_EQ(chain.points[1]->GetEstimate(), Vec3(0.1, 0.2, 0.3));
  chain.graph.Pop();
  EXPECT_EQ(chain.points[1]->GetEstimate(), first);
  ExpectGraphError([&] { chain.graph.Pop(); }, "Pop: no state is on the stack");
}

TEST(G2o, G12_DiscardTopForgetsOneStateAndTouchesNothing) {
  PointChain chain(3);
  const Vec3 first = chain.points[0]->GetEstimate();
  chain.graph.Push();
  chain.points[0]->SetEstimate(Vec3(1, 1, 1));
  chain.graph.Push();
  chain.points[0]->SetEstimate(Vec3(2, 2, 2));
  chain.graph.DiscardTop();
  EXPECT_EQ(chain.points[0]->GetEstimate(), Vec3(2, 2, 2));
  chain.graph.Pop();
  EXPECT_EQ(chain.points[0]->GetEstimate(), first);
  ExpectGraphError([&] { chain.graph.DiscardTop(); }, "DiscardTop: no state is on the stack");
}

TEST(G2o, G12_PopPassesOverVerticesThatCameOrLeft) {
  PointChain chain(3);
  chain.graph.Push();
  const auto newcomer = std::make_shared<VertexPointXYZ>(Vec3(4, 4, 4));
  chain.graph.AddVertex(newcomer);
  const auto leaver = chain.points[2];
  leaver->SetEstimate(Vec3(5, 5, 5));
  chain.graph.RemoveVertex(leaver);
  chain.graph.Pop();
  EXPECT_EQ(newcomer->GetEstimate(), Vec3(4, 4, 4));
  EXPECT_EQ(leaver->GetEstimate(), Vec3(5, 5, 5));
}

// ---- G14: what a graph refuses, and its second life --------------------------------------------------------------

TEST(G2o, G14_DuplicateIdsAndUnsetOrRepeatedVerticesAreRejected) {
  PointChain chain(2);
  const auto point = std::make_shared<VertexPointXYZ>(Vec3::Zero());
  ExpectGraphError([&] { chain.graph.AddVertex(point, 1); },
                   "AddVertex: VertexPointXYZ cannot have the id 1: VertexPointXYZ has it");
  ExpectGraphError([&] { chain.graph.AddVertex(point, -7); }, "cannot have the id -7");
  ExpectGraphError([&] { chain.graph.AddVertex(point, std::numeric_limits<int>::max()); }, "ids are 0 to 2147483646");
  ExpectGraphError([&] { chain.graph.AddVertex(chain.points[0], 5); }, "VertexPointXYZ 0 is already in a graph");
  EXPECT_EQ(point->Id(), -1);
  const auto edge = [](const auto& a, const auto& b) { return std::make_shared<PointDifference>(a, b, Vec3::Zero()); };
  const auto& p = chain.points;
  ExpectGraphError([&] { chain.graph.AddEdge(edge(p[0], p[1]), 0); }, "cannot have the id 0: PointDifference has it");
  ExpectGraphError([&] { chain.graph.AddEdge(edge(p[0], nullptr)); }, "vertex 1: missing (null)");
  ExpectGraphError([&] { chain.graph.AddEdge(edge(p[0], p[0])); }, "vertex 1: VertexPointXYZ 0 is repeated");
  EXPECT_EQ(chain.graph.Edges().size(), 1u);
}

TEST(G2o, G14_AClearedGraphTakesItsMembersAgain) {
  PointChain chain(3);
  chain.graph.Push();
  chain.graph.Clear();
  EXPECT_TRUE(chain.graph.Vertices().empty());
  EXPECT_TRUE(chain.graph.Edges().empty());
  EXPECT_EQ(chain.graph.StackSize(), 0u);
  EXPECT_EQ(chain.points[2]->Id(), -1);
  EXPECT_EQ(chain.graph.AddVertex(chain.points[2]), 0);
  EXPECT_EQ(chain.graph.AddVertex(chain.points[1]), 1);
  EXPECT_EQ(chain.graph.AddEdge(chain.edges[1]), 0);
  EXPECT_EQ(MakeOrdering(chain.graph).Size(), 6);
}

}  // namespace
}  // namespace ch5::test
