/// Stage 8, the open tasks, one after the other: the damping (8a), a camera (8b), an IMU (8c), a beacon (8d). Derivatives
/// are compared with central differences.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <utility>
#include <vector>

#include "ch5_backend/math/psd.h"
#include "ch5_backend/open_tasks/open_tasks.h"
#include "ch5_homework/judge/ask.h"
#include "ch5_homework/judge/diagnosis.h"
#include "ch5_homework/judge/mistakes/formula.h"
#include "ch5_homework/judge/oracle.h"
#include "ch5_homework/judge/scenes/scene.h"

namespace ch5::homework {
namespace {

constexpr double kTolerance = 1e-7;  // of central differences

Names Axes(const std::string& of) { return Words({of + ".x", of + ".y", of + ".z"}); }

Transform RandomPose(Random* random) { return {ExpSO3(RandomMatrix(3, 1, random)), Vec3(RandomMatrix(3, 1, random))}; }

// x, y, z, w read as w, x, y, z.
Qd Reordered(const Qd& q) { return Qd(q.x(), q.y(), q.z(), q.w()); }

// x ⊞ δ, the pose's increment [δp, δθ].
Transform Moved(const Transform& T, const Vec6& delta) {
  return {T.q * ExpSO3(delta.tail<3>()), T.p + delta.head<3>()};
}

// ---- 8a, the damping ------------------------------------------------------------------------------------------------

struct Trial {
  double cost, trial_cost, predicted, lambda, nu;
};

DampingUpdate Update(const Trial& t) {
  const Answer next = Ask(
      "UpdateDamping",
      {{"cost", t.cost}, {"trial_cost", t.trial_cost}, {"predicted", t.predicted}, {"lambda", t.lambda}, {"nu", t.nu}});
  return {next.Number("accepted") != 0.0, next.Number("lambda"), next.Number("nu")};
}

void CheckDecision(const Trial& t, bool accepted, const Text& what) {
  Require("8", what, MatXX::Constant(1, 1, accepted), MatXX::Constant(1, 1, Update(t).accepted), Words({"accepted"}),
          {{"8a", accepted ? "8.lower_rejected" : "8.higher_accepted", MatXX::Constant(1, 1, !accepted)}}, 1e-10, "8a",
          "next.accepted");
}

// λ and ν for the next trial: a row for each trial.
using Updates = Eigen::Matrix<double, Eigen::Dynamic, 2>;
Updates AfterEach(const std::vector<Trial>& trials, const std::function<Vec2(const Trial& t)>& update) {
  Updates updates(trials.size(), 2);
  for (size_t k = 0; k < trials.size(); ++k) updates.row(k) = update(trials[k]).transpose();
  return updates;
}

/// @param right  the new λ and ν;  @param wrong  likewise
void CheckDamping(const std::vector<Trial>& trials, const Names& names,
                  const std::function<Vec2(const Trial& t)>& right,
                  const std::vector<std::pair<Text, std::function<Vec2(const Trial& t)>>>& wrong, const Text& what) {
  const auto got = [](const Trial& t) {
    const DampingUpdate next = Update(t);
    return Vec2(next.lambda, next.nu);
  };
  const Updates is = AfterEach(trials, got), meant = AfterEach(trials, right);
  std::vector<std::pair<Text, Updates>> updates;
  for (const auto& [cause, update] : wrong) updates.push_back({cause, AfterEach(trials, update)});
  const double factor = is(0, 0) / trials[0].lambda;
  const auto always = [&](const Trial& t) { return Vec2(factor * t.lambda, right(t)[1]); };
  if (trials.size() > 1) updates.push_back({{"8.factor_always", {{"k", Word(factor)}}}, AfterEach(trials, always)});
  for (const int k : {0, 1}) {  // each may be wrong in a way of its own
    std::vector<Mistake> mistakes;
    for (const auto& [cause, wrong_update] : updates) mistakes.push_back({"8a", cause, wrong_update.col(k)});
    const Text of("8.part_of", {{"part", Word(std::string(k == 0 ? "λ" : "ν"))}, {"scene", what}});
    Require("8", of, meant.col(k), is.col(k), names, mistakes, 1e-10, "8a", k == 0 ? "next.lambda" : "next.nu");
  }
}

TEST(Stage8, AnAcceptedStepFollowsTheGainRatio) {
  std::vector<Trial> trials;
  Names names;
  for (const double gain : {1.1, 0.1, 1e-4, 0.5, 0.8, 0.9, 0.97}) {
    trials.push_back({5.0, 5.0 - 4.0 * gain, 4.0, 0.3, 8.0});
    names.push_back({"8.accepted_with_gain", {{"gain", Word(gain)}}});
    CheckDecision(trials.back(), true, names.back());
  }
  const auto gain_of = [](const Trial& t) { return (t.cost - t.trial_cost) / t.predicted; };
  const auto cube = [](double gain) { return std::pow(2.0 * gain - 1.0, 3); };
  const auto limited = [](double factor) { return std::clamp(factor, 1.0 / 3.0, 2.0 / 3.0); };
  const auto by = [gain_of](auto factor, double nu = 2.0) {
    return [=](const Trial& t) { return Vec2(t.lambda * factor(gain_of(t)), nu); };
  };
  const auto right = [=](double gain) { return limited(1.0 - cube(gain)); };
  CheckDamping(trials, names, by(right),
               {{"8.nu_not_reset", by(right, 8.0)},
                {"8.nu_not_reset", by(right, 16.0)},
                {"8.nu_not_assigned", by(right, 0.0)},
                {"8.nu_not_reset", by(right, 1.0)},
                {"8.cap_missing", by([=](double gain) { return std::max(1.0 / 3.0, 1.0 - cube(gain)); })},
                {"8.floor_missing", by([=](double gain) { return std::min(2.0 / 3.0, 1.0 - cube(gain)); })},
                {"8.cap_missing", by([=](double gain) { return std::clamp(1.0 - cube(gain), 1.0 / 3.0, 1.0); })},
                {"8.limits_missing", by([=](double gain) { return 1.0 - cube(gain); })},
                {"8.half_the_promise", by([=](double gain) { return right(2.0 * gain); })},
                {"8.half_the_promise", by([=](double gain) { return right(0.5 * gain); })},
                {"8.one_missing", by([=](double gain) { return limited(cube(gain)); })},
                {"8.divided_by_factor", by([=](double gain) { return 1.0 / right(gain); })},
                {"8.integers_divided", by([](double) { return 0.0; })},
                {"8.lambda_kept", by([](double) { return 1.0; })},
                {"8.lambda_raised", by([](double) { return 8.0; }, 16.0)},
                {"8.integers_divided", by([=](double gain) { return std::clamp(1.0 - cube(gain), 0.0, 2.0 / 3.0); })},
                {"8.nu_for_lambda", [=](const Trial& t) { return Vec2(t.nu * right(gain_of(t)), 2.0); }},
                {"8.lambda_nu_exchanged", [=](const Trial& t) { return Vec2(2.0, t.lambda * right(gain_of(t))); }},
                {"8.square_for_cube", by([=](double gain) { return limited(1.0 - std::pow(2.0 * gain - 1.0, 2)); })},
                {"8.gain_by_the_cost", by([=](double gain) { return right(gain * 4.0 / 5.0); })},
                {"8.gain_inverted", by([=](double gain) { return right(1.0 / gain); })}},
               "8.accepted_steps");
}

TEST(Stage8, ARejectedStepRaisesTheDamping) {
  std::vector<Trial> trials;
  Names names;
  for (const double nu : {2.0, 4.0, 64.0}) {
    trials.push_back({10.0, 10.5, 4.0, 0.3, nu});
    names.push_back({"8.rejected_with_nu", {{"nu", Word(nu)}}});
    CheckDecision(trials.back(), false, names.back());
  }
  CheckDamping(
      trials, names, [](const Trial& t) { return Vec2(t.lambda * t.nu, 2.0 * t.nu); },
      {{"8.nu_not_doubled", [](const Trial& t) { return Vec2(t.lambda * t.nu, t.nu); }},
       {"8.nu_not_doubled", [](const Trial& t) { return Vec2(t.lambda * t.nu, t.nu * t.nu); }},
       {"8.nu_not_doubled", [](const Trial& t) { return Vec2(t.lambda * t.nu, t.nu + 2.0); }},
       {"8.nu_not_assigned", [](const Trial& t) { return Vec2(t.lambda * t.nu, 0.0); }},
       {"8.nu_doubled_first", [](const Trial& t) { return Vec2(t.lambda * 2.0 * t.nu, 2.0 * t.nu); }},
       {"8.lambda_not_raised", [](const Trial& t) { return Vec2(t.lambda, 2.0 * t.nu); }},
       {"8.lambda_not_raised", [](const Trial& t) { return Vec2(t.lambda, t.nu); }},
       {"8.lambda_divided", [](const Trial& t) { return Vec2(t.lambda / t.nu, 2.0 * t.nu); }},
       {"8.nu_for_lambda", [](const Trial& t) { return Vec2(t.nu, 2.0 * t.nu); }},
       {"8.lambda_for_nu", [](const Trial& t) { return Vec2(t.lambda * t.nu, 2.0 * t.lambda); }},
       {"8.lambda_for_nu", [](const Trial& t) { return Vec2(t.lambda * t.nu, 2.0 * t.lambda * t.nu); }},
       {"8.lambda_for_nu", [](const Trial& t) { return Vec2(t.lambda * t.nu, t.lambda * t.nu); }},
       {"8.lambda_nu_exchanged", [](const Trial& t) { return Vec2(2.0 * t.nu, t.lambda * t.nu); }},
       {"8.nu_for_lambda", [](const Trial& t) { return Vec2(t.lambda + t.nu, 2.0 * t.nu); }},
       {"8.nu_reset_too_soon", [](const Trial& t) { return Vec2(t.lambda * t.nu, 2.0); }}},
      "8.rejected_steps");
}

TEST(Stage8, ATrialWithoutSenseIsRejected) {
  const double infinity = std::numeric_limits<double>::infinity(), nan = std::numeric_limits<double>::quiet_NaN();
  const std::vector<std::pair<Trial, Text>> trials{{{10.0, infinity, 4.0, 0.3, 2.0}, "8.cost_infinite"},
                                                   {{10.0, nan, 4.0, 0.3, 2.0}, "8.cost_nan"},
                                                   {{10.0, 10.0, 4.0, 0.3, 2.0}, "8.cost_as_before"},
                                                   {{10.0, 12.0, -4.0, 0.3, 2.0}, "8.model_uphill"}};
  for (const auto& [t, what] : trials) {
    CheckDecision(t, false, what);
    CheckDamping(
        {t}, {}, [](const Trial&) { return Vec2(0.6, 4.0); }, {}, what);
  }
}

// ---- 8b, a camera ---------------------------------------------------------------------------------------------------

struct View {
  Transform T_W_B, T_B_C;
  Vec3 p_W;

