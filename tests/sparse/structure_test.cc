// What lies where, and the steps of the sparse solver, of graphs that are done by hand: H and b, S and b_S, Δx. Against the
// dense solver: equality_test.cc.
#include "ch5_backend/sparse/steps/structure.h"

#include <gtest/gtest.h>

#include "ch5_backend/sparse/sparse_solver.h"
#include "ch5_backend/sparse/steps/eliminate.h"
#include "tests/sparse/scalar_graph.h"

namespace ch5::test {
namespace {

using Numbers = Array<int>;

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
  EXPECT_EQ(s.landmarks, (Array<Vertex*>{b.get(), a.get(), c.get()}));
  EXPECT_EQ(s.slot_landmark, (Numbers{0, 0, 1, 1, 2, 2}));
  EXPECT_EQ(s.slot_pose, (Numbers{0, 1, 1, 2, 1, 2}));
  EXPECT_EQ(s.landmark_slots, (Numbers{0, 2, 4, 6}));
  EXPECT_EQ(s.pose_slots.begin, (Numbers{0, 1, 4, 6}));
  EXPECT_EQ(s.pose_slots.items, (Numbers{0, 1, 2, 4, 3, 5}));
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
  EXPECT_EQ(s.H_pp_pattern, (Lists{{0, 2}, {1}, {2}})) << "landmarks' edges hold one pose each";
  const auto blocks = [&](int e, int count) {
    const auto begin = s.edge_blocks.begin() + s.edges[e].blocks_begin;
    return Numbers(begin, begin + count);
  };
  EXPECT_EQ(blocks(6, 1), (Numbers{0})) << "pose 0 alone";
  EXPECT_EQ(blocks(7, 3), (Numbers{0, 1, 3})) << "0 with 0, 2 with 0, 2 with 2, of the blocks 00, 20, 11, 22";
  EXPECT_EQ(s.pose_batches, (Numbers{6, 8})) << "both at once";
  const int columns = s.edges[6].width + 1;
  EXPECT_EQ(s.edges[7].normal_equations, columns * columns) << "behind the first one's";
}

TEST(SchurGroups, TakeTogetherWhatTheSamePosesSee) {
  const SmallGraph small;
  const Structure s = BuildStructure(MakeOrdering(small.graph));
  EXPECT_EQ(SchurPattern(s), (Lists{{0, 1, 2}, {1, 2}, {2}}));
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
  }
}

TEST(Elimination, OfOneLandmarkByHand) {
  struct Case {
    double lambda;
    Damping damping;
    double S, b_S;
    VecX delta_x;
    double model_cost_change;  // bᵀΔx − ½ΔxᵀHΔx, H without damping
  };
  OnePoseOneLandmark small;
  SparseSolver solver(&small.graph);
  solver.SetOrdering();
  solver.MakeHessian();
  const MatXX H = (MatXX(2, 2) << 2, -1, -1, 2).finished();
  EXPECT_EQ(solver.DenseHessian(), H);
  EXPECT_EQ(solver.RightHandSide(), Vec2(-1, 7));
  EXPECT_EQ(solver.HessianDiagonal(), Vec2(2, 2));
  EXPECT_EQ(solver.MultiplyHessian(Vec2(1, 3)), Vec2(-1, 5));
  for (const Case& one :
       {Case{1.0, Damping::kIdentity, 3.0 - 1.0 / 3.0, -1.0 + 7.0 / 3.0, Vec2(0.5, 2.5), 11.75},
        Case{0.0, Damping::kIdentity, 2.0 - 1.0 / 2.0, -1.0 + 7.0 / 2.0, Vec2(5, 13) / 3.0, 43.0 / 3.0},
        Case{1.0, Damping::kDiagonal, 4.0 - 1.0 / 4.0, -1.0 + 7.0 / 4.0, Vec2(0.2, 1.8), 9.48}}) {
    SCOPED_TRACE(one.S);
    solver.SetDamping(one.damping);
    VecX step;
    ASSERT_TRUE(solver.SolveLinearSystem(one.lambda, &step));
    EXPECT_DOUBLE_EQ(solver.SchurComplement()(0, 0), one.S);
    EXPECT_DOUBLE_EQ(solver.GetEliminated().b_S[0], one.b_S);
    EXPECT_LT((step - one.delta_x).norm(), 1e-14);
    EXPECT_DOUBLE_EQ(solver.ModelCostChange(step), one.model_cost_change);
    EXPECT_EQ(solver.DenseHessian(), H) << "damping leaves H and b as they were";
    EXPECT_EQ(solver.RightHandSide(), Vec2(-1, 7));
  }
}

// C δ = 0 with C = (1): the pose is held, its row and column leave the system.
TEST(HoldPoses, TakesTheHeldDirectionsOut) {
  OnePoseOneLandmark small;
  SparseSolver solver(&small.graph);
  solver.SetOrdering();
  const auto one = [] { return MatXX(MatXX::Ones(1, 1)); };
  EXPECT_TRUE(FindHeldPoses(solver.GetStructure(), {{small.origin, one}}).empty()) << "what is fixed is held already";
  EXPECT_THROW(FindHeldPoses(solver.GetStructure(), {{small.landmarks[0], one}}), std::invalid_argument);
  solver.Hold({{small.poses[0], one}});
  solver.MakeHessian();
  ASSERT_EQ(solver.HeldPoses().size(), 1u);
  EXPECT_DOUBLE_EQ(solver.HeldPoses()[0].projection(0, 0), 0.0);
  const MatXX H = solver.DenseHessian();
  EXPECT_GT(H(0, 0), 0.0) << "to keep it regular";
  EXPECT_DOUBLE_EQ(H(0, 1), 0.0);
  EXPECT_DOUBLE_EQ(H(1, 1), 2.0);
  EXPECT_EQ(solver.RightHandSide(), Vec2(0, 7));
}

}  // namespace
}  // namespace ch5::test
