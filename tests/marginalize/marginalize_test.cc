#include "ch5_backend/marginalize/marginalize.h"

#include <algorithm>
#include <ctime>

#include "ch5_backend/marginalize/drop_ordering.h"
#include "ch5_backend/sparse/covariance.h"
#include "ch5_backend/types/pose_graph/edge_between.h"
#include "tests/marginalize/small_graphs.h"

namespace ch5 {
namespace {

TEST(Marginalize, EqualsADenseSchurComplement) {
  for (const uint64_t seed : {1u, 2u, 3u}) {
    const SmallWindow window(seed);
    const auto drop = window.Oldest();
    const auto edges = window.EdgesAt(drop);
    const MarginalSystem system = EliminateVertices(edges, drop);
    const auto [H, b] = DenseNormalEquations(edges, system.kept, drop);
    // Five orders of magnitude lie between a bias' information and a depth's: 1e-9 of the norm is rounding.
    EXPECT_LT(RelativeError(system.H, Schur(H, system.H.rows())), 1e-9);
    EXPECT_LT(RelativeError(system.b, SchurB(H, b, system.H.rows())), 1e-9);
  }
}

// Landmarks alone, or nothing at all: the dense block that goes is empty.
TEST(Marginalize, DropsLandmarksAloneOrNothing) {
  const SmallWindow window;
  const std::vector<std::shared_ptr<Vertex>> nothing, landmarks(window.landmarks.begin(), window.landmarks.end());
  for (const auto& drop : {nothing, landmarks}) {
    const MarginalSystem system = EliminateVertices(window.graph.Edges(), drop);
    const MatXX H = DenseNormalEquations(window.graph.Edges(), system.kept, drop).H;
    EXPECT_LT(RelativeError(system.H, drop.empty() ? H : Schur(H, system.H.rows())), 1e-9);
  }
}

// An edge between two that go counts once, and what the others know of one another stays. One that is put aside has no part.
TEST(MarginalizeInto, KeepsTheCovariancesOfTheRest) {
  SmallWindow window;
  window.extrinsic->SetFixed(true);
  for (const auto& edge : window.graph.Edges()) edge->SetLossFunction(nullptr);  // H is definite
  const auto last = window.poses[3];
  const auto outlier = std::make_shared<EdgeSE3Between>(window.poses[0], last, Qd::Identity(), Vec3::Zero());
  outlier->SetIsotropicInformation(1e8);
  outlier->SetLevel(1);
  window.graph.AddEdge(outlier);
  const MatXX before = Covariance(&window.graph).Block(*last, *last);
  const size_t vertices = window.graph.Vertices().size();
  std::vector<std::shared_ptr<Vertex>> drop = window.Oldest();
  const auto prior = MarginalizeInto(&window.graph, drop);
  ASSERT_TRUE(prior);
  EXPECT_TRUE(window.graph.Contains(*prior));
  EXPECT_EQ(window.graph.Vertices().size(), vertices - drop.size());
  for (const auto& vertex : drop) EXPECT_FALSE(window.graph.Contains(*vertex));
  EXPECT_FALSE(window.graph.Contains(*outlier));
  EXPECT_LT(RelativeError(Covariance(&window.graph).Block(*last, *last), before), 1e-6);
}

TEST(MarginalizeInto, RefusesAStrangerAndLeavesTheGraphAsItWas) {
  SmallWindow window;
  const size_t edges = window.graph.Edges().size();
  const auto stranger = std::make_shared<VertexPose>();
  EXPECT_THROW(MarginalizeInto(&window.graph, {window.poses[0], stranger}), GraphError);
  EXPECT_THROW(MarginalizeInto(&window.graph, {nullptr}), GraphError);
  EXPECT_EQ(window.graph.Edges().size(), edges);
}

TEST(MarginalizeInto, LeavesNoPriorWhereNothingRemains) {
  Graph graph;
  const auto lonely = std::make_shared<VertexPose>(), known = std::make_shared<VertexPose>();
  graph.AddVertex(lonely);
  graph.AddVertex(known);
  graph.AddEdge(std::make_shared<EdgeSE3Prior>(known, Qd::Identity(), Vec3::Zero()));
  EXPECT_FALSE(MarginalizeInto(&graph, {lonely, known, known}));
  EXPECT_TRUE(graph.Vertices().empty());
  EXPECT_TRUE(graph.Edges().empty());
}

// A path loses its oldest pose again and again: processor time, once the edges of each vertex are listed.
TEST(MarginalizeInto, TakesNoLongerInAGraphTenTimesAsLarge) {
  const auto seconds = [](int poses) {
    Graph graph;
    std::vector<std::shared_ptr<VertexSE2>> path;
    for (int k = 0; k < poses; ++k) {
      path.push_back(std::make_shared<VertexSE2>(Vec2(k, 0)));
      graph.AddVertex(path.back());
      if (k > 0) graph.AddEdge(std::make_shared<EdgeSE2Between>(path[k - 1], path[k], Vec2(1, 0), 0.0));
    }
    MarginalizeInto(&graph, {path[0]});
    double least = 1e9;
    for (int k = 1; k + 100 < 1000; k += 100) {
      const std::clock_t begin = std::clock();
      for (int j = k; j < k + 100; ++j) {
        MarginalizeInto(&graph, {path[j]});
        EXPECT_EQ(graph.EdgesOf(*path[j + 1]).size(), 2u);  // the prior, and the next step
      }
      least = std::min(least, static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC);
    }
    return least;
  };
  EXPECT_LT(seconds(40000), 4.0 * seconds(4000)) << "10 times as long if all edges are walked";
}

// Marginalizes a vertex with all its edges.
void ReplaceByPrior(const std::shared_ptr<Vertex>& oldest, std::vector<std::shared_ptr<Edge>>* edges) {
  std::vector<std::shared_ptr<Edge>> at, rest;
  for (const auto& edge : *edges) {
    const auto& v = edge->Vertices();
    (std::find(v.begin(), v.end(), oldest) == v.end() ? rest : at).push_back(edge);
  }
  rest.push_back(std::make_shared<EdgePrior>(Marginalize(at, {oldest})));
  *edges = rest;
}

// On a linear problem nothing is lost: the kept variables' optimum with the prior is that of the whole batch.
TEST(Marginalize, LinearSmootherEqualsTheBatch) {
  Random random(7);
  const auto matrix = [&](int rows, int columns) { return NormalMatrix(rows, columns, &random); };
  constexpr int kStates = 30, kLag = 7;  // as in gtsam's testBatchFixedLagSmoother
  std::vector<std::shared_ptr<Vertex>> x;
  std::vector<std::shared_ptr<Edge>> all;
  for (int k = 0; k < kStates; ++k) x.push_back(std::make_shared<VertexVector<3>>(Vec3::Zero()));
  all.push_back(std::make_shared<LinearEdge>(std::vector{x[0]}, std::vector{matrix(3, 3)}, matrix(3, 1)));
  for (int k = 1; k < kStates; ++k) {
    all.push_back(std::make_shared<LinearEdge>(std::vector{x[k - 1], x[k]}, std::vector{matrix(4, 3), matrix(4, 3)},
                                               matrix(4, 1)));
  }
  const auto optimum = [](const DenseSystem& system) -> VecX { return system.H.partialPivLu().solve(system.b); };
  const VecX batch = optimum(DenseNormalEquations(all, x));

  // The window holds kLag states; the oldest one is marginalized into the prior, which is marginalized in turn.
  std::vector<std::shared_ptr<Edge>> window{all[0]};
  for (int k = 1; k < kStates; ++k) {
    window.push_back(all[k]);
    if (k < kLag) continue;
    ReplaceByPrior(x[k - kLag], &window);
  }
  const std::vector<std::shared_ptr<Vertex>> kept(x.end() - kLag, x.end());
  const VecX smoothed = optimum(DenseNormalEquations(window, kept));
  EXPECT_LT((smoothed - batch.tail(3 * kLag)).norm(), 1e-9 * batch.norm());
}

// On a nonlinear problem it is so at the linearization point: one Gauss-Newton step is that of the batch.
TEST(Marginalize, GaussNewtonStepEqualsTheBatchAtTheLinearizationPoint) {
  SmallWindow window;
  window.poses[0]->SetFixed(false);
  window.extrinsic->SetFixed();
  const auto drop = window.Oldest();
  const auto edges = window.EdgesAt(drop);
  Problem batch(&window.graph);
  batch.MakeHessian();
  VecX step;
  ASSERT_TRUE(batch.SolveLinearSystem(0.0, &step));
  std::map<const Vertex*, VecX> expected;
  for (const auto& v : window.graph.Vertices()) {
    if (v->OrderingId() >= 0) expected[v.get()] = step.segment(v->OrderingId(), v->LocalDimension());
  }

  auto prior = std::make_shared<EdgePrior>(Marginalize(edges, drop));
  for (const auto& edge : edges) window.graph.RemoveEdge(edge);
  for (const auto& v : drop) window.graph.RemoveVertex(v);
  window.graph.AddEdge(prior);
  Problem smoother(&window.graph);
  smoother.MakeHessian();
  VecX ours;
  ASSERT_TRUE(smoother.SolveLinearSystem(0.0, &ours));
  VecX wanted(ours.size());
  for (const auto& v : window.graph.Vertices()) {
    if (v->OrderingId() >= 0) wanted.segment(v->OrderingId(), v->LocalDimension()) = expected[v.get()];
  }
  // By what they differ in the cost, ΔxᵀHΔx: the step itself is only known to the rounding times H's condition, 1e10.
  const MatXX& H = smoother.Hessian();
  const VecX difference = ours - wanted;
  EXPECT_LT(difference.dot(H * difference), 1e-14 * wanted.dot(H * wanted));
}

TEST(Marginalize, DoesNotDependOnTheOrderOfEdges) {
  const SmallWindow window;
  const auto drop = window.Oldest();
  auto edges = window.EdgesAt(drop);
  const MarginalSystem first = EliminateVertices(edges, drop);
  std::reverse(edges.begin(), edges.end());
  const MarginalSystem second = EliminateVertices(edges, drop);
  EXPECT_EQ(first.kept, second.kept);
  EXPECT_LT(RelativeError(second.H, first.H), 1e-13);
}

TEST(Marginalize, RepeatsToTheBit) {
  const SmallWindow a, b;  // other addresses, same ids
  const Prior first = Marginalize(a.EdgesAt(a.Oldest()), a.Oldest());
  const Prior second = Marginalize(b.EdgesAt(b.Oldest()), b.Oldest());
  EXPECT_EQ(first.J, second.J);
  EXPECT_EQ(first.r0, second.r0);
}

// A landmark seen from one place only leaves its depth unobserved: the pseudo-inverse drops it and nothing is NaN.
TEST(Marginalize, SurvivesAnUnobservedLandmark) {
  auto host = std::make_shared<VertexPose>(), target = std::make_shared<VertexPose>();
  auto landmark = std::make_shared<VertexInverseDepth>(0.2);
  auto edge = std::make_shared<EdgeReprojection>(landmark, host, target, Vec2(0.1, 0.2), Vec2(0.1, 0.2));
  const Prior prior = Marginalize({edge}, {landmark});
  EXPECT_TRUE(prior.J.allFinite());
  EXPECT_TRUE(prior.r0.allFinite());
  EXPECT_EQ(prior.vertices.size(), 2u);
}

// `seen_once` is seen through A (2×3): it has a direction that nobody observes, beside one of full rank.
void ExpectPseudoInverse(const std::shared_ptr<Vertex>& seen_once, const MatXX& A,
                         const std::shared_ptr<Vertex>& seen_well) {
  Random random(3);
  const auto matrix = [&](int rows, int columns) { return NormalMatrix(rows, columns, &random); };
  const auto x = std::make_shared<VertexScalar>(VertexScalar::Estimate(0.0));
  const std::vector<std::shared_ptr<Edge>> edges{
      std::make_shared<LinearEdge>(std::vector<std::shared_ptr<Vertex>>{x}, std::vector{matrix(1, 1)}, matrix(1, 1)),
      std::make_shared<LinearEdge>(std::vector<std::shared_ptr<Vertex>>{x, seen_once}, std::vector{matrix(2, 1), A},
                                   matrix(2, 1)),
      std::make_shared<LinearEdge>(std::vector<std::shared_ptr<Vertex>>{x, seen_well},
                                   std::vector{matrix(4, 1), matrix(4, 3)}, matrix(4, 1))};
  const MarginalSystem system = EliminateVertices(edges, {seen_once, seen_well});
  const auto [H, b] = DenseNormalEquations(edges, {x, seen_once, seen_well});
  const MatXX inverse = H.bottomRightCorner(6, 6).completeOrthogonalDecomposition().pseudoInverse();
  EXPECT_NEAR(system.H(0, 0),
              (H.topLeftCorner(1, 1) - H.topRightCorner(1, 6) * inverse * H.bottomLeftCorner(6, 1))(0, 0),
              1e-12 * H(0, 0));
  EXPECT_NEAR(system.b[0], b[0] - (H.topRightCorner(1, 6) * inverse * b.tail(6))(0), 1e-12 * b.norm());
}

TEST(Marginalize, TakesThePseudoInverseOfASingularPointOrState) {
  const auto point = [] { return std::make_shared<VertexPointXYZ>(Vec3::Zero()); };
  const auto state = [] { return std::make_shared<VertexVector<3>>(Vec3::Zero()); };
  const MatXX rank_two = (MatXX(2, 3) << 0.3, -1.2, 0.7, 1.1, 0.4, -0.6).finished();
  const MatXX rank_one = (MatXX(2, 3) << 1.0, 1.0, 0.0, 2.0, 2.0, 0.0).finished();  // its pivots are exactly zero
  for (const MatXX& A : {rank_two, rank_one}) {
    ExpectPseudoInverse(point(), A, point());
    ExpectPseudoInverse(state(), A, state());
  }
}

// Frame 0 and its landmarks are dropped: the rows of the kept vertices come first, then those of the dropped, by id.
TEST(DropOrdering, KeptRowsComeFirstThenDroppedOnesInOrderOfIds) {
  const SmallWindow window;
  const auto drop = window.Oldest();
  const DropOrdering order = MakeDropOrdering(window.EdgesAt(drop), drop);
  const std::vector<std::shared_ptr<Vertex>> poses{window.poses[1],       window.speed_biases[1], window.poses[2],
                                                   window.poses[3],       window.extrinsic,       window.poses[0],
                                                   window.speed_biases[0]};
  EXPECT_EQ(order.ordering.poses, poses);
  EXPECT_EQ(order.num_kept, 5);
  EXPECT_EQ(order.ordering.landmarks.size(), 6u);
  EXPECT_EQ(order.kept_size, 6 + 9 + 6 + 6 + 6);
  EXPECT_EQ(order.ordering.dim_poses, order.kept_size + 6 + 9);
  int row = 0;
  for (const auto* vertices : {&order.ordering.poses, &order.ordering.landmarks}) {
    for (const auto& vertex : *vertices) {
      EXPECT_EQ(vertex->OrderingId(), row);
      row += vertex->LocalDimension();
    }
  }
  EXPECT_EQ(row, order.ordering.Size());
}

TEST(DropOrdering, FixedVerticesHaveNoRows) {
  const SmallWindow window;
  window.poses[1]->SetFixed();
  const auto drop = window.Oldest();
  const auto edges = window.EdgesAt(drop);
  const DropOrdering order = MakeDropOrdering(edges, drop);
  EXPECT_EQ(window.poses[1]->OrderingId(), -1);
  EXPECT_EQ(order.num_kept, 4);
  const Incidence& incidence = order.ordering.incidence;
  for (size_t e = 0; e < edges.size(); ++e) {
    const auto& vertices = edges[e]->Vertices();
    const auto free = std::count_if(vertices.begin(), vertices.end(), [](const auto& v) { return !v->IsFixed(); });
    EXPECT_EQ(incidence.begin[e + 1] - incidence.begin[e], free);
  }
}

TEST(DropOrdering, AnEdgeBetweenTwoDroppedLandmarksIsRefused) {
  std::vector<std::shared_ptr<Vertex>> points{std::make_shared<VertexPointXYZ>(Vec3::Zero()),
                                              std::make_shared<VertexPointXYZ>(Vec3::Ones())};
  auto edge = std::make_shared<LinearEdge>(points, std::vector<MatXX>(2, MatXX::Identity(3, 3)), VecX::Zero(3));
  EXPECT_THROW(EliminateVertices({edge}, points), std::invalid_argument);
}

}  // namespace
}  // namespace ch5
