/// The incremental solution is the batch's, and costs what changes.
#include "ch5_backend/sparse/incremental_smoother.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "ch5_backend/math/option_checks.h"
#include "ch5_backend/simulate/random.h"
#include "ch5_backend/sparse/sparse_optimizer.h"
#include "ch5_backend/types/pose_graph/as_transform.h"
#include "ch5_backend/types/pose_graph/edge_sensor.h"
#include "tests/g2o/point_chain.h"
#include "tests/graph_error.h"

namespace ch5::test {
namespace {

constexpr IncrementalOptions kExact{0.0, 0.0};

// A walk that grows by a pose at a time; every seventh step closes a loop, and in a walk with landmarks each pose sees one.
class Walk {
 public:
  enum class Kind { kPlane, kSpace, kLandmarks };
  explicit Walk(Kind kind, uint64_t seed = 5) : kind_(kind), random_(seed) {}

  void Grow(int poses) {
    for (int k = 0; k < poses; ++k) AddPose();
  }
  Graph graph;

 private:
  void AddPose() {
    const int n = static_cast<int>(poses_.size());
    const Transform step{ExpSO3(Vec3(0, 0, 0.3)), Vec3(1, 0, 0)};
    const Transform start = n == 0 ? Transform() : *PoseOf(*poses_.back()) * step;
    if (kind_ == Kind::kSpace) {
      poses_.push_back(std::make_shared<VertexPose>(start.q, start.p));
    } else {
      poses_.push_back(std::make_shared<VertexSE2>(Vec2(start.p.head<2>()), LogSO3(start.q).z()));
    }
    graph.AddVertex(poses_.back());
    if (n == 0) poses_.back()->SetFixed();
    if (n > 0) Measure(n - 1, n, step);
    if (n > 8 && n % 7 == 0) {
      Transform round;
      for (int k = 0; k < 8; ++k) round = round * step;
      Measure(n - 8, n, round);
    }
    if (n > 0) truth_ = truth_ * step;
    if (kind_ == Kind::kLandmarks) See(poses_.back(), n / 10);
  }
  Vec3 Noise() { return NormalVector<3>(&random_, 0.05); }
  void Measure(int i, int j, const Transform& T_i_j) {
    if (kind_ == Kind::kSpace) {
      graph.AddEdge(std::make_shared<EdgeSE3Between>(std::static_pointer_cast<VertexPose>(poses_[i]),
                                                     std::static_pointer_cast<VertexPose>(poses_[j]),
                                                     T_i_j.q * ExpSO3(Noise()), Vec3(T_i_j.p + Noise())));
    } else {
      graph.AddEdge(std::make_shared<EdgeSE2Between>(
          std::static_pointer_cast<VertexSE2>(poses_[i]), std::static_pointer_cast<VertexSE2>(poses_[j]),
          Vec2(T_i_j.p.head<2>() + Noise().head<2>()), LogSO3(T_i_j.q).z() + Noise().x()));
    }
  }
  void See(const std::shared_ptr<Vertex>& pose, size_t landmark) {
    if (landmark == landmarks_.size()) {
      landmark_truth_ = truth_ * Vec3(0, 2, 0);
      landmarks_.push_back(std::make_shared<VertexPointXY>(Vec2(landmark_truth_.head<2>())));
      graph.AddVertex(landmarks_.back());
    }
    const Vec3 z = Inverse(truth_) * landmark_truth_ + Noise();
    graph.AddEdge(std::make_shared<EdgePointXY>(std::static_pointer_cast<VertexSE2>(pose), landmarks_[landmark],
                                                Vec2(z.head<2>())));
  }

