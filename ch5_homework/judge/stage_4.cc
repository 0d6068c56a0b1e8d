/// Stage 4, one function after the other: the null space of the gauge's motions (4a, 4b), the projection (4c) and the
/// motion's Jacobian (4d). stage_4_covariance.cc has the covariance (4e) and the whole.

#include <gtest/gtest.h>

#include <Eigen/LU>

#include "ch5_homework/judge/stage_4_scene.h"
#include "ch5_homework/judge/submission.h"

namespace ch5::homework {
namespace {

constexpr GaugeGroup kGroups[] = {GaugeGroup::kVisualInertial, GaugeGroup::kMonocular};
constexpr double kTolerance = 1e-7;  // of numerical derivatives

std::function<MatXX()> Is(const MatXX& answer) {
  return [answer] { return answer; };
}

// ---- 4a, the rows of a pose -----------------------------------------------------------------------------------------

// What typical mistakes give for the blocks of a pose's rows.
struct PoseMistakes {
  MatXX axes, turn, R, Rt, O;
  Vec3 phi;

  PoseMistakes(const VertexPose& pose, GaugeGroup group)
      : axes(AxesOf(group)),
        turn(Hat(pose.p()) * axes),
        R(pose.R()),
        Rt(R.transpose()),
        O(MatXX::Zero(3, axes.cols())),
        phi(LogSO3(pose.q())) {}

