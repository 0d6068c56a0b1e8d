/// Stage 8, the open tasks, one after the other: the damping (8a), a camera (8b), an IMU (8c), a beacon (8d).

#include <gtest/gtest.h>

#include <limits>

#include "ch5_backend/math/psd.h"
#include "ch5_homework/judge/ask.h"
#include "ch5_homework/judge/diagnosis.h"
#include "ch5_homework/judge/right/open_tasks.h"

namespace ch5::homework {
namespace {

using formula::Formula;
using right::ImuStep;
using right::Trial;

// Of derivatives, which may be differences: less than a float's, but where what is subtracted is very large, or changes fast.
double Tolerance(double far) { return far > 100.0 || far < 0.01 ? 1e-5 : 1e-8; }

Names Axes(const std::string& of) { return Words({of + ".x", of + ".y", of + ".z"}); }
Text PartOf(const Text& part, const Text& scene) { return {"8.part_of", {{"part", part}, {"scene", scene}}}; }

Transform RandomPose(Random* random) { return {ExpSO3(RandomMatrix(3, 1, random)), Vec3(RandomMatrix(3, 1, random))}; }

// ---- 8a, the damping ------------------------------------------------------------------------------------------------

DampingUpdate Update(const Trial& t) {
  const Answer next = Ask(
      "UpdateDamping",
      {{"cost", t.cost}, {"trial_cost", t.trial_cost}, {"predicted", t.predicted}, {"lambda", t.lambda}, {"nu", t.nu}});
  return {next.Number("accepted") != 0.0, next.Number("lambda"), next.Number("nu")};
}

void CheckDecision(const Trial& t, bool accepted, const Text& what) {
  const bool got = Update(t).accepted;
  const Mistakes other{{"8a", accepted ? "8.lower_rejected" : "8.higher_accepted", MatXX::Constant(1, 1, !accepted)}};
  Require({what, "8a", "next.accepted", Words({"accepted"}), 1e-10, other}, MatXX::Constant(1, 1, accepted),
          MatXX::Constant(1, 1, got));
}

// λ and ν for the next trial.
void CheckDamping(const std::vector<Trial>& trials, bool accepted, const Names& names, const Text& what) {
  const auto n = static_cast<Eigen::Index>(trials.size());
  VecX before(n), lambda(n), nu(n);
  for (Eigen::Index k = 0; k < n; ++k) {
    const Trial& t = trials[static_cast<size_t>(k)];
    const DampingUpdate next = Update(t);
    before[k] = t.lambda, lambda[k] = next.lambda, nu[k] = next.nu;
  }
  const double factor = lambda[0] / before[0];
  Mistakes vaguer{{"8a", {"8.factor_always", {{"k", Word(factor)}}}, n > 1 ? MatXX(factor * before) : MatXX()}};
  const VecX factors = lambda.cwiseQuotient(before);
  const right::NextDamping right(trials, accepted, factors);
  vaguer.push_back({"8a",
                    {"8.other_limits", {{"low", Word(factors.minCoeff())}, {"high", Word(factors.maxCoeff())}}},
                    right.between_other_limits});
  Require({PartOf(Word("λ"), what), "8a", "next.lambda", names, 1e-10, {}, vaguer}, right.lambda, lambda);
  Require({PartOf(Word("ν"), what), "8a", "next.nu", names}, right.nu, nu);
}

// A λ that is tiny or huge is no other, nor are costs; all else about them has been right.
void CheckTinyAndHuge(bool accepted) {
  for (const double lambda : {1e-12, 1e12}) {
    const std::vector<Trial> one{{5.0 * lambda, (accepted ? 3.0 : 6.0) * lambda, 4.0 * lambda, lambda, 2.0}};
    CheckDecision(one[0], accepted, {"8.with_lambda", {{"lambda", Word(lambda)}}});
    const MatXX got = MatXX::Constant(1, 1, Update(one[0]).lambda);
    const Mistakes limited{{"8a", "8.lambda_limited", got}};
    const right::NextDamping right(one, accepted, VecX::Ones(1));
    Require({PartOf(Word("λ"), {"8.with_lambda", {{"lambda", Word(lambda)}}}), "8a", "next.lambda", {}, 1e-10, limited},
            Value(right.lambda.right), got);
  }
}

TEST(Stage8, AnAcceptedStepFollowsTheGainRatio) {
  std::vector<Trial> trials;
  Names names;
  for (const double gain :
       {1.1, 0.1, 1e-4, 0.5, 0.8, 0.9, 0.97, 3.0, 0.45, 1.85}) {  // the last ones as if twice or half
    const double promise = gain > 1.2 ? 1.0 : 4.0;
    trials.push_back({5.0, 5.0 - promise * gain, promise, 0.3, 8.0});
    names.push_back({"8.accepted_with_gain", {{"gain", Word(gain)}}});
    CheckDecision(trials.back(), true, names.back());
  }
  CheckDamping(trials, true, names, "8.accepted_steps");
  CheckTinyAndHuge(true);
}

TEST(Stage8, ARejectedStepRaisesTheDamping) {
  std::vector<Trial> trials;
  Names names;
  for (const double nu : {2.0, 4.0, 64.0}) {
    trials.push_back({10.0, 10.5, 4.0, 0.3, nu});
    names.push_back({"8.rejected_with_nu", {{"nu", Word(nu)}}});
    CheckDecision(trials.back(), false, names.back());
  }
  CheckDamping(trials, false, names, "8.rejected_steps");
  CheckTinyAndHuge(false);
}

TEST(Stage8, ATrialWithoutSenseIsRejected) {
  const double infinity = std::numeric_limits<double>::infinity(), nan = std::numeric_limits<double>::quiet_NaN();
  const std::vector<std::pair<Trial, Text>> trials{{{10.0, infinity, 4.0, 0.3, 2.0}, "8.cost_infinite"},
                                                   {{10.0, nan, 4.0, 0.3, 2.0}, "8.cost_nan"},
                                                   {{10.0, 10.0, 4.0, 0.3, 2.0}, "8.cost_as_before"},
                                                   {{10.0, 12.0, -4.0, 0.3, 2.0}, "8.model_uphill"}};
  for (const auto& [t, what] : trials) {
    CheckDecision(t, false, what);
    CheckDamping({t}, false, {}, what);
  }
}

// What is wrong nearer or farther away, and was right twice before.
Mistakes ByDistance(double far, const std::string& todo, const MatXX& got) {
  return {{todo, "8.distance_limited", far != 1.0 ? got : MatXX()}};
}

// ---- 8b, a camera ---------------------------------------------------------------------------------------------------

/// @param far  how many times as far away as what has been right before
void CheckView(const Transform& T_W_B, const Transform& T_B_C, const Vec3& p_W, const Text& what, double far = 1.0) {
  const Answer J = Ask("LinearizeProjection", {{"T_W_B", T_W_B}, {"T_B_C", T_B_C}, {"p_W", p_W}});
  const MatXX point = J.Sized("point", 2, 3), pose = J.Sized("pose", 2, 6);
  const right::Projection right(T_W_B, T_B_C, p_W);
  const auto check = [&](const char* part, const Formula& formula, const MatXX& got, const char* step,
                         const char* variable) {
    const Sides names{Words({"r.x", "r.y"}), Axes(step)};
    Require({PartOf(part, what), "8b", variable, names, Tolerance(far), ByDistance(far, "8b", got)}, formula, got);
  };
  check("8.over_point", right.over_point, point, "δp_W", "J.point");
  check("8.over_position", right.over_position, pose.leftCols(3), "δp", "J.pose");
  check("8.over_rotation", right.over_rotation, pose.rightCols(3), "δθ", "J.pose");
}

TEST(Stage8, TheProjectionIsDifferentiated) {
  Random random(Seed(211));
  int n = 0;
  for (const double far : {1.0, 1.0, 0.15, 10.0, 1e3, 1e-3}) {
    const Transform T_W_B = RandomPose(&random), T_B_C = RandomPose(&random);
    const Vec3 p_C = far * Vec3(random.Uniform(-1, 1), random.Uniform(-1, 1), random.Uniform(2, 4));
    CheckView(T_W_B, T_B_C, T_W_B.q * (T_B_C.q * p_C + T_B_C.p) + T_W_B.p, {"8.random_view", {{"n", Word(++n)}}}, far);
  }
}

// At the origin, looking along z: ∂r/∂p = [¼ 0 −1/16; 0 ¼ −⅛] at (1, 2, 4).
TEST(Stage8, TheProjectionOnPaper) { CheckView({}, {}, Vec3(1, 2, 4), "8.projection_on_paper"); }

// ---- 8c, an IMU -----------------------------------------------------------------------------------------------------

ImuIncrement After(const ImuStep& step) {
  const Answer after = Ask("IntegrateImu", {{"pose", Transform{step.before.q, step.before.p}},
                                            {"v", step.before.v},
                                            {"covariance", step.before.covariance},
                                            {"a", step.a},
                                            {"w", step.w},
                                            {"dt", step.dt},
                                            {"sigma_a", step.sigma_a},
                                            {"sigma_g", step.sigma_g}});
  const Transform pose = after.Pose("pose");
  return {pose.p, pose.q, after.Sized("v", 3, 1), after.Sized("covariance", 9, 9)};
}

ImuStep RandomStep(bool uncertain, Random* random) {
  ImuStep step;
  step.before.p = RandomMatrix(3, 1, random);
  step.before.q = ExpSO3(RandomMatrix(3, 1, random));
  step.before.v = RandomMatrix(3, 1, random);
  if (uncertain) step.before.covariance = 0.01 * RandomPositiveDefinite(9, random);
  step.a = 3.0 * RandomMatrix(3, 1, random);
  step.w = 2.0 * RandomMatrix(3, 1, random);
  step.dt = random->Uniform(0.2, 0.3);  // long, so that its second order shows
  step.sigma_a = random->Uniform(0.1, 0.2);
  step.sigma_g = random->Uniform(0.05, 0.1);
  return step;
}

TEST(Stage8, AnImuStepMovesTheState) {
  Random random(Seed(223));
  const ImuStep step = RandomStep(/*uncertain=*/false, &random);
  const right::Integrated right(step);
  const ImuIncrement got = After(step);
  Require({"8.imu_position", "8c", "after.p", Axes("p")}, right.p, got.p);
  Require({"8.imu_velocity", "8c", "after.v", Axes("v")}, right.v, got.v);
  Require({"8.imu_rotation", "8c", "after.q"}, right.R, got.q.toRotationMatrix());
}

// J X Jᵀ is wrong by `wrong`, and one block of J, at (row, column), explains it: then the blocks of its row are, beside the
// diagonal, by δJ X Jᵀ. @return what else is added where that is so
MatXX ByOneBlock(MatXX J, const MatXX& X, const MatXX& wrong, int row, int column) {
  const MatXX right = J * X * J.transpose();
  MatXX XJt = X.middleRows(column, 3) * J.transpose();
  XJt.middleCols(row, 3).setZero();
  J.block(row, column, 3, 3) += wrong.middleRows(row, 3) * XJt.transpose() * PseudoInversePsd(XJt * XJt.transpose());
  return J * X * J.transpose() - right;
}

// What no slip explains may still be one block's fault.
Mistakes WrongBlocks(const right::Integrated& right, const MatXX& expected, const MatXX& got) {
  const char* const parts[] = {"δp", "δθ", "δv", "n_a", "n_g"};
  Mistakes mistakes;
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 5; ++j) {
      const bool of_A = j < 3;
      const MatXX more = of_A ? ByOneBlock(right.A, right.P, got - expected, 3 * i, 3 * j)
                              : ByOneBlock(right.B, right.Q, got - expected, 3 * i, 3 * (j - 3));
      mistakes.push_back({"8c",
                          {of_A ? "8.one_block_of_A" : "8.one_block_of_B",
                           {{"row", Word(std::string(parts[i]))}, {"column", Word(std::string(parts[j]))}}},
                          expected + more});
    }
  }
  return mistakes;
}