  Vec3 InBody() const { return T_W_B.q.conjugate() * (p_W - T_W_B.p); }
  Vec3 InCamera() const { return T_B_C.q.conjugate() * (InBody() - T_B_C.p); }
  VecX Pixel() const { return InCamera().hnormalized(); }

  MatXX OverPose() const {
    return Differences(6, [&](const VecX& d) { return View{Moved(T_W_B, d), T_B_C, p_W}.Pixel(); });
  }
  MatXX OverPoint() const {
    return Differences(3, [&](const VecX& d) { return View{T_W_B, T_B_C, p_W + d}.Pixel(); });
  }
};

// In ∂r/∂p_W.
std::vector<Mistake> MistakesOverPoint(const View& view) {
  const Mat33 R = view.T_W_B.q.toRotationMatrix(), C = view.T_B_C.q.toRotationMatrix();
  const Vec3 p_C = view.InCamera();
  const double z = p_C.z();
  const auto of_camera = [&](double x, double y) { return (Mat23() << 1 / z, 0, x, 0, 1 / z, y).finished(); };
  const Mat23 E = of_camera(-p_C.x() / z / z, -p_C.y() / z / z);
  const double x = p_C.x() / z, y = p_C.y() / z;
  const std::vector<std::pair<Text, Mat23>> of_p_C{
      {{}, E},
      {"8.depth_column_missing", of_camera(0, 0)},
      {"8.depth_column_sign", of_camera(x / z, y / z)},
      {"8.depth_column_not_squared", of_camera(-x, -y)},
      {"8.x_in_both_rows", of_camera(-x / z, -x / z)},
      {"8.depth_column_not_squared", of_camera(-x / z / z, -y / z / z)},
      {"8.depth_column_not_squared", of_camera(-x / z, -y / z / z)},
      {"8.depth_column_not_squared", of_camera(-x, -y / z)},
      {"8.depth_column_not_squared", of_camera(-x / z, -y)},
      {"8.depth_column_sign", of_camera(x / z, -y / z)},
      {"8.depth_column_sign", of_camera(-x / z, y / z)},
      {"8.not_divided_by_depth", z * E},
      {"8.not_divided_by_depth", (Mat23() << 1, 0, -p_C.x(), 0, 1, -p_C.y()).finished()},
      {"8.x_y_exchanged", E.colwise().reverse()}};
  const std::vector<std::pair<Text, Mat33>> of_p_W{{{}, C.transpose() * R.transpose()},
                                                   {"8.camera_frame_alone", Mat33::Identity()},
                                                   {"8.extrinsic_rotation_missing", R.transpose()},
                                                   {"8.body_rotation_missing", C.transpose()},
                                                   {"8.rotations_not_transposed", C * R},
                                                   {"8.rotations_not_transposed", C.transpose() * R},
                                                   {"8.rotations_not_transposed", C * R.transpose()},
                                                   {"8.rotations_exchanged", R.transpose() * C.transpose()}};
  std::vector<Mistake> mistakes;
  for (const auto& [of_camera_cause, camera] : of_p_C) {
    for (const auto& [cause, chain] : of_p_W) {
      const Text& first = of_camera_cause.empty() ? cause : of_camera_cause;
      if (!first.empty()) mistakes.push_back({"8b", first, camera * chain});
    }
  }
  return mistakes;
}

ProjectionJacobians Linearize(const View& view) {
  const Answer J = Ask("LinearizeProjection", {{"T_W_B", view.T_W_B}, {"T_B_C", view.T_B_C}, {"p_W", view.p_W}});
  return {J.Sized("pose", 2, 6), J.Sized("point", 2, 3)};
}

void CheckView(const View& view, const Text& what) {
  const ProjectionJacobians J = Linearize(view);
  const Mat33 R = view.T_W_B.q.toRotationMatrix(), C = view.T_B_C.q.toRotationMatrix();
  const Vec3 p_C = view.InCamera(), p_B = view.InBody();
  const MatXX pose = view.OverPose(), point = view.OverPoint();
  const Mat23 to_body = point * R, E = to_body * C;
  const auto check = [&](const Text& part, const MatXX& right, const MatXX& got, const Names& columns,
                         const std::vector<Mistake>& mistakes, const std::string& variable) {
    Require("8", {"8.part_of", {{"part", part}, {"scene", what}}}, right, got, Words({"r.x", "r.y"}), mistakes,
            kTolerance, "8b", variable, columns);
  };
  check("8.over_point", point, J.point, Axes("δp_W"), MistakesOverPoint(view), "J.point");
  check("8.over_position", pose.leftCols(3), J.pose.leftCols<3>(), Axes("δp"),
        {{"8b", "8.position_sign", point},
         {"8b", "8.position_in_body", -to_body},
         {"8b", "8.increments_exchanged", pose.rightCols(3)}},
        "J.pose");
  const Vec3 d = view.p_W - view.T_W_B.p;
  check("8.over_rotation", pose.rightCols(3), J.pose.rightCols<3>(), Axes("δθ"),
        {{"8b", "8.rotation_sign", -to_body * Hat(p_B)},
         {"8b", "8.left_perturbation", point * Hat(d)},
         {"8b", "8.left_perturbation", point * Hat(view.p_W)},
         {"8b", "8.point_in_world", to_body * Hat(d)},
         {"8b", "8.point_in_world", to_body * Hat(view.p_W)},
         {"8b", "8.arm_of_camera", E * Hat(p_C) * C.transpose()},
         {"8b", "8.arm_of_camera", to_body * Hat(p_C)},
         {"8b", "8.extrinsic_rotation_missing_in_turn", E * Hat(p_B)}},
        "J.pose");
}

// At the origin, looking along z: ∂r/∂p = [¼ 0 −1/16; 0 ¼ −⅛] at (1, 2, 4).
TEST(Stage8, TheProjectionOnPaper) {
  const Mat23 right = (Mat23() << 0.25, 0, -0.0625, 0, 0.25, -0.125).finished();
  const View view{{}, {}, Vec3(1, 2, 4)};
  Require("8", "8.projection_on_paper", right, Linearize(view).point, Words({"r.x", "r.y"}), MistakesOverPoint(view),
          1e-10, "8b", "J.point", Axes("δp_W"));
}

TEST(Stage8, TheProjectionIsDifferentiated) {
  Random random(Seed(211));
  for (int k = 0; k < 4; ++k) {
    View view{RandomPose(&random), RandomPose(&random), {}};
    const Vec3 p_C(random.Uniform(-1, 1), random.Uniform(-1, 1), random.Uniform(2, 4));
    view.p_W = view.T_W_B.q * (view.T_B_C.q * p_C + view.T_B_C.p) + view.T_W_B.p;
    CheckView(view, {"8.random_view", {{"n", Word(k + 1)}}});
  }
}

// ---- 8c, an IMU -----------------------------------------------------------------------------------------------------

using Mat99 = Eigen::Matrix<double, 9, 9>;

struct Step {
  ImuIncrement before;
  Vec3 a, w;
  double dt, sigma_a, sigma_g;