  std::vector<Mistake> InShifts() const {
    return {{"4a", "the block is still zero", Is(MatXX::Zero(3, 3))},
            {"4a", "R stands here, but p and t are both expressed in W", Is(R)},
            {"4a", "Rᵀ stands here, but p and t are both expressed in W", Is(Rt)}};
  }
  std::vector<Mistake> InTurnsOfThePosition() const {
    return {{"4a", "the block is still zero", Is(O)},
            {"4a", "the sign: ω × p = −p × ω = −Hat(p) ω", Is(turn)},
            {"4a", "R stands before the turn, but p and ω are both expressed in W", Is(-R * turn)},
            {"4a", "Rᵀ stands before the turn, but p and ω are both expressed in W", Is(-Rt * turn)},
            {"4a", "the axes alone: the motion is ω × p, it grows with p", Is(axes)}};
  }
  std::vector<Mistake> InTurnsOfTheRotation() const {
    return {{"4a", "the block is still zero", Is(O)},
            {"4a", "this is the row of a left perturbation, Exp(δφ) R, as in the paper; ours is R Exp(δθ), so δθ = Rᵀω",
             Is(axes)},
            {"4a", "R stands where Rᵀ is meant: δθ is expressed in the body, δθ = Rᵀω", Is(R * axes)},
            {"4a", "the sign: Exp(ω) R = R Exp(δθ), so δθ = +Rᵀω", Is(-Rt * axes)},
            {"4a", "J_l⁻¹ belongs to Δφ of the paper's first frame; here δθ = Rᵀω",
             Is(RightJacobianInverseSO3(-phi) * axes)},
            {"4a", "J_r⁻¹ belongs to the coordinates Log R; here δθ = Rᵀω", Is(RightJacobianInverseSO3(phi) * axes)},
            {"4a", "this is the turn of the position, Hat(p); a rotation does not depend on p", Is(-turn)}};
  }
};

// The blocks of a pose, so that each mistake is told whatever the other blocks are.
void CheckPose(const VertexPose& pose, const MatXX& U, const MatXX& right, GaugeGroup group) {
  const PoseMistakes mistakes(pose, group);
  const Eigen::Index k = mistakes.axes.cols();
  const auto check = [&](const std::string& what, const MatXX& expected, const MatXX& got, const std::string& row,
                         const Names& columns, const std::vector<Mistake>& typical) {
    ASSERT_NO_STORY({"4",
                     what + ", the rows of a pose of " + NameOf(group),
                     expected,
                     got,
                     {row + ".x", row + ".y", row + ".z"},
                     typical,
                     kTolerance,
                     columns});
  };
  const Names all = DirectionNames(group), shifts(all.begin(), all.begin() + 3),
              turns(all.begin() + 3, all.begin() + 3 + k);
  const MatXX I = MatXX::Identity(3, 3);
  check("∂δp/∂t in U", right.topLeftCorner(3, 3), U.topLeftCorner(3, 3), "δp", shifts, mistakes.InShifts());
  if (testing::Test::HasFatalFailure()) return;
  check("∂δp/∂ω in U, the turns", right.block(0, 3, 3, k), U.block(0, 3, 3, k), "δp", turns,
        mistakes.InTurnsOfThePosition());
  if (testing::Test::HasFatalFailure()) return;
  check("∂δθ/∂ω in U, the turns", right.block(3, 3, 3, k), U.block(3, 3, 3, k), "δθ", turns,
        mistakes.InTurnsOfTheRotation());
  if (testing::Test::HasFatalFailure()) return;
  check("I + ∂δθ/∂t in U", I, I + U.block(3, 0, 3, 3), "δθ", shifts,
        {{"4a", "a shift turns nothing: these columns are zero", Is(2.0 * I)}});
}

// Paper and pencil: R takes x to y, y to z and z to x; p = (2, 1, 0).
TEST(Stage4, APoseOnPaper) {
  auto pose = std::make_shared<VertexPose>(Qd(0.5, 0.5, 0.5, 0.5), Vec3(2, 1, 0));
  MatXX right = MatXX::Zero(6, 4);
  right.topLeftCorner<3, 3>().setIdentity();
  right.col(3) << -1, 2, 0, 0, 1, 0;
  const MatXX U = Chosen().gauge_freedom.null_space({pose}, GaugeGroup::kVisualInertial);
  CheckPose(*pose, U, right, GaugeGroup::kVisualInertial);
}

TEST(Stage4, APoseMovesWithTheWorld) {
  for (const GaugeGroup group : kGroups) {
    Random random(Seed(83));
    for (int trial = 0; trial < 5; ++trial) {
      const auto pose = RandomPose(&random);
      CheckPose(*pose, Chosen().gauge_freedom.null_space({pose}, group), NumericNullSpace({pose}, group), group);
      if (HasFatalFailure()) return;
    }
  }
}

// ---- 4b, the rows of a velocity -------------------------------------------------------------------------------------

TEST(Stage4, AVelocityTurnsAndIsNotShifted) {
  for (const GaugeGroup group : kGroups) {
    Random random(Seed(89));
    for (int trial = 0; trial < 5; ++trial) {
      const auto speed = RandomSpeedBias(&random);
      const Eigen::Index columns = 3 + AxesOf(group).cols();
      const MatXX right = NumericNullSpace({speed}, group).topLeftCorner(3, columns);
      const MatXX got = Chosen().gauge_freedom.null_space({speed}, group).topLeftCorner(3, columns);
      const MatXX turn = Hat(speed->v()) * AxesOf(group);
      const auto rows = [&](const MatXX& left, const MatXX& turns) {
        return Is((MatXX(3, columns) << left, turns).finished());
      };
      const MatXX O = MatXX::Zero(3, 3), I = MatXX::Identity(3, 3);
      ASSERT_NO_STORY({"4",
                       "U, the rows of a velocity of " + NameOf(group),
                       right,
                       got,
                       {"δv.x", "δv.y", "δv.z"},
                       {{"4b", "the rows are still zero", rows(O, O.leftCols(columns - 3))},
                        {"4b", "the sign: ω × v = −v × ω = −Hat(v) ω", rows(O, turn)},
                        {"4b", "a velocity is not shifted: the columns of t are zero", rows(I, -turn)},
                        {"4b", "a velocity is not shifted: the columns of t are zero; and the sign: ω × v = −Hat(v) ω",
                         rows(I, turn)},
                        {"4b", "the axes alone: the motion is ω × v, it grows with v", rows(O, AxesOf(group))}},
                       kTolerance,
                       DirectionNames(group)});
    }
  }
}

// Whatever the number and the order of the vertices; the rows of points, biases and depths, and the scale, are given.
TEST(Stage4, TheNullSpaceIsTheDerivativeOfTheWorldsMotion) {
  for (const GaugeGroup group : kGroups) {
    for (const int count : {4, 9, 17}) {
      Random random(Seed(97 + static_cast<uint64_t>(count)));
      const Vertices vertices = RandomVertices(count, &random);
      ASSERT_NO_STORY({"4",
                       "U of " + std::to_string(count) + " vertices of " + NameOf(group),
                       NumericNullSpace(vertices, group),
                       Chosen().gauge_freedom.null_space(vertices, group),
                       RowNames(vertices),
                       {},
                       kTolerance,
                       DirectionNames(group)});
    }
  }
}

// ---- 4c, the projection ---------------------------------------------------------------------------------------------

// Q by what it does: it takes U to zero, and leaves alone what satisfies Vᵀδ = 0.
MatXX ProjectionByItsEffect(const MatXX& U, const MatXX& V) {
  MatXX basis(U.rows(), U.rows()), image = MatXX::Zero(U.rows(), U.rows());
  basis << U, Complement(V);
  image.rightCols(U.rows() - U.cols()) = Complement(V);
  return image * basis.inverse();
}

void CheckProjection(const MatXX& U, const MatXX& V, const Names& names, const std::string& scene) {
  const MatXX I = MatXX::Identity(U.rows(), U.rows()), Vt = V.transpose(), A = Vt * U;
  const auto minus = [&](const MatXX& lost) { return Is(I - lost); };
  const MatXX right = ProjectionByItsEffect(U, V), lost = I - right;
  ASSERT_NO_STORY(
      {"4",
       "Q" + scene,
       right,
       Chosen().gauge_freedom.projection(U, V),
       names,
       {{"4c", "Q is still the identity", Is(I)},
        {"4c", "this is Qᵀ: U and V have exchanged their places", Is(right.transpose())},
        {"4c", "the sign: U (VᵀU)⁻¹ Vᵀ is added, not subtracted", Is(I + lost)},
        {"4c", "this is U (VᵀU)⁻¹ Vᵀ itself, what δ loses: Q is I minus that", Is(lost)},
        {"4c", "this is −U (VᵀU)⁻¹ Vᵀ: the identity is lost, it is `Q -= …`", Is(-lost)},
        {"4c", "(UᵀV)⁻¹ stands where (VᵀU)⁻¹ is meant", minus(U * A.transpose().inverse() * Vt)},
        {"4c", "(VᵀU)⁻¹ is missing: this is I − U Vᵀ", minus(U * Vt)},
        {"4c", "VᵀU stands where its inverse is meant", minus(U * A * Vt)},
        {"4c", "V stands where U is meant: δ must move along U, V only says how far", minus(V * A.inverse() * Vt)},
        {"4c", "U stands where V is meant: V says which δ are wanted", minus(U * A.inverse() * U.transpose())},
        {"4c", "V is nowhere: this is the projection of the free gauge, V = U",
         minus(U * (U.transpose() * U).inverse() * U.transpose())}},
       1e-9});
}

// Two scalars and their difference: U = (1, 1)ᵀ, and the first is held.
TEST(Stage4, TheProjectionOnPaper) { CheckProjection(Vec2(1, 1), Vec2(1, 0), {"x1", "x2"}, " of two scalars"); }

TEST(Stage4, TheProjectionEndsInTheGaugeWhateverUAndVAre) {
  for (const int columns : {1, 2, 4, 7}) {
    Random random(Seed(101 + static_cast<uint64_t>(columns)));
    const int n = 2 * columns + 5;
    const MatXX U = RandomMatrix(n, columns, &random), V = U + RandomMatrix(n, columns, &random);
    CheckProjection(U, V, {}, " of random U and V, " + std::to_string(n) + "×" + std::to_string(columns));
    if (HasFatalFailure()) return;
  }
}

TEST(Stage4, TheProjectionRemovesTheGaugesMotionsAndNothingElse) {
  for (const GaugeGroup group : kGroups) {
    const FreeScene scene(group, 3, 4, 103);
    const MatXX U = NumericNullSpace(scene.vertices, group);
    for (const bool held : {true, false}) {
      const std::string gauge = held ? "held at its first frame" : "free, V = U";
      const MatXX V = held ? scene.FirstFrame(group) : U;
      const MatXX Q = Chosen().gauge_freedom.projection(U, V), I = MatXX::Identity(U.rows(), U.rows());
      const auto check = [&](const std::string& what, const MatXX& expected, const MatXX& got) {
        ASSERT_NO_STORY({"4", what + " for " + NameOf(group) + ", " + gauge, expected, got, {}, {}, 1e-9});
      };
      check("I + Q U, where Q U must be zero: a motion of the world is no change", MatXX::Ones(U.rows(), U.cols()),
            MatXX::Ones(U.rows(), U.cols()) + Q * U);
      check("I + Vᵀ Q, where Vᵀ Q must be zero: Q ends in the gauge", MatXX::Ones(U.cols(), U.rows()),
            MatXX::Ones(U.cols(), U.rows()) + V.transpose() * Q);
      check("Q Q, which must be Q: who is in the gauge stays", Q, Q * Q);
      if (HasFatalFailure()) return;
      CheckProjection(U, V, RowNames(scene.vertices), " of " + NameOf(group) + ", " + gauge);
      if (HasFatalFailure()) return;
    }
  }
}

// ---- 4d, the Jacobian of the motion ---------------------------------------------------------------------------------

/// Of a vertex with n rows, or of several vertices with n rows in all.
std::vector<Mistake> MotionMistakes(const MatXX& R_z, int n, bool single) {
  const MatXX I = MatXX::Identity(3, 3), O = MatXX::Zero(3, 3);
  // Of one vertex alone.
  const auto blocks = [n](const MatXX& first, const MatXX& second, const MatXX& third = MatXX::Identity(3, 3)) {
    MatXX J = MatXX::Identity(n, n);
    J.topLeftCorner(3, 3) = first;
    if (n >= 6) J.block(3, 3, 3, 3) = second;
    if (n >= 9) J.block(6, 6, 3, 3) = third;
    return Is(J);
  };
  std::vector<Mistake> mistakes = {{"4d", "the motion is still the identity", Is(MatXX::Identity(n, n))}};
  if (single) {
    mistakes.push_back({"4d", "the motion's block is zero", blocks(O, I)});
    mistakes.push_back({"4d", "R_zᵀ stands where R_z is meant: this turns back", blocks(R_z.transpose(), I)});
    const bool is_pose = n == 6;
    const std::string second = is_pose ? "R_z acts on δθ too; but R_z R Exp(δθ) has the δθ of R Exp(δθ), "
                                         "the paper's δφ stands on the other side"
                                       : "R_z acts on a bias too, which is expressed in the body";
    mistakes.push_back({"4d", second, blocks(R_z, R_z)});
    if (!is_pose) mistakes.push_back({"4d", second, blocks(R_z, R_z, R_z)});
    mistakes.push_back({"4d", second + "; and δp is left out", blocks(I, R_z)});
    mistakes.push_back({"4d", "R_z acts from both sides", blocks(R_z * R_z, I)});
    mistakes.push_back({"4d", "the sign: it is R_z itself", blocks(-R_z, I)});
    mistakes.push_back(
        {"4d", "R_z stands in the second three rows; it is the first three that belong to W", blocks(I, R_z)});
  } else {
    mistakes.push_back({"4d", "only the first vertex turns: the block starts at `row`, which moves on with each vertex",
                        blocks(R_z, I)});
    mistakes.push_back({"4d", "only the first vertex turns: the block starts at `row`, which moves on with each vertex",
                        blocks(R_z, R_z)});
  }
  return mistakes;
}

void CheckMotion(const Vertices& vertices, double yaw, const std::string& scene) {
  const Motion g{1.0, ExpSO3(Vec3(0, 0, yaw)), Vec3(1, -2, 3)};  // t must not matter
  ASSERT_NO_STORY({"4",
                   "∂θ_C/∂θ of " + scene + ", yaw " + Number(yaw),
                   NumericMotionJacobian(vertices, g),
                   Chosen().gauge_freedom.motion_jacobian(vertices, yaw),
                   RowNames(vertices),
                   MotionMistakes(g.R.toRotationMatrix(), TotalLocalDimension(vertices), vertices.size() == 1),
                   kTolerance,
                   {},
                   "4d"});
}

TEST(Stage4, TheMotionTurnsWhatIsExpressedInTheWorld) {
  Random random(Seed(107));
  const double yaw = random.Uniform(0.5, 2.0);
  CheckMotion({RandomPose(&random)}, yaw, "a pose");
  if (HasFatalFailure()) return;
  CheckMotion({RandomSpeedBias(&random)}, yaw, "a velocity and biases");
  if (HasFatalFailure()) return;
  CheckMotion({RandomPoint(&random)}, yaw, "a point");
  for (const int count : {4, 7, 15}) {
    if (HasFatalFailure()) return;
    CheckMotion(RandomVertices(count, &random), -random.Uniform(0.0, 3.0), std::to_string(count) + " vertices");
  }
}

}  // namespace
}  // namespace ch5::homework