void CheckCovariance(const ImuStep& step, const Text& what) {
  const right::Integrated right(step);
  const MatXX got = After(step).covariance;
  const Names names = Words({"δp.x", "δp.y", "δp.z", "δθ.x", "δθ.y", "δθ.z", "δv.x", "δv.y", "δv.z"});
  const Mistakes blocks = WrongBlocks(right, Value(right.covariance.right), got);
  Require({what, "8c", "after.covariance", names, Tolerance(1.0), {}, blocks}, right.covariance, got);
}

TEST(Stage8, AnImuStepAddsItsNoise) {
  Random random(Seed(227));
  CheckCovariance(RandomStep(/*uncertain=*/false, &random), "8.covariance_of_one_step");
}

TEST(Stage8, AnImuStepMovesTheCovariance) {
  Random random(Seed(229));
  for (const double slow : {1.0, 0.02, 0.0}) {  // how fast it turns, and how long
    ImuStep step = RandomStep(/*uncertain=*/true, &random);
    step.w *= slow;
    if (slow < 1.0) step.dt *= 0.02;
    CheckCovariance(step, "8.covariance_carried_on");
  }
}

// ---- 8d, a beacon ---------------------------------------------------------------------------------------------------

void CheckRange(const Transform& T, const Vec3& antenna, const Vec3& beacon, double range, const Text& what,
                double far = 1.0) {
  const Answer term = Ask("LinearizeRange", {{"T_W_B", T}, {"antenna", antenna}, {"beacon", beacon}, {"range", range}});
  const MatXX J = term.Sized("J", 1, 6);
  const right::Range right(T, antenna, beacon, range);
  const auto check = [&](const char* part, const Formula& formula, const MatXX& got, const char* variable,
                         const Names& columns) {
    const Sides names{Words({"r"}), columns};
    Require({PartOf(part, what), "8d", variable, names, Tolerance(far), ByDistance(far, "8d", got)}, formula, got);
  };
  check("8.range_residual", right.residual, MatXX::Constant(1, 1, term.Number("residual")), "term.residual", {});
  check("8.over_position", right.over_position, J.leftCols(3), "term.J", Axes("δp"));
  check("8.over_rotation", right.over_rotation, J.rightCols(3), "term.J", Axes("δθ"));
}

TEST(Stage8, TheRangeIsDifferentiated) {
  Random random(Seed(233));
  int n = 0;
  for (const double far : {1.0, 1.0, 0.1, 8.0, 1e3}) {
    const Transform T = RandomPose(&random);
    const Vec3 antenna = RandomMatrix(3, 1, &random), from = T.p + T.q * antenna;
    const Vec3 beacon = from + far * (Vec3(4, 0, 0) + Vec3(RandomMatrix(3, 1, &random)) - from);
    const double distance = (from - beacon).norm();
    CheckRange(T, antenna, beacon, distance * (n % 2 == 0 ? 0.7 : 1.3), {"8.random_beacon", {{"n", Word(n + 1)}}}, far);
    ++n;
  }
}

// The antenna at (3, 4, 0), the beacon at the origin: the distance is 5, measured as 4.5.
TEST(Stage8, TheRangeOnPaper) {
  CheckRange({Qd::Identity(), Vec3(2, 4, -2)}, Vec3(1, 0, 2), Vec3::Zero(), 4.5, "8.range_on_paper");
}

}  // namespace
}  // namespace ch5::homework