  Kind kind_;
  Random random_;
  Transform truth_;
  Vec3 landmark_truth_;  // of the last one
  std::vector<std::shared_ptr<Vertex>> poses_;
  std::vector<std::shared_ptr<VertexPointXY>> landmarks_;
};

// How far two graphs' vertices are apart, by their numbers.
double Distance(const Graph& a, const Graph& b) {
  double worst = 0.0;
  for (size_t k = 0; k < a.Vertices().size(); ++k) {
    worst = std::max(worst, a.Vertices()[k]->Minus(b.Vertices()[k]->Parameters()).lpNorm<Eigen::Infinity>());
  }
  return worst;
}

void SolveAsABatch(Graph* graph) {
  SolveOptions options;
  options.cost_tolerance = options.step_tolerance = 1e-14;
  options.max_iterations = 100;
  SparseOptimizer(graph).Solve(options);
}

TEST(IncrementalSmoother, EndsWhereTheBatchEnds) {
  for (const Walk::Kind kind : {Walk::Kind::kPlane, Walk::Kind::kSpace, Walk::Kind::kLandmarks}) {
    for (const uint64_t seed : {1, 2, 3}) {
      Walk grown(kind, seed);
      IncrementalSmoother smoother(&grown.graph, kExact);
      for (const int poses : {2, 1, 1, 7, 30, 9}) {
        grown.Grow(poses);
        smoother.Update();
      }
      for (int k = 0; k < 10; ++k) smoother.Update();
      std::vector<VecX> found;
      for (const auto& vertex : grown.graph.Vertices()) found.emplace_back(vertex->Parameters());
      SolveAsABatch(&grown.graph);
      for (size_t k = 0; k < found.size(); ++k) {
        const Vertex& vertex = *grown.graph.Vertices()[k];
        EXPECT_LT(vertex.Minus(found[k]).norm(), 1e-7) << vertex.Name() << " " << seed;
      }
    }
  }
}

// One step from the same states is one iteration of Gauss–Newton.
TEST(IncrementalSmoother, WithoutThresholdsIsGaussNewton) {
  Walk mine(Walk::Kind::kLandmarks), batch(Walk::Kind::kLandmarks);
  IncrementalSmoother smoother(&mine.graph, kExact);
  for (Walk* walk : {&mine, &batch}) walk->Grow(40);
  smoother.Update();
  SolveOptions one;
  one.algorithm = Algorithm::kGaussNewton;
  one.max_iterations = 1;
  SparseOptimizer(&batch.graph).Solve(one);
  EXPECT_LT(Distance(mine.graph, batch.graph), 1e-9);
}

// Odometry touches the end of the path only, however long it is; a loop touches what it spans.
TEST(IncrementalSmoother, TouchesWhatChanges) {
  const auto eliminated_by_the_last = [](int before) {
    PointChain chain(before + 1);
    chain.points[0]->SetFixed();
    IncrementalSmoother smoother(&chain.graph);
    EXPECT_EQ(smoother.Update().eliminated, before);
    EXPECT_EQ(smoother.Update().relinearized, before);  // all were 0.3 m off the line
    chain.points.push_back(std::make_shared<VertexPointXYZ>(Vec3(before + 1.0, 0, 0)));
    chain.points.back()->SetRole(Role::kPose);
    chain.graph.AddVertex(chain.points.back());
    chain.graph.AddEdge(
        std::make_shared<PointDifference>(chain.points[before], chain.points[before + 1], Vec3(1, 0, 0)));
    UpdateSummary update = smoother.Update();
    EXPECT_EQ(update.variables, before + 1);
    EXPECT_EQ(update.linearized, 1);
    const int odometry = update.eliminated;
    chain.graph.AddEdge(
        std::make_shared<PointDifference>(chain.points[before - 20], chain.points[before + 1], Vec3(21, 0, 0)));
    update = smoother.Update();
    EXPECT_GE(update.eliminated, 3);
    return std::pair(odometry, update.eliminated);
  };
  const auto [odometry, loop] = eliminated_by_the_last(100);
  const auto [odometry_of_long, loop_of_long] = eliminated_by_the_last(1000);
  EXPECT_LT(odometry, 40);
  EXPECT_LT(odometry_of_long, 40);
  EXPECT_LT(loop, 90);
  EXPECT_LT(loop_of_long, 90);
}

// Nothing is linearized anew within the threshold, and the estimate is the first linear solution; beyond it all is.
TEST(IncrementalSmoother, RelinearizesWhatHasMovedBeyondTheThreshold) {
  for (const double threshold : {1e-9, 10.0}) {
    Walk walk(Walk::Kind::kPlane);
    walk.Grow(30);
    IncrementalSmoother smoother(&walk.graph, {threshold, 0.0});
    EXPECT_EQ(smoother.Update().relinearized, 0);
    EXPECT_EQ(smoother.Update().relinearized, threshold < 1.0 ? 29 : 0);
    EXPECT_EQ(smoother.Update().eliminated, threshold < 1.0 ? 29 : 0);
  }
}

TEST(IncrementalSmoother, CovarianceIsTheBatchs) {
  Walk walk(Walk::Kind::kLandmarks);
  IncrementalSmoother smoother(&walk.graph, kExact);
  for (int k = 0; k < 10; ++k) {
    walk.Grow(5);
    smoother.Update();
  }
  for (int k = 0; k < 10; ++k) smoother.Update();
  Covariance batch(&walk.graph);
  for (const auto& vertex : walk.graph.Vertices()) {
    if (vertex->IsFixed()) continue;
    const MatXX expected = batch.Block(*vertex, *vertex);
    EXPECT_LT((smoother.Covariance(*vertex) - expected).norm(), 1e-7 * expected.norm()) << vertex->Name();
  }
  ExpectGraphError([&] { static_cast<void>(smoother.Covariance(*walk.graph.Vertices()[0])); }, "VertexSE2 0 is fixed");
  ExpectGraphError([&] { static_cast<void>(smoother.Covariance(VertexSE2())); }, "VertexSE2 takes no part");
}

TEST(IncrementalSmoother, RestartsWhereEdgesHaveLeft) {
  Walk walk(Walk::Kind::kPlane);
  walk.Grow(40);
  IncrementalSmoother smoother(&walk.graph, kExact);
  smoother.Update();
  walk.graph.RemoveEdge(walk.graph.Edges()[10]);  // a step of the path, which loops span
  walk.graph.RemoveVertex(walk.graph.Vertices().back());
  for (int k = 0; k < 10; ++k) EXPECT_EQ(smoother.Update().variables, 38);
  const double cost = Cost(walk.graph);
  SolveAsABatch(&walk.graph);
  EXPECT_NEAR(cost, Cost(walk.graph), 1e-9 * cost);
}

TEST(IncrementalSmoother, NamesWhatIsNotDeterminedAndGoesOnWhenItIs) {
  PointChain chain(20);
  IncrementalSmoother smoother(&chain.graph);
  const VecX before = chain.points[7]->Parameters();
  ExpectError<SingularGraphError>([&] { smoother.Update(); }, "the graph's edges do not determine VertexPointXYZ ");
  EXPECT_EQ(chain.points[7]->Parameters(), before);
  chain.points[0]->SetFixed();
  smoother.Update();
  EXPECT_LT((chain.points[19]->GetEstimate() - Vec3(19, 0, 0)).norm(), 1e-9);

  const auto alone = std::make_shared<VertexPointXYZ>(Vec3(1, 2, 3));
  alone->SetRole(Role::kPose);
  chain.graph.AddVertex(alone);
  EXPECT_EQ(smoother.Update().variables, 19) << "a vertex without edges is not touched";
  chain.graph.AddEdge(std::make_shared<PointDifference>(chain.points[19], alone, Vec3(std::nan(""), 0, 0)));
  ExpectError<SingularGraphError>([&] { smoother.Update(); },
                                  "PointDifference 19 has a residual or a Jacobian that is not");
}

TEST(IncrementalSmoother, RefusesEdgesThatAreForeignOrGivenTwice) {
  PointChain chain(3), other(3);
  chain.points[0]->SetFixed();
  IncrementalSmoother smoother(&chain.graph);
  smoother.Update({chain.edges[0]});
  ExpectGraphError([&] { smoother.Update({chain.edges[0]}); }, "PointDifference 0 is given twice");
  ExpectGraphError([&] { smoother.Update({other.edges[1]}); }, "an edge is not in the graph");
  ExpectGraphError([&] { smoother.Update({nullptr}); }, "an edge is not in the graph");
  EXPECT_EQ(smoother.Update().variables, 2) << "it takes the others by itself";
  ExpectGraphError([] { IncrementalSmoother no_graph(nullptr); }, "the solver's graph is null");
  for (const IncrementalOptions& options : {IncrementalOptions{-0.1, 0.0}, IncrementalOptions{0.1, std::nan("")}}) {
    ExpectError<OptionError>([&] { IncrementalSmoother refused(&chain.graph, options); }, "IncrementalOptions::");
  }
}

}  // namespace
}  // namespace ch5::test
