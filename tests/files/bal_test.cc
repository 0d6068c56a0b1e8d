/// BAL problems: the file format by hand, round trips to the bit, the graph, and the real problems' known optima.
#include "ch5_backend/files/bal.h"

#include <gtest/gtest.h>

#include <cmath>
#include <ctime>
#include <filesystem>

#include "ch5_backend/dense/problem.h"
#include "ch5_backend/experiments/studies/bal_study.h"
#include "ch5_backend/files/tables/text_writer.h"
#include "ch5_backend/simulate/random.h"
#include "ch5_backend/sparse/sparse_optimizer.h"
#include "tests/data_folder.h"
#include "tests/temporary_folder.h"

namespace ch5 {
namespace {

namespace fs = std::filesystem;

class BalFiles : public testing::Test {
 protected:
  std::string Path(const std::string& name) const { return folder_ / name; }
  test::TemporaryFolder folder_;
};

std::string DataPath(const std::string& name) { return DataFolder() / "bal" / name; }

// Each camera sees each point, without noise.
void Observe(BalProblem* problem) {
  for (size_t k = 0; k < problem->points.size(); ++k) {
    for (size_t i = 0; i < problem->cameras.size(); ++i) {
      problem->observations.push_back({static_cast<int>(i), static_cast<int>(k), Vec2::Zero()});
    }
  }
  BalGraph bal = BuildBal(*problem, nullptr);
  for (size_t i = 0; i < problem->observations.size(); ++i) {
    bal.graph.Edges()[i]->ComputeResidual();  // the prediction, since the measurement is zero
    problem->observations[i].pixel = bal.graph.Edges()[i]->Residual();
  }
}

// Four cameras on a circle look at a cloud of points around the origin; pixels without noise.
BalProblem SmallProblem() {
  Random random(1);
  BalProblem problem;
  for (int i = 0; i < 4; ++i) {
    Vec9 camera = Vec9::Zero();
    camera[1] = 0.3 * i - 0.45;  // turns about y
    camera[5] = -5.0;            // the points lie 5 m ahead, along −z
    camera[6] = 500.0;
    camera[7] = -0.01;
    problem.cameras.push_back(camera);
  }
  for (int k = 0; k < 12; ++k) {
    problem.points.push_back(UniformVector(&random, Vec3(-1, -1, -1), Vec3(1, 1, 1)));
  }
  Observe(&problem);
  return problem;
}

void ExpectEqual(const BalProblem& a, const BalProblem& b) {
  ASSERT_EQ(a.observations.size(), b.observations.size());
  for (size_t i = 0; i < a.observations.size(); ++i) {
    EXPECT_EQ(a.observations[i].camera, b.observations[i].camera);
    EXPECT_EQ(a.observations[i].point, b.observations[i].point);
    EXPECT_EQ(a.observations[i].pixel, b.observations[i].pixel);
  }
  EXPECT_EQ(a.cameras, b.cameras);
  EXPECT_EQ(a.points, b.points);
}

TEST_F(BalFiles, AreReadAsTheyAreWrittenDown) {
  WriteFileAtomically(Path("a.txt"),
                      "2 1 2\n1 0 -1.5 2.5e1\n0 0 +3 .5\r\n\n"
                      "0.1 0.2 0.3 1 2 3 500 -0.1 0.01\n0 0 0 0 0 0 1 0 0\n7 8 -9");
  const BalProblem problem = ReadBal(Path("a.txt"));
  ASSERT_EQ(problem.observations.size(), 2u);
  EXPECT_EQ(problem.observations[0].camera, 1);
  EXPECT_EQ(problem.observations[0].pixel, Vec2(-1.5, 25.0));
  EXPECT_EQ(problem.observations[1].pixel, Vec2(3.0, 0.5));
  EXPECT_EQ(problem.cameras[0], (Vec9() << 0.1, 0.2, 0.3, 1, 2, 3, 500, -0.1, 0.01).finished());
  EXPECT_EQ(problem.points, std::vector<Vec3>{Vec3(7, 8, -9)});
}

TEST_F(BalFiles, RoundTripKeepsEveryBit) {
  BalProblem problem = SmallProblem();
  Random random(2);
  for (Vec3& point : problem.points) {
    for (double& x : point) x = random.Normal() * std::pow(10.0, random.Uniform(-300, 14));
  }
  problem.points[0] = Vec3(-0.0, 5e-324, 1e15);
  WriteFileAtomically(Path("a.txt"), FormatBal(problem));
  const BalProblem read = ReadBal(Path("a.txt"));
  ExpectEqual(read, problem);
  EXPECT_TRUE(std::signbit(read.points[0].x()));
  EXPECT_EQ(FormatBal(read), test::ReadText(Path("a.txt")));
}

TEST_F(BalFiles, RoundTripOfARealProblemKeepsEveryBit) {
  const std::string path = DataPath("problem-49-7776-pre.txt");
  CH5_NEEDS(path);
  const BalProblem problem = ReadBal(path);
  EXPECT_EQ(problem.cameras.size(), 49u);
  EXPECT_EQ(problem.points.size(), 7776u);
  EXPECT_EQ(problem.observations.size(), 31843u);
  WriteFileAtomically(Path("a.txt"), FormatBal(problem));
  ExpectEqual(ReadBal(Path("a.txt")), problem);
}

TEST_F(BalFiles, FiveMegabytesAreReadInThreeTenthsOfASecond) {
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__) || !defined(NDEBUG)
  GTEST_SKIP() << "a measure for release builds";
#endif
  BalProblem made;  // of the size of problem-16-22106, which is taken where it is there
  Random random(7);
  const auto number = [&random](auto) { return 1e3 * random.Normal(); };
  for (int i = 0; i < 16; ++i) made.cameras.push_back(Vec9::NullaryExpr(number));
  for (int k = 0; k < 22106; ++k) {
    made.points.push_back(Vec3::NullaryExpr(number));
    for (int i = 0; i < 4 && made.observations.size() < 83718; ++i)
      made.observations.push_back({4 * (k % 4) + i, k, Vec2::NullaryExpr(number)});
  }
  WriteFileAtomically(Path("made.txt"), FormatBal(made));
  for (const std::string& path : {Path("made.txt"), DataPath("problem-16-22106-pre.txt")}) {
    if (!fs::exists(path)) continue;
    const std::clock_t start = std::clock();  // processor time: other work on the machine does not count
    EXPECT_EQ(ReadBal(path).observations.size(), 83718u);
    EXPECT_LT(static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC, 0.3) << path;
  }
}

// Half a turn about z, t = (1, 2, 3): the center is −Rᵀt = (1, 2, −3), and R maps the camera's axes onto themselves.
TEST(Bal, CameraCenterAndAxesByHand) {
  const Vec9 camera = (Vec9() << 0, 0, M_PI, 1, 2, 3, 500, 0, 0).finished();
  EXPECT_LT((CameraCenter(camera) - Vec3(1, 2, -3)).norm(), 1e-14);
  EXPECT_LT((CameraAxes(camera) - Mat33(Vec3(-1, -1, -1).asDiagonal())).norm(), 1e-14);
}

TEST(Bal, PlyHoldsPointsAndCameras) {
  const std::string text = FormatBalPly(SmallProblem());
  EXPECT_EQ(text.compare(0, 4, "ply\n"), 0);
  EXPECT_NE(text.find("element vertex 16\n"), std::string::npos);  // 12 points, 4 cameras
  EXPECT_EQ(std::count(text.begin(), text.end(), '\n'), 10 + 16);  // the header has ten lines
}

TEST(Bal, GraphRefusesAnIndexOutOfRange) {
  BalProblem problem = SmallProblem();
  problem.observations[3].point = 12;
  EXPECT_THROW(BuildBal(problem, nullptr), std::invalid_argument);
}

TEST(Bal, AGraphIsReadBackIntoItsOwnProblem) {
  BalProblem problem = SmallProblem(), other;
  BalGraph bal = BuildBal(problem, nullptr);
  EXPECT_EQ(bal.graph.Edges().size(), problem.observations.size());
  EXPECT_THROW(ReadBack(bal, &other), std::invalid_argument);
  bal.points[0]->Parameters() << 1, 2, 3;
  ReadBack(bal, &problem);
  EXPECT_EQ(problem.points[0], Vec3(1, 2, 3));
}

TEST(Bal, PerturbedProblemReturnsToItsPerfectFit) {
  BalProblem problem = SmallProblem();
  BalGraph bal = BuildBal(problem, nullptr);
  EXPECT_LT(MeanReprojectionError(bal.graph), 1e-12);
  Random random(3);
  for (Vec3& point : problem.points) {
    for (double& x : point) x += 0.05 * random.Normal();
  }
  const BalStudy study = SolveBal(problem, {});
  EXPECT_GT(study.mean_error_before, 1.0);
  EXPECT_LT(study.mean_error_after, 1e-3);
  EXPECT_EQ(study.before.points, problem.points);
}

TEST(Bal, TheWorldsOriginIsOfNoMatter) {
  std::vector<double> costs;
  for (const Vec3& origin : {Vec3(0, 0, 0), Vec3(512345.678, 4649776.22, 100.0), Vec3(1e7, 0, 0)}) {  // the second: UTM
    BalProblem problem = SmallProblem();
    Random random(3);
    for (BalObservation& observation : problem.observations) observation.pixel += NormalVector(&random, 0.5).head<2>();
    for (Vec9& camera : problem.cameras) camera.segment<3>(3) -= ExpSO3(camera.head<3>()) * origin;
    for (Vec3& point : problem.points) point += origin + NormalVector(&random, 0.3);
    BalGraph bal = BuildBal(problem, nullptr);
    costs.push_back(SparseOptimizer(&bal.graph).Solve().final_cost);
    ReadBack(bal, &problem);
    BalGraph again = BuildBal(problem, nullptr);
    EXPECT_NEAR(Cost(again.graph) / costs.back(), 1.0, 1e-4) << "what is returned is where the file has it";
    EXPECT_NEAR(costs.back() / costs[0], 1.0, 1e-4);
  }
}

// Cameras half a meter apart, points 5 to 200 m away, each believed nearer or farther by a factor of two or so.
TEST(Bal, DistantPointsTakeFewerStepsAlongTheirRays) {
  for (int seed = 1; seed <= 12; ++seed) {
    Random random(seed);
    BalProblem problem;
    for (int i = 0; i < 4; ++i) {
      problem.cameras.push_back((Vec9() << 0, 0, 0, 0.5 * i, 0, 0, 500, 0, 0).finished());
    }
    for (int k = 0; k < 40; ++k) {
      const double x = random.Uniform(-0.5, 0.5), y = random.Uniform(-0.5, 0.5), d = random.Uniform(5, 200);
      problem.points.push_back(d * Vec3(x, y, -1));
    }
    Observe(&problem);
    for (BalObservation& observation : problem.observations) observation.pixel += NormalVector(&random, 0.5).head<2>();
    for (Vec3& point : problem.points) point *= std::exp2(random.Normal());
    FileSolveOptions options;
    options.solve.max_iterations = 200;
    const Summary ray = SolveBal(problem, options, BalPoints::kOnRay).summary,
                  xyz = SolveBal(problem, options, BalPoints::kXyz).summary;
    const auto steps = [&](const Summary& summary) {
      const auto is_near = [&](const IterationInfo& info) { return info.cost < 1.01 * ray.final_cost; };
      return std::find_if(summary.trace.begin(), summary.trace.end(), is_near) - summary.trace.begin();
    };
    EXPECT_LT(steps(ray), steps(xyz)) << seed;
    EXPECT_LE(steps(ray), 12) << seed;
    EXPECT_LT(ray.final_cost, 1.01 * xyz.final_cost) << seed;
  }
}

// One measurement is off by 1000 px: Huber's loss keeps the others' fit.
TEST(Bal, HuberKeepsTheFitInSpiteOfAnOutlier) {
  BalProblem problem = SmallProblem();
  problem.observations[5].pixel.x() += 1000.0;
  FileSolveOptions options;
  const auto median_error = [&] {
    const BalStudy study = SolveBal(problem, options);
    BalGraph bal = BuildBal(study.after, nullptr);
    std::vector<double> errors;
    for (const auto& edge : bal.graph.Edges()) {
      edge->ComputeResidual();
      errors.push_back(edge->Residual().norm());
    }
    std::nth_element(errors.begin(), errors.begin() + 24, errors.end());
    return errors[24];
  };
  const double plain = median_error();
  options.huber = 1.0;
  EXPECT_LT(median_error(), 0.5 * plain);  // an outlier still pulls, with the force of one pixel
}

TEST(Bal, PointInACamerasPlaneIsNamed) {
  BalProblem problem = SmallProblem();
  problem.cameras[2].head<3>().setZero();  // P = X + (0, 0, −5)
  problem.points[0] = Vec3(0.5, 0, 5);
  const std::string what = test::Refusal<std::invalid_argument>([&] { SolveBal(problem, {}); });
  EXPECT_NE(what.find("observation 2: point 0 cannot be projected into camera 2"), std::string::npos) << what;
}

// It has no direction there, and its Jacobians would stop the whole solve.
TEST(Bal, APointAtACamerasCenterFindsItsPlace) {
  for (const Vec3& beside : {Vec3(0, 0, 0), Vec3(1e-15, 0, -1e-15), Vec3(0, 1e-8, 0)}) {
    BalProblem problem = SmallProblem();
    Random random(3);
    for (BalObservation& observation : problem.observations) observation.pixel += NormalVector(&random, 0.5).head<2>();
    FileSolveOptions options;
    options.solve.max_iterations = 100;
    const double cost = SolveBal(problem, options).summary.final_cost;
    problem.points[0] = CameraCenter(problem.cameras[2]) + beside;
    const BalStudy study = SolveBal(problem, options);
    EXPECT_NEAR(study.summary.final_cost / cost, 1.0, 1e-2) << study.summary.message;
  }
}

TEST(Bal, ZeroIterationsChangeNothing) {
  BalProblem problem = SmallProblem();
  problem.points[0].x() += 0.1;
  FileSolveOptions options;
  options.solve.max_iterations = 0;
  const BalStudy study = SolveBal(problem, options);
  EXPECT_EQ(study.summary.termination, Termination::kMaxIterations);
  ExpectEqual(study.after, problem);
}

// Four cameras and 72 points with half a pixel of noise: the dense solver's optimum.
TEST(Bal, ASimulatedProblemReachesTheDenseOptimum) {
  Random random(9);
  BalProblem problem = SmallProblem();
  for (int k = 0; k < 60; ++k) problem.points.push_back(NormalVector(&random, 0.5));
  problem.observations.clear();
  Observe(&problem);
  for (BalObservation& observation : problem.observations) observation.pixel += NormalVector(&random, 0.5).head<2>();
  SolveOptions options;
  options.max_iterations = 500;
  options.cost_tolerance = 1e-12;
  BalGraph dense = BuildBal(problem, nullptr);
  const double optimum = Problem(&dense.graph).Solve(options).final_cost;
  for (Vec3& point : problem.points) point += NormalVector(&random, 0.05);
  FileSolveOptions sparse;
  sparse.solve.max_iterations = 200;
  const BalStudy study = SolveBal(problem, sparse);
  EXPECT_NEAR(study.summary.final_cost / optimum, 1.0, 1e-3) << study.summary.message;
  EXPECT_TRUE(IsConverged(study.summary.termination)) << study.summary.message;
}

// Where points are few the cameras are eliminated: the system that is left has 3 unknowns a point. The minimum is the same.
TEST(Bal, OfFewPointsTheCamerasAreEliminated) {
  Random random(10);
  BalProblem problem = SmallProblem();
  for (int i = 0; i < 16; ++i) problem.cameras.push_back(problem.cameras[i % 4] + NormalVector<9>(&random, 0.01));
  problem.observations.clear();
  Observe(&problem);
  for (BalObservation& observation : problem.observations) observation.pixel += NormalVector(&random, 0.5).head<2>();
  const auto optimum = [&](bool eliminates_cameras) {
    BalGraph bal = BuildBal(problem, nullptr);
    EXPECT_EQ(bal.cameras[0]->GetRole(), Role::kLandmark);
    EXPECT_EQ(bal.points[0]->GetRole(), Role::kPose);
    for (const auto& vertex : bal.graph.Vertices())
      if (!eliminates_cameras) vertex->SetRole(vertex->GetRole() == Role::kPose ? Role::kLandmark : Role::kPose);
    SolveOptions options;
    options.max_iterations = 200;
    options.cost_tolerance = 1e-10;
    const Summary summary = SparseOptimizer(&bal.graph).Solve(options);
    EXPECT_TRUE(IsConverged(summary.termination)) << summary.message;
    return summary.final_cost;
  };
  EXPECT_NEAR(optimum(true) / optimum(false), 1.0, 1e-6);
}

// The optimum that Ceres finds, and a tenth of a percent.
void ExpectCost(const std::string& name, double cost) {
  const std::string path = DataPath(name);
  CH5_NEEDS(path);
  const BalStudy study = SolveBal(ReadBal(path), {});
  EXPECT_LE(study.summary.final_cost, cost * (1.0 + 1e-3)) << study.summary.message;
  EXPECT_GE(study.summary.final_cost, cost * (1.0 - 1e-3));
  EXPECT_TRUE(IsConverged(study.summary.termination)) << study.summary.message;
  // The cost is that of the states that are returned.
  BalGraph bal = BuildBal(study.after, nullptr);
  EXPECT_NEAR(Cost(bal.graph), study.summary.final_cost, 1e-9 * cost);
}

TEST(Bal, Ladybug49ReachesItsOptimum) { ExpectCost("problem-49-7776-pre.txt", 1.33452e4); }
TEST(Bal, Dubrovnik16ReachesItsOptimum) { ExpectCost("problem-16-22106-pre.txt", 1.803390e4); }

}  // namespace
}  // namespace ch5
