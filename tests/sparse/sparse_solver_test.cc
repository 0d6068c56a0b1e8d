// What is the sparse solver's own: its errors, its degenerate cases, its threads, its reduced solvers.
#include <gtest/gtest.h>

#include "ch5_backend/simulate/mono_ba.h"
#include "ch5_backend/simulate/random.h"
#include "ch5_backend/sparse/sparse_optimizer.h"
#include "ch5_backend/sparse/sparse_solver.h"
#include "ch5_backend/types/bal/edge_bal.h"
#include "ch5_backend/types/edge_se3_prior.h"
#include "ch5_backend/types/visual/edge_reprojection.h"
#include "tests/scenes.h"

namespace ch5::test {
namespace {

// Two poses, the first fixed, and points in front of them.
struct TwoViews {
  Graph graph;
  std::shared_ptr<VertexPose> poses[2];
  std::vector<std::shared_ptr<VertexPointXYZ>> points;

  explicit TwoViews(int num_points) {
    Random random(8);
    for (int i = 0; i < 2; ++i) {
      poses[i] = std::make_shared<VertexPose>(Qd::Identity(), Vec3(i, 0, 0));
      graph.AddVertex(poses[i]);
    }
    poses[0]->SetFixed();
    for (int k = 0; k < num_points; ++k) {
      const Vec3 p_W(random.Uniform(-2, 2), random.Uniform(-2, 2), random.Uniform(4, 8));
      points.push_back(std::make_shared<VertexPointXYZ>(p_W));
      graph.AddVertex(points.back());
      for (int i = 0; i < 2; ++i) {
        const Vec3 p_C = p_W - poses[i]->p();
        graph.AddEdge(std::make_shared<EdgeReprojectionXYZ>(
            points[k], poses[i], p_C.head<2>() / p_C.z() + Vec2(1e-3 * random.Normal(), 1e-3)));
      }
    }
    graph.AddEdge(std::make_shared<EdgeSE3Prior>(poses[1], Qd::Identity(), Vec3(1, 0, 0)));
  }
};

TEST(SparseSolver, AnEdgeThatIsNotFiniteIsNamed) {
  Graph graph;
  const auto camera = std::make_shared<VertexCameraBAL>(Vec9::Zero());
  graph.AddVertex(camera);
  for (const double z : {-1.0, 0.0, -1.0, 0.0}) {  // in front of the camera, and in its plane
    const auto point = std::make_shared<VertexPointXYZ>(Vec3(1, 1, z));
    graph.AddVertex(point);
    graph.AddEdge(std::make_shared<EdgeBAL>(camera, point, Vec2::Zero()));
  }
  graph.Edges()[1]->SetLevel(1);       // takes no part
  graph.RemoveEdge(graph.Edges()[0]);  // ids stay
  const Summary summary = SparseOptimizer(&graph).Solve();
  EXPECT_EQ(summary.termination, Termination::kNotFinite);
  EXPECT_NE(summary.message.find("; EdgeBAL 3 has a residual or a Jacobian"), std::string::npos) << summary.message;
}

TEST(SparseSolver, ALandmarkSeenOnceIsSingularUntilItIsDamped) {
  TwoViews scene(6);
  auto lonely = std::make_shared<VertexPointXYZ>(Vec3(0.3, 0.2, 5.0));
  scene.graph.AddVertex(lonely);
  scene.graph.AddEdge(std::make_shared<EdgeReprojectionXYZ>(lonely, scene.poses[1], Vec2(0.01, 0.02)));
  SparseOptimizer optimizer(&scene.graph);
  SparseSolver& solver = optimizer.GetSolver();
  solver.MakeHessian();
  VecX step;
  EXPECT_FALSE(solver.SolveLinearSystem(0.0, &step));
  EXPECT_TRUE(solver.SolveLinearSystem(1e-3, &step));
  EXPECT_TRUE(step.allFinite());
}

TEST(SparseSolver, AFreeGaugeIsSingularUntilItIsDamped) {
  MonoBaOptions options;
  options.pixel_sigma = options.depth_sigma = 0.0;  // the null space is exact at the truth
  MonoBa scene = BuildMonoBa(SimulateMonoBa(options), Gauge::kFree, 1.0, 0.0);
  SparseSolver solver(&scene.graph);
  solver.SetOrdering();
  solver.MakeHessian();
  VecX step;
  EXPECT_FALSE(solver.SolveLinearSystem(0.0, &step));
  EXPECT_TRUE(solver.SolveLinearSystem(1e-3, &step));
}

TEST(SparseSolver, FollowsChangesOfTheGraph) {
  TwoViews scene(6);
  SparseOptimizer optimizer(&scene.graph);
  EXPECT_EQ(optimizer.GetSolver().Size(), 6 + 18);
  scene.points[0]->SetFixed();
  EXPECT_EQ(optimizer.GetSolver().Size(), 6 + 15);
  scene.graph.RemoveVertex(scene.points[1]);
  EXPECT_EQ(optimizer.GetSolver().Size(), 6 + 12);
  auto landmark = std::make_shared<VertexInverseDepth>(0.2);  // another dimension: another solver
  scene.graph.AddVertex(landmark);
  scene.graph.AddEdge(
      std::make_shared<EdgeReprojection>(landmark, scene.poses[0], scene.poses[1], Vec2(0, 0), Vec2(-0.2, 0)));
  EXPECT_EQ(optimizer.GetSolver().Size(), 6 + 12 + 1);
  EXPECT_TRUE(IsConverged(optimizer.Solve().termination));
}

}  // namespace
}  // namespace ch5::test
