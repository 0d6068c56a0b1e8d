/// Stage 4, one function after the other: the null space of the gauge's motions (4a, 4b), the projection (4c), the
/// motion's Jacobian (4d), and the covariance of another gauge (4e), first on matrices without structure, then on whole
/// problems, where it must be the one that is computed directly in the other gauge.

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <optional>

#include "ch5_homework/judge/ask.h"
#include "ch5_homework/judge/right/gauge_freedom.h"
#include "ch5_homework/judge/stage_4_scene.h"

namespace ch5::homework {
namespace {

constexpr GaugeGroup kGroups[] = {GaugeGroup::kVisualInertial, GaugeGroup::kMonocular};
constexpr double kTolerance = 1e-7;            // of our numerical derivatives
constexpr double kBlockTolerance = 1e-8;       // of formulas, which may be differences; less than a float's
constexpr double kSmallestEigenvalue = 5e-9;   // of the largest one
constexpr double kCovarianceTolerance = 1e-5;  // over 1000 seeds they are exact to 1.3e-8

// ---- the student's functions ----------------------------------------------------------------------------------------
// The given code makes matrices of the right size.

/// @param only  of this vertex alone
MatXX NullSpace(Scene& scene, GaugeGroup group, std::optional<int> only = {}) {
  const VertexList all = scene.Vertices();
  Values given{{"group", group}};
  if (only) given.Put("only", *only);
  const VertexList asked = only ? VertexList{all.at(static_cast<size_t>(*only))} : all;
  return Ask("GaugeNullSpace", scene, given).Sized("U", TotalLocalDimension(asked), NumGaugeDirections(group));
}

MatXX Projection(const MatXX& U, const MatXX& V) {
  return Ask("GaugeProjection", {{"U", U}, {"V", V}}).Sized("Q", U.rows(), U.rows());
}

MatXX MotionJacobian(Scene& scene, double yaw) {
  const int size = TotalLocalDimension(scene.Vertices());
  return Ask("GaugeMotionJacobian", scene, {{"yaw", yaw}}).Sized("motion", size, size);
}

MatXX Transformed(const MatXX& covariance, const MatXX& motion, const MatXX& Q, const MatXX& Q_C) {
  return Ask("TransformCovariance", {{"covariance", covariance}, {"motion", motion}, {"Q", Q}, {"Q_C", Q_C}})
      .Sized("transformed", covariance.rows(), covariance.cols());
}

// ---- 4a, the rows of a pose -----------------------------------------------------------------------------------------

// Three rows block by block, so that a mistake is named whatever the other blocks are.
void CheckBlock(const Text& what, const formula::Formula& right, const MatXX& got, const std::string& row,
                const Names& columns, const std::string& todo) {
  Require({what, todo, {}, {Words({row + ".x", row + ".y", row + ".z"}), columns}, kBlockTolerance}, right, got);
}

Names Shifts(GaugeGroup group) {
  const Names all = DirectionNames(group);
  return {all.begin(), all.begin() + 3};
}

Names Turns(GaugeGroup group) {
  const Names all = DirectionNames(group);
  return {all.begin() + 3, all.begin() + 3 + AxesOf(group).cols()};
}

// A shift of the world leaves these rows alone.
const formula::Formula& Unshifted() {
  static const formula::Formula right{formula::Matrix("I", MatXX::Identity(3, 3))};
  return right;
}

void CheckPose(const VertexPose& pose, const MatXX& U, GaugeGroup group) {
  const right::PoseRows right(pose.p(), pose.R(), AxesOf(group));
  const Eigen::Index k = AxesOf(group).cols();
  const auto of = [&](const char* what) { return Text("4.rows_pose", {{"what", what}, {"system", NameOf(group)}}); };
  const MatXX shift = U.block(3, 0, 3, 3) + MatXX::Identity(3, 3);
  CheckBlock(of("4.turn_of_position"), right.dp_domega, U.block(0, 3, 3, k), "δp", Turns(group), "4a");
  CheckBlock(of("4.turn_of_rotation"), right.dtheta_domega, U.block(3, 3, 3, k), "δθ", Turns(group), "4a");
  CheckBlock(of("4.shift_of_position"), right.dp_dt, U.topLeftCorner(3, 3), "δp", Shifts(group), "4a");
  CheckBlock(of("4.shift_of_rotation"), Unshifted(), shift, "δθ", Shifts(group), "4a");
}

TEST(Stage4, APoseMovesWithTheWorld) {
  for (const GaugeGroup group : kGroups) {
    GraphScene scene("vertices of a type", {0, 5, 83});
    for (size_t k = 0; k < scene.vertices.size(); ++k) {
      CheckPose(dynamic_cast<const VertexPose&>(*scene.vertices[k]), NullSpace(scene, group, static_cast<int>(k)),
                group);
    }
  }
}

// Paper and pencil: R takes x to y, y to z and z to x; p = (2, 1, 0).
TEST(Stage4, APoseOnPaper) {
  GraphScene scene("pose on paper");
  CheckPose(dynamic_cast<const VertexPose&>(*scene.vertices[0]), NullSpace(scene, GaugeGroup::kVisualInertial),
            GaugeGroup::kVisualInertial);
}

// ---- 4b, the rows of a velocity -------------------------------------------------------------------------------------

TEST(Stage4, AVelocityTurnsAndIsNotShifted) {
  for (const GaugeGroup group : kGroups) {
    GraphScene scene("vertices of a type", {1, 5, 89});
    for (size_t vertex = 0; vertex < scene.vertices.size(); ++vertex) {
      const auto& speed = dynamic_cast<const VertexSpeedBias&>(*scene.vertices[vertex]);
      const MatXX U = NullSpace(scene, group, static_cast<int>(vertex)), axes = AxesOf(group);
      const auto of = [&](const char* what) { return Text(what, {{"system", NameOf(group)}}); };
      CheckBlock(of("4.shift_of_velocity"), Unshifted(), U.topLeftCorner(3, 3) + MatXX::Identity(3, 3), "δv",
                 Shifts(group), "4b");
      CheckBlock(of("4.turn_of_velocity"), right::VelocityTurned(speed.v(), axes), U.block(0, 3, 3, axes.cols()), "δv",
                 Turns(group), "4b");
    }
  }
}

// Whatever the number and the order of the vertices; the rows of points, biases and depths, and the scale, are given.
TEST(Stage4, TheNullSpaceIsTheDerivativeOfTheWorldsMotion) {
  for (const GaugeGroup group : kGroups) {
    for (const int count : {4, 9, 17}) {
      GraphScene scene("vertices of all types", {count, 97});
      const Vertices& vertices = scene.vertices;
      const Text of("4.U_of_vertices", {{"n", Word(count)}, {"system", NameOf(group)}});
      Require({of, {}, {}, {RowNames(vertices), DirectionNames(group)}, kTolerance}, NumericNullSpace(vertices, group),
              NullSpace(scene, group));
    }
  }
}

// ---- 4c, the projection ---------------------------------------------------------------------------------------------

void CheckProjection(const MatXX& U, const MatXX& V, const Names& names, const Text& what) {
  Require({what, "4c", "Q", names, 1e-9}, right::Projection(U, V), Projection(U, V));
}

TEST(Stage4, TheProjectionEndsInTheGaugeWhateverUAndVAre) {
  for (const int columns : {1, 2, 4, 7}) {
    Random random(Seed(101 + static_cast<uint64_t>(columns)));
    const int n = 2 * columns + 5;
    const MatXX U = RandomMatrix(n, columns, &random), V = U + RandomMatrix(n, columns, &random);
    CheckProjection(U, V, {},
                    {"4.Q_of_random_U_V", {{"size", Word(std::to_string(n) + "×" + std::to_string(columns))}}});
  }
}

// Two scalars and their difference: U = (1, 1)ᵀ, and the first is held.
TEST(Stage4, TheProjectionOnPaper) {
  CheckProjection(Vec2(1, 1), Vec2(1, 0), Words({"x1", "x2"}), "4.Q_of_two_scalars");
}

TEST(Stage4, TheProjectionRemovesTheGaugesMotionsAndNothingElse) {
  for (const GaugeGroup group : kGroups) {
    const FreeScene scene(group, 3, 4, 103);
    const MatXX U = NumericNullSpace(scene.vertices, group);
    for (const bool held : {true, false}) {
      const Text gauge = held ? "4.held_first_frame" : "4.free_V_U";
      const MatXX V = held ? scene.FirstFrame(group) : U;
      CheckProjection(U, V, RowNames(scene.vertices), {"4.Q_of_gauge", {{"system", NameOf(group)}, {"gauge", gauge}}});
    }
  }
}

// ---- 4d, the Jacobian of the motion ---------------------------------------------------------------------------------

void CheckMotion(GraphScene& scene, double yaw, const Text& what) {
  const Motion g{1.0, ExpSO3(Vec3(0, 0, yaw)), Vec3(1, -2, 3)};  // t must not matter
  const MatXX got = MotionJacobian(scene, yaw);
  const Names names = RowNames(scene.vertices);
  const Text of("4.motion_jacobian_of", {{"scene", what}, {"n", Word(yaw)}});
  int row = 0;
  for (const auto& vertex : scene.vertices) {
    const int dim = vertex->LocalDimension();
    Require({of, "4d", {}, {Names(names.begin() + row, names.begin() + row + dim), names}, kBlockTolerance},
            right::MotionRows(g.R.toRotationMatrix(), row, dim, static_cast<int>(got.cols())),
            got.middleRows(row, dim));
    row += dim;
  }
  Require({of, "4d", {}, names, kTolerance}, NumericMotionJacobian(scene.vertices, g), got);
}

TEST(Stage4, TheMotionTurnsWhatIsExpressedInTheWorld) {
  Random random(Seed(107));
  const double yaw = random.Uniform(0.5, 2.0);
  int type = 0;
  for (const char* words : {"4.pose", "4.velocity_biases", "4.point"}) {
    GraphScene scene("vertices of a type", {type++, 1, 108});
    CheckMotion(scene, yaw, words);
  }
  for (const int count : {4, 7, 15}) {
    GraphScene scene("vertices of all types", {count, 109});
    CheckMotion(scene, -random.Uniform(0.0, 3.0), {"4.vertices", {{"n", Word(count)}}});
  }
}

// ---- 4e, the product ------------------------------------------------------------------------------------------------

TEST(Stage4, TheCovarianceIsMultipliedFromBothSides) {
  for (const int n : {3, 6, 10}) {
    Random random(Seed(109 + static_cast<uint64_t>(n)));
    const MatXX C = RandomPositiveDefinite(n, &random);
    const MatXX M = RandomMatrix(n, n, &random).householderQr().householderQ();  // orthogonal, as every ∂θ_C/∂θ is
    const MatXX U = RandomMatrix(n, n / 3, &random), V = U + RandomMatrix(n, n / 3, &random);
    const MatXX Q = ProjectionByItsEffect(U, V), Q_C = M * Q * M.transpose();  // the same gauge at θ and at θ_C
    const MatXX got = Transformed(C, M, Q, Q_C);
    const bool exploded = !got.allFinite() || (got.size() > 0 && got.norm() > 1e8);  // all that is given is near 1
    const Text of("4.covariance_of_random", {{"size", Word(std::to_string(n) + "×" + std::to_string(n))}});
    Require({of, "4e", "transformed", {}, 1e-10, {{"4e", "4.T_has_no_inverse", exploded ? got : MatXX()}}},
            right::OfOtherGauge(C, M, Q, Q_C), got);
  }
}

// The handout's example: one measurement of x2 − x1 with σ = 2.
TEST(Stage4, TheExampleOfTheHandout) {
  const Vec2 U(1, 1), V(1, 0);
  const MatXX free = (MatXX(2, 2) << 1, -1, -1, 1).finished(), fixed = (MatXX(2, 2) << 0, 0, 0, 4).finished();
  const MatXX I = MatXX::Identity(2, 2), H = 0.25 * free;
  ASSERT_TRUE(FreeCovariance(H, 1).isApprox(free) && FixedCovariance(H, V).isApprox(fixed)) << "the handout is wrong";
  const Names names = Words({"x1", "x2"});
  Require({"4.handout_held", {}, {}, names}, fixed, Transformed(free, I, Projection(U, V), Projection(U, V)));
  Require({"4.handout_set_free", {}, {}, names}, free, Transformed(fixed, I, Projection(U, U), Projection(U, U)));
}

// ---- all together ---------------------------------------------------------------------------------------------------

// A scene whose covariances can be compared: none of its directions is nearly as free as the gauge.
std::unique_ptr<FreeScene> WellConditioned(GaugeGroup group, int frames, int points, int seed) {
  const int nullity = group == GaugeGroup::kVisualInertial ? 4 : 7;
  for (;; seed += 1000) {
    auto scene = std::make_unique<FreeScene>(group, frames, points, seed);
    const VecX eigenvalues = scene->Hessian().selfadjointView<Eigen::Lower>().eigenvalues();
    if (eigenvalues(nullity) > kSmallestEigenvalue * eigenvalues(eigenvalues.size() - 1)) return scene;
  }
}

// The free estimate is moved by g, so that it holds the gauge of the first frame; and back.
void CheckGauges(GaugeGroup group, int frames, int points, int seed) {
  const auto drawn = WellConditioned(group, frames, points, seed);
  FreeScene& scene = *drawn;
  const Names names = RowNames(scene.vertices);
  const auto of = [&](const Text& what) {
    return Text("4.frames", {{"what", what}, {"system", NameOf(group)}, {"n", Word(frames)}});
  };
  const MatXX H = scene.Hessian(), U = NullSpace(scene, group);
  const MatXX ones = MatXX::Ones(U.rows(), U.cols());
  Require({of("4.I_H_U"), {}, {}, {names, DirectionNames(group)}, 1e-9}, ones, ones + H * U / H.cwiseAbs().maxCoeff());
  const MatXX free = FreeCovariance(H, static_cast<int>(U.cols()));
  const MatXX Q = Projection(U, scene.FirstFrame(group)), Q_free = Projection(U, U);

  const double yaw = 0.4 + 0.1 * static_cast<double>(frames);
  MoveAll({1.0, ExpSO3(Vec3(0, 0, yaw)), Vec3(3, -2, 1)}, scene.vertices);
  const MatXX V = scene.FirstFrame(group), fixed = FixedCovariance(scene.Hessian(), V);
  const MatXX U_C = NullSpace(scene, group);
  const MatXX Q_C = Projection(U_C, V), Q_C_free = Projection(U_C, U_C);
  const MatXX motion = MotionJacobian(scene, yaw);
  ASSERT_GT((free - fixed).norm(), 0.1 * fixed.norm()) << "the scene is too easy: both gauges have one covariance";
  const auto require = [&](const char* what, const MatXX& right, const MatXX& got) {
    Require({of(what), {}, {}, names, kCovarianceTolerance}, right, got);
  };
  require("4.covariance_held", fixed, Transformed(free, motion, Q, Q_C));

  const MatXX back = MotionJacobian(scene, -yaw);
  require("4.covariance_set_free", free, Transformed(fixed, back, Q_C_free, Q_free));
}

TEST(Stage4, FreeAndFixedCovariancesOfACameraWithAnImuAreOne) {
  CheckGauges(GaugeGroup::kVisualInertial, 4, 6, 113);
  CheckGauges(GaugeGroup::kVisualInertial, 6, 5, 127);
}

TEST(Stage4, FreeAndFixedCovariancesOfACameraAloneAreOne) {
  CheckGauges(GaugeGroup::kMonocular, 3, 8, 131);
  CheckGauges(GaugeGroup::kMonocular, 5, 6, 137);
}

}  // namespace
}  // namespace ch5::homework