  ImuIncrement Got() const {
    const Answer after = Ask("IntegrateImu", {{"pose", Transform{before.q, before.p}},
                                              {"v", before.v},
                                              {"covariance", before.covariance},
                                              {"a", a},
                                              {"w", w},
                                              {"dt", dt},
                                              {"sigma_a", sigma_a},
                                              {"sigma_g", sigma_g}});
    const Transform pose = after.Pose("pose");
    return {pose.p, pose.q, after.Sized("v", 3, 1), after.Sized("covariance", 9, 9)};
  }
  ImuIncrement After(const Vec3& da = Vec3::Zero(), const Vec3& dw = Vec3::Zero()) const {
    const Vec3 in_first = before.q * (a + da);
    ImuIncrement after;
    after.p = before.p + dt * before.v + 0.5 * dt * dt * in_first;
    after.q = before.q * ExpSO3(dt * (w + dw));
    after.v = before.v + dt * in_first;
    return after;
  }
  // [δp, δθ, δv] by which another outcome differs from the step's.
  VecX Error(const ImuIncrement& other) const {
    const ImuIncrement after = After();
    return (Vec9() << other.p - after.p, LogSO3(after.q.conjugate() * other.q), other.v - after.v).finished();
  }
  MatXX OverState() const {
    return Differences(9, [&](const VecX& d) {
      Step moved = *this;
      moved.before.p += d.head(3);
      moved.before.q = before.q * ExpSO3(d.segment(3, 3));
      moved.before.v += d.tail(3);
      return Error(moved.After());
    });
  }
  MatXX OverNoise() const {
    return Differences(6, [&](const VecX& d) { return Error(After(d.head(3), d.tail(3))); });
  }
};

Step RandomStep(bool uncertain, Random* random) {
  Step step;
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
  const Step step = RandomStep(/*uncertain=*/false, &random);
  const ImuIncrement right = step.After(), got = step.Got();
  const ImuIncrement& was = step.before;
  const double dt = step.dt;
  struct Part {
    Text cause;  // empty if it is right
    Vec3 x;
  };
  const Text of_middle = "8.imu_turned_by_new", before = "8.imu_before_missing", no_dt = "8.imu_dt_missing";
  const Vec3 a = was.q * step.a, at_end = right.q * step.a, gravity = 9.81 * Vec3::UnitZ();
  std::vector<Mistake> mistakes;
  for (const Part& acceleration : {Part{{}, a},
                                   {"8.imu_not_turned", step.a},
                                   {"8.imu_turned_by_inverse", was.q.conjugate() * step.a},
                                   {"formula.quaternion_order", Reordered(was.q) * step.a},
                                   {of_middle, at_end},
                                   {of_middle, was.q * ExpSO3(0.5 * dt * step.w) * step.a},
                                   {of_middle, 0.5 * (a + at_end)},
                                   {"8.imu_gravity_added", a - gravity},
                                   {"8.imu_gravity_added", a + gravity}}) {
    const Vec3 dv = dt * acceleration.x, moved = was.p + dt * was.v, p = moved + 0.5 * dt * dv, v = was.v + dv;
    for (const Part& of_p : {Part{{}, p},
                             {"8.imu_half_missing", moved},
                             {"8.imu_half_not_halved", moved + dt * dv},
                             {"8.imu_velocity_first", p + dt * dv},
                             {before, p - was.p},
                             {before, p - dt * was.v},
                             {no_dt, p + (1.0 - dt) * was.v},
                             {no_dt, moved + 0.5 * dv},
                             {"8.imu_kept", was.p}}) {
      for (const Part& of_v : {Part{{}, v},
                               {before, dv},
                               {no_dt, was.v + acceleration.x},
                               {"8.imu_not_turned", was.v + dt * step.a},
                               {"8.imu_gravity_added", v - dt * gravity},
                               {"8.imu_gravity_added", v + dt * gravity},
                               {"8.imu_dt_squared", was.v + dt * dv},
                               {"8.imu_kept", was.v}}) {
        const int wrong = !acceleration.cause.empty() + !of_p.cause.empty() + !of_v.cause.empty();
        const Text& cause = !of_p.cause.empty() ? of_p.cause : !of_v.cause.empty() ? of_v.cause : acceleration.cause;
        if (wrong > 0) mistakes.push_back({"8c", cause, (Vec6() << of_p.x, of_v.x).finished()});
      }
    }
  }
  Require("8", "8.imu_position_velocity", (Vec6() << right.p, right.v).finished(), (Vec6() << got.p, got.v).finished(),
          Words({"p.x", "p.y", "p.z", "v.x", "v.y", "v.z"}), mistakes, 1e-10, "8c", "after.p");
  const auto is = [](const Qd& q) { return MatXX(q.toRotationMatrix()); };
  const Vec3 angles = step.dt * step.w;
  const Qd turn = ExpSO3(angles), small(1.0, 0.5 * angles.x(), 0.5 * angles.y(), 0.5 * angles.z());
  Require("8", "8.imu_rotation", right.q.toRotationMatrix(), got.q.toRotationMatrix(), {},
          {{"8c", "8.imu_rotation_kept", is(was.q)},
           {"8c", "8.imu_turned_on_the_left", is(turn * was.q)},
           {"8c", "8.imu_turned_on_the_left", is(turn.conjugate() * was.q)},
           {"8c", "8.imu_before_missing", is(turn)},
           {"8c", "8.imu_turned_back", is(was.q * turn.conjugate())},
           {"8c", "8.imu_rate_without_dt", is(was.q * ExpSO3(step.w))},
           {"8c", "8.imu_half_turn", is(was.q * ExpSO3(0.5 * step.dt * step.w))},
           {"8c", "8.imu_double_turn", is(was.q * turn * turn)},
           {"8c", "8.imu_small_turn", is((was.q * small).normalized())},
           {"8c", "8.imu_small_turn", is(was.q * small)}},
          1e-10, "8c", "after.q");
}

// J with one block replaced so that J X Jᵀ is wrong as `wrong` says, if a single block of J is wrong:
// then the blocks of its row are, beside the diagonal, by δJ X Jᵀ.
MatXX WithOtherBlock(MatXX J, const MatXX& X, const MatXX& wrong, int row, int column) {
  MatXX XJt = X.middleRows(column, 3) * J.transpose();
  XJt.middleCols(row, 3).setZero();
  J.block(row, column, 3, 3) += wrong.middleRows(row, 3) * XJt.transpose() * PseudoInversePsd(XJt * XJt.transpose());
  return J;
}

// Q of the two sensors' variances.
MatXX NoiseOf(double of_a, double of_g) {
  return (Vec6() << Vec3::Constant(of_a), Vec3::Constant(of_g)).finished().asDiagonal();
}

void CheckCovariance(const Step& step, const Text& what) {
  const MatXX A = step.OverState(), B = step.OverNoise(), P = step.before.covariance;
  const double dt = step.dt;
  const double var_a = step.sigma_a * step.sigma_a, var_g = step.sigma_g * step.sigma_g;
  const MatXX Q = NoiseOf(var_a / dt, var_g / dt);
  const auto sum = [&](const MatXX& F, const MatXX& J) { return MatXX(F * P * F.transpose() + J * Q * J.transpose()); };
  // The blocks that are most often wrong.
  const Mat33 R = step.before.q.toRotationMatrix(), of_turn = A.block<3, 3>(3, 3);
  const auto changed = [](MatXX J, const std::vector<std::pair<int, MatXX>>& rows, int column = 3) {
    for (const auto& [row, block] : rows) J.block(row, column, 3, 3) = block;
    return J;
  };
  const MatXX O = MatXX::Zero(3, 3), I = MatXX::Identity(3, 3);
  const MatXX p_arm = A.block(0, 3, 3, 3), v_arm = A.block(6, 3, 3, 3);
  const auto arms = [&](const MatXX& arm) { return changed(A, {{0, 0.5 * dt * dt * arm}, {6, dt * arm}}); };
  const auto mirrored = [](MatXX J, int row, int column) {
    J.block(row, column, 3, 3).swap(J.block(column, row, 3, 3));
    return J;
  };
  MatXX B_exchanged = B;
  B_exchanged.block(3, 0, 3, 3).swap(B_exchanged.block(3, 3, 3, 3));
  struct Part {
    Text cause;  // empty if it is right
    MatXX J;
  };
  const MatXX got = step.Got().covariance, of_noise = B * Q * B.transpose();
  std::vector<Mistake> mistakes{{"8c", "8.noise_missing", A * P * A.transpose()},
                                {"8c", "8.covariance_not_moved", P + of_noise},
                                {"8c", "8.covariance_lost", of_noise},
                                {"8c", "8.A_transposed", sum(A.transpose(), B)},
                                {"8c", "8.A_block_at_mirror_place", sum(mirrored(A, 0, 6), B)},
                                {"8c", "8.A_arm_at_mirror_place", sum(mirrored(A, 6, 3), B)},
                                {"8c", "8.A_arm_at_mirror_place", sum(mirrored(A, 0, 3), B)},
                                {"8c", "8.covariance_counted_twice", P + sum(A, B)},
                                {"8c", "8.A_on_one_side", A * P + of_noise},
                                {"8c", StandsFor("A P A", "A P Aᵀ"), A * P * A + of_noise},
                                {"8c", "8.A_on_one_side", P * A.transpose() + of_noise}};
  // Of two parts that are wrong at once one is named.
  for (const Part& of_arms : {Part{{}, A},
                              {"8.A_sign", changed(A, {{0, -p_arm}, {6, -v_arm}})},
                              {"8.A_without_acceleration", arms(O)},
                              {"8.A_without_acceleration", changed(A, {{6, O}})},
                              {"8.A_without_acceleration_in_p", changed(A, {{0, O}})},
                              {"8.A_not_turned", arms(-Hat(step.a))},
                              {"8.A_left_perturbation", arms(-Hat(R * step.a))},
                              {"8.A_half_missing_in_p", changed(A, {{0, 2.0 * p_arm}})},
                              {"8.A_factors_exchanged", changed(A, {{6, -dt * Hat(step.a) * R}})},
                              {"8.A_factors_exchanged", arms(-Hat(step.a) * R)}}) {
    for (const Part& turn : {Part{{}, of_turn},
                             {"8.A_without_turn", I},
                             {"8.A_turn_not_transposed", of_turn.transpose()},
                             {"8.A_turn_to_first_order", I - dt * Hat(step.w)}}) {
      for (const Part& of_v : {Part{{}, dt * I}, {"8.A_without_velocity", O}}) {
        const Text& cause = !of_arms.cause.empty() ? of_arms.cause : !turn.cause.empty() ? turn.cause : of_v.cause;
        const MatXX F = changed(changed(of_arms.J, {{3, turn.J}}), {{0, of_v.J}}, 6);
        if (!cause.empty()) mistakes.push_back({"8c", cause, sum(F, B)});
      }
    }
  }
  struct Density {
    Text cause;  // empty if it is right
    double variance;
  };
  const auto densities = [dt](double sigma) {
    return std::vector<Density>{{{}, sigma * sigma / dt},
                                {"8.density_not_divided", sigma * sigma},
                                {"8.density_times_dt", sigma * sigma * dt},
                                {"8.density_for_variance", sigma / dt},
                                {"8.density_for_variance", sigma},
                                {"8.density_for_variance", sigma * dt}};
  };
  for (const Part& of_B : {Part{{}, B},
                           {"8.B_without_jacobian", changed(B, {{3, dt * I}})},
                           {"8.B_inverse_jacobian", changed(B, {{3, dt * RightJacobianInverseSO3(dt * step.w)}})},
                           {"8.B_without_position", changed(B, {{0, O}}, 0)},
                           {"8.B_not_turned", changed(B, {{6, dt * I}}, 0)},
                           {"8.B_not_turned", changed(B, {{0, 0.5 * dt * dt * I}, {6, dt * I}}, 0)},
                           {"8.B_columns", B_exchanged}}) {
    for (const Density& a : densities(step.sigma_a)) {
      for (const Density& g : densities(step.sigma_g)) {
        const Text& cause = !of_B.cause.empty() ? of_B.cause : !a.cause.empty() ? a.cause : g.cause;
        const MatXX noise = of_B.J * NoiseOf(a.variance, g.variance) * of_B.J.transpose();
        if (!cause.empty()) mistakes.push_back({"8c", cause, A * P * A.transpose() + noise});
      }
    }
    mistakes.push_back({"8c", "8.sigmas_exchanged",
                        A * P * A.transpose() + of_B.J * NoiseOf(var_g / dt, var_a / dt) * of_B.J.transpose()});
  }
  const MatXX wrong = got - sum(A, B);
  const char* const parts[] = {"δp", "δθ", "δv"};
  const char* const noises[] = {"n_a", "n_g"};
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) {
      mistakes.push_back({"8c",
                          {"8.one_block_of_A", {{"row", Word(parts[i])}, {"column", Word(parts[j])}}},
                          sum(WithOtherBlock(A, P, wrong, 3 * i, 3 * j), B)});
    }
    for (int j = 0; j < 2; ++j) {
      mistakes.push_back({"8c",
                          {"8.one_block_of_B", {{"row", Word(parts[i])}, {"column", Word(noises[j])}}},
                          sum(A, WithOtherBlock(B, Q, wrong, 3 * i, 3 * j))});
    }
  }
  Require("8", what, sum(A, B), got, Words({"δp.x", "δp.y", "δp.z", "δθ.x", "δθ.y", "δθ.z", "δv.x", "δv.y", "δv.z"}),
          mistakes, kTolerance, "8c", "after.covariance");
}

