/// Stage 4e: the covariance of another gauge, first on matrices without structure, then on whole problems, where it must
/// be the one that is computed directly in the other gauge. stage_4.cc runs first.

#include <gtest/gtest.h>

#include "ch5_homework/judge/stage_4_scene.h"
#include "ch5_homework/judge/submission.h"

namespace ch5::homework {
namespace {

constexpr double kSmallestEigenvalue = 5e-9;  // of the largest one

// ---- 4e, the product ------------------------------------------------------------------------------------------------

TEST(Stage4, TheCovarianceIsMultipliedFromBothSides) {
  for (const int n : {3, 6, 10}) {
    Random random(Seed(109 + static_cast<uint64_t>(n)));
    const MatXX C = RandomPositiveDefinite(n, &random);
    const MatXX M = RandomMatrix(n, n, &random).householderQr().householderQ();  // orthogonal, as every ∂θ_C/∂θ is
    const MatXX U = RandomMatrix(n, n / 3, &random), V = U + RandomMatrix(n, n / 3, &random);
    const MatXX Q = ProjectionByItsEffect(U, V), Q_C = M * Q * M.transpose();  // the same gauge at θ and at θ_C
    const MatXX T = Q_C * M, Tt = T.transpose();
    const auto by = [&](const MatXX& factor) { return MatXX(factor * C * factor.transpose()); };
    const MatXX got = Chosen().gauge_freedom.transform_covariance(C, M, Q, Q_C);
    const bool exploded = !got.allFinite() || (got.size() > 0 && got.norm() > 1e8);  // all that is given is near 1
    Require("4", {"4.covariance_of_random", {{"size", Word(std::to_string(n) + "×" + std::to_string(n))}}}, T * C * Tt,
            got, {},
            {{"4e", "4.T_has_no_inverse", exploded ? got : MatXX()},
             {"4e", "4.covariance_not_changed", C},
             {"4e", "4.result_still_zero", MatXX::Zero(n, n)},
             {"4e", "4.Q_motion_exchanged_places", by(M * Q_C)},
             {"4e", "4.Q_of_other_place", by(Q * M)},
             {"4e", "4.one_side_only", T * C},
             {"4e", "4.one_side_only", C * Tt},
             {"4e", "4.transpose_missing", T * C * T},
             {"4e", "4.transpose_wrong_side", Tt * C * T},
             {"4e", "4.Q_missing_right", T * C * M.transpose()},
             {"4e", "4.Q_missing_left", M * C * Tt},
             {"4e", "4.motion_missing_right", T * C * Q_C.transpose()},
             {"4e", "4.motion_missing", by(Q_C)},
             {"4e", "4.motion_missing", by(Q)},
             {"4e", "4.motion_missing", by(Q_C * Q)},
             {"4e", "4.Q_missing", by(M)},
             {"4e", "4.Q_transposed", by(Q_C.transpose() * M)},
             {"4e", "4.motion_transposed", by(Q_C * M.transpose())},
             {"4e", "4.motion_transposed", by(M.transpose() * Q)}},
            1e-10, "4e", "transformed");
  }
}

// The handout's example: one measurement of x2 − x1 with σ = 2.
TEST(Stage4, TheExampleOfTheHandout) {
  const GaugeFreedom& functions = Chosen().gauge_freedom;
  const Vec2 U(1, 1), V(1, 0);
  const MatXX free = (MatXX(2, 2) << 1, -1, -1, 1).finished(), fixed = (MatXX(2, 2) << 0, 0, 0, 4).finished();
  const MatXX I = MatXX::Identity(2, 2), H = 0.25 * free;
  ASSERT_TRUE(FreeCovariance(H, 1).isApprox(free) && FixedCovariance(H, V).isApprox(fixed)) << "the handout is wrong";
  Require("4", "4.handout_held", fixed,
          functions.transform_covariance(free, I, functions.projection(U, V), functions.projection(U, V)),
          Words({"x1", "x2"}));
  Require("4", "4.handout_set_free", free,
          functions.transform_covariance(fixed, I, functions.projection(U, U), functions.projection(U, U)),
          Words({"x1", "x2"}));
}

// ---- all together ---------------------------------------------------------------------------------------------------

// A scene whose covariances can be compared to 1e-7: none of its directions is nearly as free as the gauge.
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
  const GaugeFreedom& functions = Chosen().gauge_freedom;
  const Names names = RowNames(scene.vertices);
  const auto of = [&](const Text& what) {
    return Text("4.frames", {{"what", what}, {"system", NameOf(group)}, {"n", Word(frames)}});
  };
  const MatXX H = scene.Hessian(), U = functions.null_space(scene.vertices, group);
  Require("4", of("4.I_H_U"), MatXX::Ones(U.rows(), U.cols()),
          MatXX::Ones(U.rows(), U.cols()) + H * U / H.cwiseAbs().maxCoeff(), names, {}, 1e-9, {}, {},
          DirectionNames(group));
  const MatXX free = FreeCovariance(H, static_cast<int>(U.cols()));
  const MatXX Q = functions.projection(U, scene.FirstFrame(group)), Q_free = functions.projection(U, U);

  const double yaw = 0.4 + 0.1 * static_cast<double>(frames);
  MoveAll({1.0, ExpSO3(Vec3(0, 0, yaw)), Vec3(3, -2, 1)}, scene.vertices);
  const MatXX V = scene.FirstFrame(group), fixed = FixedCovariance(scene.Hessian(), V);
  const MatXX U_C = functions.null_space(scene.vertices, group);
  const MatXX Q_C = functions.projection(U_C, V), Q_C_free = functions.projection(U_C, U_C);
  const MatXX motion = functions.motion_jacobian(scene.vertices, yaw);
  ASSERT_GT((free - fixed).norm(), 0.1 * fixed.norm()) << "the scene is too easy: both gauges have one covariance";
  Require("4", of("4.covariance_held"), fixed, functions.transform_covariance(free, motion, Q, Q_C), names, {}, 1e-7);

  const MatXX back = functions.motion_jacobian(scene.vertices, -yaw);
  Require("4", of("4.covariance_set_free"), free, functions.transform_covariance(fixed, back, Q_C_free, Q_free), names,
          {}, 1e-7);
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
