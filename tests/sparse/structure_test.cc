// What lies where, of a graph that is numbered by hand.
#include "ch5_backend/sparse/steps/structure.h"

#include <gtest/gtest.h>

#include "ch5_backend/sparse/steps/eliminate.h"
#include "tests/graph_error.h"
#include "tests/sparse/scalar_graph.h"

namespace ch5::test {
namespace {

using Numbers = std::vector<int>;

// Poses 0, 1, 2; landmark a is seen by 1 and 2, b by 0 and 1, c by 1 and 2; an edge ties poses 0 and 2, one holds pose 0,
// and one is constant.
struct SmallGraph : ScalarGraph {
  SmallGraph() : ScalarGraph(3, 3) {
    Tie(origin, poses[0], 0.0);
    Tie(poses[0], poses[2], 1.0);
    const int seen_by[3][2] = {{1, 2}, {0, 1}, {1, 2}};
    for (int l = 0; l < 3; ++l) {
      for (const int i : seen_by[l]) Tie(poses[static_cast<size_t>(i)], landmarks[static_cast<size_t>(l)], 1.0);
    }
    auto other = std::make_shared<VertexScalar>(VertexScalar::Estimate(2.0));
    other->SetFixed();
    graph.AddVertex(other);
    Tie(origin, other, 1.0);
  }
};

TEST(Structure, SortsLandmarksByThePosesThatSeeThem) {
  const SmallGraph small;
  const Structure s = BuildStructure(MakeOrdering(small.graph));
  const auto& [a, b, c] = std::tie(small.landmarks[0], small.landmarks[1], small.landmarks[2]);
  EXPECT_EQ(s.landmarks, (std::vector<Vertex*>{b.get(), a.get(), c.get()}));
  EXPECT_EQ(s.slot_landmark, (Numbers{0, 0, 1, 1, 2, 2}));
  EXPECT_EQ(s.slot_pose, (Numbers{0, 1, 1, 2, 1, 2}));
  EXPECT_EQ(s.landmark_slots, (Numbers{0, 2, 4, 6}));
  EXPECT_EQ(s.pose_slots_begin, (Numbers{0, 1, 4, 6}));
  EXPECT_EQ(s.pose_slots, (Numbers{0, 1, 2, 4, 3, 5}));
  for (int slot = 0; slot <= 6; ++slot) EXPECT_EQ(s.SlotBlock(slot), slot) << "one number each, and the end";
  EXPECT_TRUE(s.OneEdgePerSlot());
}

TEST(Structure, ListsEdgesLandmarkByLandmarkThenThoseOfPosesThenConstantOnes) {
  const SmallGraph small;
  const Structure s = BuildStructure(MakeOrdering(small.graph));
  EXPECT_EQ(s.num_landmark_edges, 6);
  EXPECT_EQ(s.num_active_edges, 8);
  ASSERT_EQ(s.edges.size(), 9u);
  EXPECT_EQ(s.landmark_edges, (Numbers{0, 2, 4, 6}));
  const auto& edges = small.graph.Edges();
  const size_t order[] = {4, 5, 2, 3, 6, 7, 0, 1, 8};
  for (size_t e = 0; e < 9; ++e) EXPECT_EQ(s.edges[e].edge, edges[order[e]].get()) << e;
  EXPECT_EQ(s.H_pp_pattern, (std::vector<Numbers>{{0, 2}, {1}, {2}})) << "landmarks' edges hold one pose each";
  EXPECT_EQ(s.pose_edge_blocks.size(), 4u) << "pose 0 alone; 0 with 0, 2 with 0, 2 with 2";
  EXPECT_EQ(s.pose_edge_blocks_begin, (Numbers{0, 2, 3, 3, 4})) << "of blocks 00, 20, 11, 22";
}

TEST(Structure, RefusesAnEdgeOfTwoFreeLandmarks) {
  SmallGraph small;
  small.Tie(small.landmarks[0], small.landmarks[2], 0.0);
  EXPECT_THROW(BuildStructure(MakeOrdering(small.graph)), GraphError);
}

TEST(SchurGroups, TakeTogetherWhatTheSamePosesSee) {
  const SmallGraph small;
  const Structure s = BuildStructure(MakeOrdering(small.graph));
  EXPECT_EQ(SchurPattern(s), (std::vector<Numbers>{{0, 1, 2}, {1, 2}, {2}}));
  SymmetricBlockMatrix S;
  S.SetPattern(s.pose_dim, SchurPattern(s));
  for (const int threads : {1, 2, 3}) {
    const SchurGroups found = PrepareSchurGroups(s, S, threads);
    ASSERT_EQ(found.groups.size(), 2u);
    EXPECT_EQ(found.groups[0].last, 1);
    EXPECT_EQ(found.groups[1].first, 1);
    EXPECT_EQ(found.groups[1].last, 3) << "landmarks a and c";
    // Blocks of S are numbered 00, 10, 20, 11, 21, 22; poses 0 and 1 change 00, 10, 11, poses 1 and 2 change 11, 21, 22.
    EXPECT_EQ(found.blocks, (Numbers{0, 1, 3, 3, 4, 5}));
    int column = 0, poses = 0;
    for (const SchurGroups::ColumnRange& range : found.ranges) {
      EXPECT_EQ(range.begin, column) << "the ranges follow each other";
      column = range.end;
      const kernels::GroupMemory memory =
          kernels::GroupMemoryFor(s.sizes, /*poses=*/2, /*rows=*/2);  // the most of a group
      EXPECT_EQ(range.A.size(), memory.A);
      EXPECT_EQ(range.C.size(), memory.C);
      const auto [first, second] = found.PosesIn(found.groups[1], range);
      poses += static_cast<int>(second - first);
      for (const kernels::GroupPose* pose = first; pose != second; ++pose)
        EXPECT_TRUE(range.begin <= pose->pose && pose->pose < range.end);
    }
    EXPECT_EQ(column, 3);
    EXPECT_EQ(poses, 2) << "each pose of a group is in one range";
  }
}

}  // namespace
}  // namespace ch5::test