TEST(Stage8, AnImuStepAddsItsNoise) {
  Random random(Seed(227));
  CheckCovariance(RandomStep(/*uncertain=*/false, &random), "8.covariance_of_one_step");
}

TEST(Stage8, AnImuStepMovesTheCovariance) {
  Random random(Seed(229));
  for (int k = 0; k < 3; ++k) {
    CheckCovariance(RandomStep(/*uncertain=*/true, &random), "8.covariance_carried_on");
  }
}

// ---- 8d, a beacon ---------------------------------------------------------------------------------------------------

void CheckRange(const Transform& T, const Vec3& antenna, const Vec3& beacon, double range, const Text& what) {
  const Answer term = Ask("LinearizeRange", {{"T_W_B", T}, {"antenna", antenna}, {"beacon", beacon}, {"range", range}});
  const RangeTerm got{term.Number("residual"), term.Sized("J", 1, 6)};
  const auto distance = [&](const Transform& at) { return (at.p + at.q * antenna - beacon).norm(); };
  const auto is = [](double r) { return MatXX(MatXX::Constant(1, 1, r)); };
  const double h = distance(T);
  Require("8", {"8.part_of", {{"part", "8.range_residual"}, {"scene", what}}}, MatXX::Constant(1, 1, h - range),
          MatXX::Constant(1, 1, got.residual), Words({"r"}),
          {{"8d", "8.range_absolute", is(std::abs(h - range))},  // on paper h > range: other wrong signs show there
           {"8d", "8.measurement_minus_prediction", is(range - h)},
           {"8d", "8.antenna_subtracted", is((T.p - T.q * antenna - beacon).norm() - range)},
           {"8d", "8.antenna_turned_back", is((T.p + T.q.conjugate() * antenna - beacon).norm() - range)},
           {"8d", "8.antenna_forgotten", is((T.p - beacon).norm() - range)},
           {"8d", "8.antenna_not_turned", is((T.p + antenna - beacon).norm() - range)},
           {"8d", "formula.quaternion_order", is((T.p + Reordered(T.q) * antenna - beacon).norm() - range)},
           {"8d", "8.beacon_added", is((T.p + T.q * antenna + beacon).norm() - range)},
           {"8d", "8.range_not_subtracted", is(h)},
           {"8d", SignAdded("range"), is(h + range)},
           {"8d", "8.squares_compared", is(h * h - range)},
           {"8d", "8.squares_compared", is(0.5 * (h * h - range * range))},
           {"8d", "8.relative_error", is(h / range - 1.0)},
           {"8d", "8.squares_compared", is(h * h - range * range)}},
          1e-10, "8d", "term.residual");
  const MatXX right = Differences(6, [&](const VecX& d) { return MatXX::Constant(1, 1, distance(Moved(T, d))); });
  const Eigen::RowVector3d u = (T.p + T.q * antenna - beacon).normalized().transpose(), none = u * 0.0;
  const Mat33 R = T.q.toRotationMatrix();
  const auto row = [](const Eigen::RowVector3d& a, const Eigen::RowVector3d& b) {
    return MatXX((Eigen::Matrix<double, 1, 6>() << a, b).finished());
  };
  Require("8", {"8.part_of", {{"part", "8.range_jacobian"}, {"scene", what}}}, right, got.J, Words({"r"}),
          {{"8d", "8.range_jacobian_sign", row(-u, u * R * Hat(antenna))},
           {"8d", "8.range_turn_sign", row(u, u * R * Hat(antenna))},
           {"8d", "8.increments_exchanged", row(-u * R * Hat(antenna), u)},
           {"8d", "8.range_turn_missing", row(u, none)},
           {"8d", "8.range_turn_on_the_left", row(u, -u * Hat(R * antenna))},
           {"8d", "8.range_not_turned", row(u, -u * Hat(antenna))},
           {"8d", StandsFor("[a] R", "R [a]"), row(u, -u * Hat(antenna) * R)},
           {"8d", "8.range_turned_back", row(u, -u * R.transpose() * Hat(antenna))},
           {"8d", "8.range_position_in_body", row(u * R, -u * R * Hat(antenna))},
           {"8d", "8.range_not_a_unit", row(h * u, -h * u * R * Hat(antenna))},
           {"8d", "8.range_not_a_unit", row(h / range * u, -h / range * u * R * Hat(antenna))}},
          kTolerance, "8d", "term.J", Words({"δp.x", "δp.y", "δp.z", "δθ.x", "δθ.y", "δθ.z"}));
}

// The antenna at (3, 4, 0), the beacon at the origin: the distance is 5, measured as 4.5.
TEST(Stage8, TheRangeOnPaper) {
  CheckRange({Qd::Identity(), Vec3(2, 4, -2)}, Vec3(1, 0, 2), Vec3::Zero(), 4.5, "8.range_on_paper");
}

TEST(Stage8, TheRangeIsDifferentiated) {
  Random random(Seed(233));
  for (int k = 0; k < 4; ++k) {
    const Transform T = RandomPose(&random);
    const Vec3 antenna = RandomMatrix(3, 1, &random), beacon = Vec3(4, 0, 0) + Vec3(RandomMatrix(3, 1, &random));
    const double distance = (T.p + T.q * antenna - beacon).norm();
    CheckRange(T, antenna, beacon, distance * (k % 2 == 0 ? 1.3 : 0.7), {"8.random_beacon", {{"n", Word(k + 1)}}});
  }
}

}  // namespace
}  // namespace ch5::homework
