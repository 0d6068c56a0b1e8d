#include <gtest/gtest.h>

#include <Eigen/SVD>

#include "ch5_backend/initialize/chordal.h"
#include "ch5_backend/initialize/initialize_pose_graph.h"
#include "ch5_backend/initialize/spanning_tree.h"
#include "ch5_backend/simulate/random.h"
#include "ch5_backend/sparse/sparse_optimizer.h"
#include "ch5_backend/types/pose_graph/as_transform.h"

namespace ch5 {
namespace {

constexpr PoseGraphStart kMade[] = {PoseGraphStart::kOdometry, PoseGraphStart::kSpanningTree, PoseGraphStart::kChordal};

// Poses whose truth is known, all at the origin at first, and measurements between them.
struct Scene {
  bool spatial;
  int apart;  ///< ids
  Graph graph;
  std::vector<Transform> truth;

  explicit Scene(bool spatial, int apart = 1) : spatial(spatial), apart(apart) {}

  void AddPose(const Transform& T_W_i) {
    const int id = apart * static_cast<int>(truth.size());
    truth.push_back(T_W_i);
    if (spatial) {
      graph.AddVertex(std::make_shared<VertexPose>(), id);
    } else {
      graph.AddVertex(std::make_shared<VertexSE2>(), id);
    }
  }

  // Measured with an error of exp(error).
  Edge& Measure(int i, int j, const Vec6& error = Vec6::Zero()) {
    const Transform T_i_j = Inverse(truth[i]) * truth[j] * Transform{ExpSO3(error.tail<3>()), error.head<3>()};
    const auto &v = graph.Vertices()[i], &w = graph.Vertices()[j];
    std::shared_ptr<Edge> edge;
    if (spatial) {
      edge = std::make_shared<EdgeSE3Between>(std::static_pointer_cast<VertexPose>(v),
                                              std::static_pointer_cast<VertexPose>(w), T_i_j.q, T_i_j.p);
    } else {
      edge = std::make_shared<EdgeSE2Between>(std::static_pointer_cast<VertexSE2>(v),
                                              std::static_pointer_cast<VertexSE2>(w), T_i_j.p.head<2>(),
                                              LogSO3(T_i_j.q).z());
    }
    graph.AddEdge(edge, apart * static_cast<int>(graph.Edges().size()));
    return *edge;
  }

  void Hold(int i) {
    MoveTo(truth[i], graph.Vertices()[i].get());
    graph.Vertices()[i]->SetFixed();
  }

