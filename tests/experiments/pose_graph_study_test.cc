#include "ch5_backend/experiments/studies/pose_graph_study.h"

#include <gtest/gtest.h>

#include <string>

#include "ch5_backend/files/tables/text_writer.h"
#include "ch5_backend/simulate/random.h"
#include "ch5_backend/sparse/sparse_optimizer.h"
#include "ch5_backend/types/pose_graph/edge_between.h"
#include "tests/data_folder.h"
#include "tests/temporary_folder.h"

namespace ch5 {
namespace {

// A walk of `n` poses with perfect odometry and closures, which starts from poses that are off by `noise`.
struct Walk {
  std::vector<Qd> q;
  std::vector<Vec3> p;
  G2oFile file;
};

Walk MakeWalk(int n, double noise, uint64_t seed) {
  Walk walk;
  Random random(seed);
  for (int i = 0; i < n; ++i) {
    const bool first = i == 0;
    const Qd q = first ? Qd::Identity() : walk.q.back() * ExpSO3(NormalVector(&random, 0.3));
    const Vec3 p = first ? Vec3::Zero() : Vec3(walk.p.back() + walk.q.back() * Vec3(1, 0, 0));
    walk.q.push_back(q);
    walk.p.push_back(p);
    const double off = first ? 0.0 : noise;
    walk.file.graph.AddVertex(
        std::make_shared<VertexPose>(q * ExpSO3(NormalVector(&random, off)), p + NormalVector(&random, off)));
    walk.file.ids.push_back(10 * i);
  }
  const auto pose = [&](int i) { return std::static_pointer_cast<VertexPose>(walk.file.graph.Vertices()[i]); };
  for (int i = 0; i < n; ++i) {
    for (const int j : {i + 1, i + 7}) {
      if (j >= n) continue;
      const Qd q_z = walk.q[i].conjugate() * walk.q[j];
      const Vec3 p_z = walk.q[i].conjugate() * (walk.p[j] - walk.p[i]);
      walk.file.graph.AddEdge(std::make_shared<EdgeSE3Between>(pose(i), pose(j), q_z, p_z));
    }
  }
  return walk;
}

TEST(PoseGraph, PerfectMeasurementsGiveBackTheTruth) {
  Walk walk = MakeWalk(60, 0.2, 41);
  const PoseGraphStudy study = SolvePoseGraph({}, &walk.file);
  EXPECT_TRUE(IsConverged(study.summary.termination)) << study.summary.message;
  EXPECT_EQ(study.fixed_ids, std::vector<int64_t>{0});
  EXPECT_LT(2 * study.summary.final_cost, 1e-6);  // g2o's optimization_slam3d asks for this and for 1e-3
  for (int i = 0; i < 60; ++i) {
    const auto& pose = static_cast<const VertexPose&>(*walk.file.graph.Vertices()[i]);
    EXPECT_LT((pose.p() - walk.p[i]).norm(), 1e-3);
    EXPECT_LT(pose.q().angularDistance(walk.q[i]), 1e-3);
  }
}

// The bad closure spans four steps; over a longer one it would have the lever to win against any Huber.
TEST(PoseGraph, OneBadClosureDoesNotBendTheRestUnderHuber) {
  double worst[2];
  for (const bool huber : {false, true}) {
    Walk walk = MakeWalk(60, 0.0, 42);
    const auto& vertices = walk.file.graph.Vertices();
    walk.file.graph.AddEdge(std::make_shared<EdgeSE3Between>(std::static_pointer_cast<VertexPose>(vertices[20]),
                                                             std::static_pointer_cast<VertexPose>(vertices[24]),
                                                             Qd::Identity(), Vec3::Zero()));
    PoseGraphOptions options;
    options.huber = huber ? 0.01 : 0.0;
    SolvePoseGraph(options, &walk.file);
    worst[huber] = 0.0;
    for (int i = 0; i < 60; ++i) {
      const auto& pose = static_cast<const VertexPose&>(*vertices[i]);
      worst[huber] = std::max(worst[huber], (pose.p() - walk.p[i]).norm());
    }
  }
  EXPECT_GT(worst[0], 0.5);
  EXPECT_LT(worst[1], 0.05);
}

// A square in the plane, one meter a side: three sides measured, started crooked, one pose fixed elsewhere.
TEST(PoseGraph, PlanarSquare) {
  G2oFile file;
  std::vector<std::shared_ptr<VertexSE2>> poses;
  for (int i = 0; i < 4; ++i) {
    poses.push_back(std::make_shared<VertexSE2>(Vec2(0.8 * i, 0.1 * i * i), 1.2 * i));
    file.graph.AddVertex(poses.back());
    file.ids.push_back(i);
  }
  poses[2]->SetEstimate(Vec3(3, 3, M_PI));
  poses[2]->SetFixed();
  for (int i = 0; i < 3; ++i) {
    file.graph.AddEdge(std::make_shared<EdgeSE2Between>(poses[i], poses[i + 1], Vec2(1, 0), M_PI / 2));
  }
  const PoseGraphStudy study = SolvePoseGraph({}, &file);
  EXPECT_TRUE(study.fixed_ids.empty());
  const Vec3 expected[] = {{2, 2, 0}, {3, 2, M_PI / 2}, {3, 3, M_PI}, {2, 3, -M_PI / 2}};
  for (int i = 0; i < 4; ++i) EXPECT_LT(poses[i]->Minus(expected[i]).norm(), 1e-6) << i;
}

TEST(PoseGraph, ResultDoesNotDependOnThreads) {
  std::string results[2];
  for (const int threads : {1, 3}) {
    Walk walk = MakeWalk(400, 0.1, 43);
    PoseGraphOptions options;
    options.threads = threads;
    SolvePoseGraph(options, &walk.file);
    for (int i = 0; i < 400; ++i) walk.file.lines.push_back({G2oFile::Kind::kVertex, i, 0, ""});
    results[threads > 1] = FormatG2o(walk.file);
  }
  EXPECT_EQ(results[0], results[1]);
}

// The least costs ½χ² known, which chordal relaxation leads to. From the files' poses Ceres 2.1 reaches the first two, too
// (it stops at 0.619483 in the flat valley of the second, see tests/bench); MIT's lead to 385.33, or 9558, or still others,
// as the damping has it, and CSAIL has none.
struct Known {
  const char* name;
  double optimum;
};
void PrintTo(const Known& known, std::ostream* out) { *out << known.name; }

// Without data: a line of poses a meter apart, and an edge from the first to the last that is a meter longer than the others
// together. The shortest stretch is a straight line on which each of the n edges takes 1/n: ½χ² = 1/2n.
constexpr int kLine = 100;  // poses, and edges
std::string MakeLine(bool in_space) {
  const std::string kind = in_space ? "SE3:QUAT" : "SE2", rest = in_space ? " 0 0 0 0 0 1" : " 0 0";
  std::string vertices, edges, information;
  const int dim = in_space ? 6 : 3;
  for (int i = 0; i < dim; ++i) {
    for (int j = i; j < dim; ++j) information += i == j ? " 1" : " 0";
  }
  for (int i = 0; i < kLine; ++i) {
    const bool closing = i + 1 == kLine;
    vertices += "VERTEX_" + kind + ' ' + std::to_string(i) + ' ' + std::to_string(i) + rest + '\n';
    edges += "EDGE_" + kind + (closing ? " 0 " : ' ' + std::to_string(i) + ' ') + std::to_string(closing ? i : i + 1) +
             (closing ? ' ' + std::to_string(kLine) : " 1") + rest + information + '\n';
  }
  return vertices + edges;
}

class RealGraph : public testing::TestWithParam<Known> {
 protected:
  void SetUp() override {
    const std::string name = GetParam().name;
    const bool made_up = name.rfind("line", 0) == 0;
    path_ = (made_up ? folder_.Path() : DataFolder() / "posegraph") / (name + ".g2o");
    if (made_up) WriteFileAtomically(path_, MakeLine(name == "line_in_space"));
    CH5_NEEDS(path_);
  }
  test::TemporaryFolder folder_;
  std::string path_;
};

TEST_P(RealGraph, ReachesTheLeastCostKnown) {
  const double optimum = GetParam().optimum;
  G2oFile file = ReadG2o(path_);
  PoseGraphOptions options;
  options.threads = 2;
  const PoseGraphStudy study = SolvePoseGraph(options, &file);
  EXPECT_EQ(study.start, PoseGraphStart::kChordal);
  EXPECT_TRUE(IsConverged(study.summary.termination)) << study.summary.message;
  EXPECT_LT(study.summary.final_cost, optimum * (1 + 1e-6));
  EXPECT_LE(study.summary.iterations, 30);
}

TEST_P(RealGraph, AllAlgorithmsReachItFromChordalRelaxation) {
  const double optimum = GetParam().optimum;
  for (const Algorithm algorithm : {Algorithm::kGaussNewton, Algorithm::kLevenbergMarquardt, Algorithm::kDogleg}) {
    G2oFile file = ReadG2o(path_);
    FixFreeParts(file.graph);
    InitializePoseGraph(PoseGraphStart::kChordal, &file.graph);
    SparseOptimizer optimizer(&file.graph);
    optimizer.SetDamping(Damping::kDiagonal);
    SolveOptions options;
    options.algorithm = algorithm;
    options.max_iterations = 30;
    options.cost_tolerance = 1e-9;
    EXPECT_LT(optimizer.Solve(options).final_cost, optimum * (1 + 1e-6)) << static_cast<int>(algorithm);
  }
}

INSTANTIATE_TEST_SUITE_P(Shared, RealGraph,
                         testing::Values(Known{"line_in_the_plane", 0.5 / kLine}, Known{"line_in_space", 0.5 / kLine},
                                         Known{"sphere2500", 363.574840}, Known{"parking-garage", 0.619345},
                                         Known{"intel", 22.502348}, Known{"MIT", 20.581635}, Known{"CSAIL", 20.277561}),
                         [](const auto& info) {
                           const std::string name = info.param.name;
                           return name.substr(0, name.find('-'));
                         });

}  // namespace
}  // namespace ch5