  double WorstError() const {
    double worst = 0.0;
    for (size_t k = 0; k < truth.size(); ++k) {
      const Transform found = *PoseOf(*graph.Vertices()[k]);
      worst = std::max({worst, (found.p - truth[k].p).norm(), found.q.angularDistance(truth[k].q)});
    }
    return worst;
  }
};

Vec6 Noise(Random* random, bool spatial, double sigma) {
  Vec6 noise = NormalVector<6>(random, sigma);
  if (!spatial) noise.segment<3>(2).setZero();
  return noise;
}

// A walk of n poses, closed every seventh step, its edges pointing forward and backward by turns.
void MakeWalk(int n, double sigma, uint64_t seed, Scene* scene) {
  Random random(seed);
  Transform T_W_i;
  for (int i = 0; i < n; ++i) {
    scene->AddPose(T_W_i);
    const Vec6 turn = Noise(&random, scene->spatial, 0.5);
    T_W_i = T_W_i * Transform{ExpSO3(turn.tail<3>()), Vec3(1.0, 0.0, 0.0)};
  }
  for (int i = 0; i < n; ++i) {
    for (const int j : {i + 1, i + 7}) {
      if (j >= n) continue;
      const Vec6 noise = Noise(&random, scene->spatial, sigma);
      if (i % 2 == 0) {
        scene->Measure(i, j, noise);
      } else {
        scene->Measure(j, i, noise);
      }
    }
  }
}

TEST(PoseGraphStart, PerfectMeasurementsGiveBackTheTruth) {
  for (const bool spatial : {true, false}) {
    for (const PoseGraphStart start : kMade) {
      Scene scene(spatial);
      MakeWalk(60, 0.0, 51, &scene);
      scene.Hold(0);
      scene.Hold(33);
      InitializePoseGraph(start, &scene.graph);
      EXPECT_LT(scene.WorstError(), 1e-6) << spatial << static_cast<int>(start);
    }
  }
}

// A table of all ids up to the last would take gigabytes.
TEST(PoseGraphStart, IdsMayBeFarApart) {
  for (const bool spatial : {true, false}) {
    for (const auto& [name, start] : kPoseGraphStartNames) {
      Scene near(spatial), far(spatial, 15'000'000);
      for (Scene* scene : {&near, &far}) {
        MakeWalk(60, 0.1, 53, scene);
        scene->Hold(0);
        InitializePoseGraph(start, &scene->graph);
      }
      for (size_t k = 0; k < near.truth.size(); ++k) {
        EXPECT_EQ(near.graph.Vertices()[k]->Parameters(), far.graph.Vertices()[k]->Parameters()) << name << ", " << k;
      }
      EXPECT_EQ(EdgesAt(far.graph, {far.graph.Vertices()[30]}).size(), 4u);
    }
  }
}

// Four poses on a line, a meter apart; the edge 0 → 3 claims 2 m, and a second one 1 → 2 claims nothing.
TEST(PoseGraphStart, TreesWorkedByHand) {
  const auto x_of = [](TreeOrder order) {
    Scene scene(false);
    for (int k = 0; k < 4; ++k) scene.AddPose({Qd::Identity(), Vec3(k, 0, 0)});
    for (int k = 0; k < 3; ++k) scene.Measure(k, k + 1);
    Vec6 error = Vec6::Zero();
    error[0] = -1.0;
    scene.Measure(0, 3, error);
    scene.Measure(1, 2, error);
    PlaceAlongTree(order, &scene.graph);
    Eigen::Vector4d x;
    for (int k = 0; k < 4; ++k) x[k] = PoseOf(*scene.graph.Vertices()[k])->p.x();
    return x;
  };
  EXPECT_LT((x_of(TreeOrder::kOdometryFirst) - Eigen::Vector4d(0, 1, 2, 3)).norm(), 1e-12);
  EXPECT_LT((x_of(TreeOrder::kBreadthFirst) - Eigen::Vector4d(0, 1, 2, 2)).norm(), 1e-12);
}

TEST(PoseGraphStart, WhereOdometryBreaksAnotherEdgeBridges) {
  Scene scene(false);
  for (int k = 0; k < 6; ++k) scene.AddPose({Qd::Identity(), Vec3(k, 0, 0)});
  for (const int k : {0, 1, 3, 4}) scene.Measure(k, k + 1);  // not 2 → 3
  scene.Measure(5, 1);
  PlaceAlongTree(TreeOrder::kOdometryFirst, &scene.graph);
  EXPECT_LT(scene.WorstError(), 1e-12);
}

TEST(PoseGraphStart, ALandmarkBetweenTwoPosesDoesNotBreakThePath) {
  Scene scene(false);
  scene.AddPose({});
  scene.graph.AddVertex(std::make_shared<VertexPointXY>());
  scene.truth.emplace_back();
  scene.AddPose({Qd::Identity(), Vec3(1, 0, 0)});
  scene.AddPose({Qd::Identity(), Vec3(2, 0, 0)});
  scene.Measure(2, 3);
  Vec6 error = Vec6::Zero();
  error[0] = 1.0;
  scene.Measure(0, 3, error);
  scene.Measure(0, 2);
  PlaceAlongTree(TreeOrder::kOdometryFirst, &scene.graph);
  EXPECT_EQ(PoseOf(*scene.graph.Vertices()[3])->p.x(), 2.0);
}

TEST(PoseGraphStart, RootsAreTheFixedPosesAndTheFirstOfEachFreePart) {
  Scene scene(true);
  for (int k = 0; k < 8; ++k) scene.AddPose({});
  scene.Measure(2, 1);  // {1, 2, 5}: nothing fixed
  scene.Measure(5, 2);
  scene.Measure(3, 4);  // {3, 4}: 4 is fixed;  {0}, {6}, {7}: no edge
  scene.Hold(4);
  std::vector<int> ids;
  for (const auto& root : FindRoots(scene.graph)) ids.push_back(root->Id());
  EXPECT_EQ(ids, (std::vector<int>{4, 1}));
}

TEST(PoseGraphStart, FixedPosesAndPosesWithoutAnEdgeStay) {
  for (const PoseGraphStart start : kMade) {
    Scene scene(true);
    MakeWalk(20, 0.1, 52, &scene);
    scene.AddPose({ExpSO3({0, 0, 1}), {1, 2, 3}});
    scene.Hold(5);
    const VecX fixed = scene.graph.Vertices()[5]->Parameters(), alone = scene.graph.Vertices()[20]->Parameters();
    InitializePoseGraph(start, &scene.graph);
    EXPECT_EQ(VecX(scene.graph.Vertices()[5]->Parameters()), fixed);
    EXPECT_EQ(VecX(scene.graph.Vertices()[20]->Parameters()), alone);
  }
}

// The oracle: the relaxation written as one dense least-squares problem over all numbers of R_1 … R_n−1, and solved by QR.
TEST(Chordal, RotationsAreThoseOfTheDenseProblem) {
  Scene scene(true);
  MakeWalk(9, 0.5, 53, &scene);
  Random random(54);
  for (const auto& edge : scene.graph.Edges()) {
    edge->SetInformation(VecX::Constant(6, random.Uniform(0.5, 4.0)).asDiagonal().toDenseMatrix());
  }
  scene.Hold(0);
  const int n = 9, edges = static_cast<int>(scene.graph.Edges().size());
  MatXX A = MatXX::Zero(9 * edges, 9 * n);  // √κ vec(R_j − R_i R_ij), vec by columns
  for (int e = 0; e < edges; ++e) {
    const Edge& edge = *scene.graph.Edges()[e];
    const double root = std::sqrt(edge.Information()(5, 5));
    const Mat33 R_i_j = MeasurementOf(edge)->q.toRotationMatrix();
    const int i = edge.Vertices()[0]->Id(), j = edge.Vertices()[1]->Id();
    A.block<9, 9>(9 * e, 9 * j) += root * MatXX::Identity(9, 9);
    for (int r = 0; r < 3; ++r) {
      for (int c = 0; c < 3; ++c) A.block<3, 3>(9 * e + 3 * c, 9 * i + 3 * r) -= root * R_i_j(r, c) * Mat33::Identity();
    }
  }
  const Mat33 R_0 = Mat33::Identity();
  const VecX b = -A.leftCols(9) * Eigen::Map<const VecX>(R_0.data(), 9);
  const MatXX A_x = A.rightCols(9 * (n - 1));
  const VecX x = MatXX(A_x.transpose() * A_x).ldlt().solve(A_x.transpose() * b);

  PlaceByChordalRelaxation(&scene.graph);
  for (int k = 1; k < n; ++k) {
    const Mat33 M = Eigen::Map<const Mat33>(x.data() + 9 * (k - 1));
    const Eigen::JacobiSVD<Mat33> svd(M, Eigen::ComputeFullU | Eigen::ComputeFullV);
    const double sign = (svd.matrixU() * svd.matrixV().transpose()).determinant();
    const Mat33 R = svd.matrixU() * Vec3(1, 1, sign).asDiagonal() * svd.matrixV().transpose();
    EXPECT_LT((PoseOf(*scene.graph.Vertices()[k])->q.toRotationMatrix() - R).norm(), 1e-9) << k;
  }
}

// An information that ties every number of the residual to every other.
void WeighAtRandom(uint64_t seed, Graph* graph) {
  Random random(seed);
  for (const auto& edge : graph->Edges()) {
    MatXX A(edge->ResidualDimension(), edge->ResidualDimension());
    for (Eigen::Index k = 0; k < A.size(); ++k) A.data()[k] = random.Normal();
    edge->SetInformation(A * A.transpose());
  }
}

// The cost's gradient by each position is zero, whatever W ties position and rotation together.
TEST(Chordal, PositionsAreTheBestForTheseRotations) {
  Scene scene(true);
  MakeWalk(40, 0.3, 55, &scene);
  WeighAtRandom(56, &scene.graph);
  scene.Hold(0);
  PlaceByChordalRelaxation(&scene.graph);
  MatXX gradient = MatXX::Zero(3, 40);
  for (const auto& edge : scene.graph.Edges()) {
    edge->Linearize();
    for (const int k : {0, 1}) {
      gradient.col(edge->Vertices()[k]->Id()) +=
          edge->Jacobian(k).leftCols(3).transpose() * edge->Information() * edge->Residual();
    }
  }
  EXPECT_LT(gradient.rightCols(39).cwiseAbs().maxCoeff(), 1e-7);
}

// By hand: a square driven around once, whose four left turns measure 91°, 4° too much in all. The angles share them, 1° for
// each edge, though the last heading is a whole turn from the first.
TEST(PlanarStart, AnglesShareALoopsErrorAcrossAWholeTurn) {
  constexpr double kDegree = M_PI / 180.0;
  Scene scene(false);
  for (int k = 0; k < 4; ++k) {
    const Vec3 corner(k == 1 || k == 2 ? 1.0 : 0.0, k >= 2 ? 1.0 : 0.0, 0.0);
    scene.AddPose({ExpSO3({0, 0, 90 * k * kDegree}), corner});
  }
  Vec6 error = Vec6::Zero();
  error[5] = 1.0 * kDegree;
  for (int k = 0; k < 4; ++k) scene.Measure(k, (k + 1) % 4, error).SetInformation(Vec3(0, 0, 1).asDiagonal());
  scene.Hold(0);
  PlaceByChordalRelaxation(&scene.graph);
  for (int k = 0; k < 4; ++k) {
    const auto& pose = static_cast<const VertexSE2&>(*scene.graph.Vertices()[k]);
    EXPECT_NEAR(WrapAngle(pose.Theta() - 90 * k * kDegree), 0.0, 1e-9) << k;
  }
}

// Where noise is moderate there is little left to do, whatever W.
TEST(PlanarStart, IsNearTheMinimum) {
  for (const bool weighed : {false, true}) {
    Scene scene(false);
    MakeWalk(300, 0.05, 61, &scene);
    if (weighed) WeighAtRandom(62, &scene.graph);
    scene.Hold(0);
    PlaceByChordalRelaxation(&scene.graph);
    const double start = Cost(scene.graph);
    SolveOptions options;
    options.max_iterations = 100;
    options.cost_tolerance = 1e-12;
    const double least = SparseOptimizer(&scene.graph).Solve(options).final_cost;
    EXPECT_LT(start, 1.1 * least) << weighed;
  }
}

TEST(Chordal, WhatNoEdgeDeterminesStaysWhereTheTreePutsIt) {
  Scene scene(true);
  MakeWalk(10, 0.0, 57, &scene);
  scene.AddPose(scene.truth.back() * Transform{ExpSO3({0, 0, 1}), {1, 0, 0}});
  scene.Measure(9, 10).SetInformation(MatXX::Zero(6, 6));
  scene.Hold(0);
  PlaceByChordalRelaxation(&scene.graph);
  EXPECT_LT(scene.WorstError(), 1e-6);
}

TEST(PoseGraphStart, AnyNumberOfThreadsGivesTheSameBits) {
  for (const bool spatial : {true, false}) {
    Scene one(spatial), three(spatial);
    for (Scene* scene : {&one, &three}) MakeWalk(200, 0.2, 58, scene);
    PlaceByChordalRelaxation(&one.graph, 1);
    PlaceByChordalRelaxation(&three.graph, 3);
    for (int k = 0; k < 200; ++k) {
      EXPECT_EQ(VecX(one.graph.Vertices()[k]->Parameters()), VecX(three.graph.Vertices()[k]->Parameters()));
    }
  }
}

TEST(PoseGraphStart, TheLeastCostIsTaken) {
  const std::vector<PoseGraphStart> starts = {PoseGraphStart::kGiven, PoseGraphStart::kSpanningTree,
                                              PoseGraphStart::kChordal};
  for (const bool given_is_best : {false, true}) {
    Scene scene(true);
    MakeWalk(50, 0.1, 59, &scene);
    scene.Hold(0);
    if (given_is_best) SparseOptimizer(&scene.graph).Solve({});
    const double given = Cost(scene.graph);
    const std::vector<double> costs = InitializeAtLeastCost(starts, &scene.graph);
    ASSERT_EQ(costs.size(), 3u);
    EXPECT_EQ(costs[0], given);
    EXPECT_EQ(Cost(scene.graph), costs[given_is_best ? 0 : 2]);
    EXPECT_EQ(Cost(scene.graph), *std::min_element(costs.begin(), costs.end()));
    EXPECT_EQ(scene.graph.StackSize(), 0u);
  }
}

// Poses in rings around a sphere, in the plane along a spiral, each tied to the next and to the one above; σ = 0.4 m and 0.4 rad.
void MakeSphere(int rings, int poses_a_ring, uint64_t seed, Scene* scene) {
  Random random(seed);
  const int n = rings * poses_a_ring;
  for (int k = 0; k < n; ++k) {
    const double share = static_cast<double>(k) / n, longitude = 2.0 * M_PI * k / poses_a_ring;
    const double latitude = scene->spatial ? M_PI * (share - 0.5) : 0.0,
                 radius = scene->spatial ? 10.0 : 10.0 + 20.0 * share;
    const Qd q = Qd(Eigen::AngleAxisd(longitude, Vec3::UnitZ())) * Qd(Eigen::AngleAxisd(-latitude, Vec3::UnitY()));
    scene->AddPose({q, q * Vec3(radius, 0, 0)});
  }
  for (int k = 0; k + 1 < n; ++k) {
    scene->Measure(k, k + 1, Noise(&random, scene->spatial, 0.4));
    if (k + poses_a_ring < n) scene->Measure(k, k + poses_a_ring, Noise(&random, scene->spatial, 0.4));
  }
}

// Where the path's errors add up to many turns, its valley is not the truth's.
TEST(PoseGraphStart, LargeNoiseNeedsTheChordalStart) {
  const auto optimum_from = [](bool spatial, PoseGraphStart start) {
    Scene scene(spatial);
    MakeSphere(20, 10, 60, &scene);
    scene.Hold(0);
    if (start == PoseGraphStart::kGiven) {
      for (size_t k = 0; k < scene.truth.size(); ++k) MoveTo(scene.truth[k], scene.graph.Vertices()[k].get());
    }
    InitializePoseGraph(start, &scene.graph);
    SparseOptimizer optimizer(&scene.graph);
    optimizer.SetDamping(Damping::kDiagonal);
    SolveOptions options;
    options.max_iterations = 500;
    options.cost_tolerance = 1e-9;
    return optimizer.Solve(options).final_cost;
  };
  for (const bool spatial : {true, false}) {
    const double from_truth = optimum_from(spatial, PoseGraphStart::kGiven);
    EXPECT_LT(optimum_from(spatial, PoseGraphStart::kChordal), from_truth * (1 + 1e-6)) << spatial;
    EXPECT_GT(optimum_from(spatial, PoseGraphStart::kOdometry), from_truth * 1.01) << spatial;
  }
}

}  // namespace
}  // namespace ch5
