#include "ch5_homework/judge/right/open_tasks.h"

#include <algorithm>
#include <cmath>

namespace ch5::homework::right {

namespace {

Expression Number(const char* name, double x, int size = 1) { return Matrix(name, x * MatXX::Identity(size, size)); }
Text EntriesOf(const char* block) { return {"formula.entries_of", {{"block", Word(std::string(block))}}}; }

// x, y, z, w read as w, x, y, z.
Mat33 Reordered(const Qd& q) { return Qd(q.x(), q.y(), q.z(), q.w()).toRotationMatrix(); }

// ---- 8a --------------------------------------------------------------------------------------------------------------

constexpr double kThird = 1.0 / 3.0;

double Nielsen(double rho) { return 1.0 - std::pow(2.0 * rho - 1.0, 3); }
double Limited(double factor) { return std::clamp(factor, kThird, 2.0 * kThird); }

// One number for each trial, on a diagonal: products are those of each trial.
template <typename Of>
Expression Each(const char* name, const std::vector<Trial>& trials, const Of& of) {
  VecX numbers(trials.size());
  for (size_t k = 0; k < trials.size(); ++k) numbers[static_cast<Eigen::Index>(k)] = of(trials[k]);
  return Matrix(name, numbers.asDiagonal());
}
Expression AsVector(const Expression& x) {
  return Seen(x, [](const MatXX& A) { return MatXX(A.diagonal()); });
}

Expression FactorAfterGain(const std::vector<Trial>& trials) {
  const auto by = [&](double (*factor)(double rho), const char* name = "max(⅓, min(⅔, 1 − (2ϱ − 1)³))") {
    return Each(name, trials, [&](const Trial& t) { return factor((t.cost - t.trial_cost) / t.predicted); });
  };
  const auto by_cost = [](const Trial& t) { return Limited(Nielsen((t.cost - t.trial_cost) / t.cost)); };
  return MistakenFor(
      by([](double rho) { return Limited(Nielsen(rho)); }),
      {{by([](double rho) { return std::max(kThird, Nielsen(rho)); }), "8.cap_missing"},
       {by([](double rho) { return std::clamp(Nielsen(rho), kThird, 1.0); }), "8.cap_missing"},
       {by([](double rho) { return std::min(2.0 * kThird, Nielsen(rho)); }), "8.floor_missing"},
       {by(&Nielsen), "8.limits_missing"},
       {by([](double rho) { return std::clamp(Nielsen(rho), 0.0, 2.0 * kThird); }), "8.integers_divided"},
       {by([](double) { return 0.0; }), "8.integers_divided"},
       {by([](double rho) { return Limited(1.0 - Nielsen(rho)); }), "8.one_missing"},
       {by([](double rho) { return Limited(2.0 - Nielsen(rho)); }, "max(⅓, min(⅔, 1 + (2ϱ − 1)³))")},
       {by([](double rho) { return Limited(1.0 - std::pow(2.0 * rho - 1.0, 2)); }), "8.square_for_cube"},
       {by([](double rho) { return Limited(1.0 - (2.0 * rho - 1.0)); }), "8.square_for_cube"},
       {by([](double rho) { return Limited(1.0 - (2.0 * std::pow(rho, 3) - 1.0)); }, "max(⅓, min(⅔, 1 − (2ϱ³ − 1)))")},
       {by([](double rho) { return Limited(1.0 - (std::pow(2.0 * rho, 3) - 1.0)); },
           "max(⅓, min(⅔, 1 − ((2ϱ)³ − 1)))")},
       {by([](double rho) { return Limited(1.0 - std::pow(2.0 * rho + 1.0, 3)); }, "max(⅓, min(⅔, 1 − (2ϱ + 1)³))")},
       {by([](double rho) { return Limited(1.0 - std::pow(2.0 * rho, 3)); }, "max(⅓, min(⅔, 1 − (2ϱ)³))")},
       {by([](double rho) { return Limited(Nielsen(2.0 * rho)); }), "8.half_the_promise"},
       {by([](double rho) { return Limited(Nielsen(0.5 * rho)); }), "8.half_the_promise"},
       {by([](double rho) { return Limited(Nielsen(1.0 / rho)); }), "8.gain_inverted"},
       {by([](double rho) { return Limited(Nielsen(-rho)); }, "max(⅓, min(⅔, 1 − (−2ϱ − 1)³))")},
       {Each("", trials, by_cost), "8.gain_by_the_cost"}});
}

}  // namespace

NextDamping::NextDamping(const std::vector<Trial>& trials, bool accepted, const VecX& factors) {
  const int n = static_cast<int>(trials.size());
  const Expression l = Each("λ", trials, [](const Trial&t) { return t.lambda; }), two = Number("2", 2.0, n),
                   nu_before = Each("ν", trials, [](const Trial&t) { return t.nu; });
  const Expression twice = Named(2.0 * nu_before, "2 ν"), one = Number("1", 1.0, n);
  lambda = {AsVector(l * (accepted ? FactorAfterGain(trials) : nu_before)), {nu_before, twice, l + nu_before}};
  const auto other = [&](const Trial& t) {
    const double free = Nielsen((t.cost - t.trial_cost) / t.predicted);
    return t.lambda * std::min(std::max(free, factors.minCoeff()), factors.maxCoeff());
  };
  if (accepted) between_other_limits = Value(AsVector(Each("", trials, other)));
  nu = {AsVector(accepted ? two : two * nu_before), {nu_before, twice, l, one, two + nu_before}};
}

// ---- 8b --------------------------------------------------------------------------------------------------------------

Projection::Projection(const Transform& T_W_B, const Transform& T_B_C, const Vec3& p_W) {
  const Vec3 d = p_W - T_W_B.p, p_B = T_W_B.q.conjugate() * d, p_C = T_B_C.q.conjugate() * (p_B - T_B_C.p);
  const Expression R_W_B = Matrix("R_W_B", T_W_B.q.toRotationMatrix()),
                   R_B_C = Matrix("R_B_C", T_B_C.q.toRotationMatrix());
  const auto inverse = [](const char* name, double x) { return Inverse(Number(name, x)); };
  const Expression z_inverse =
      MistakenFor(inverse("z", p_C.z()), {inverse("‖p_C‖", p_C.norm()), inverse("p_B.z", p_B.z()),
                                          inverse("p_W.z", p_W.z()), inverse("x", p_C.x()), inverse("y", p_C.y())});
  const auto of_depth = [&](double own, double other) {
    return -(MistakenFor(Number("(x, y)", own), {Number("(y, x)", other)}) * z_inverse * z_inverse);
  };
  const Expression focal = Number("1", 1.0) * z_inverse;
  const Text depth = EntriesOf("∂r/∂z");
  const Expression E = Assembly("∂r/∂p_C", 2, 3,
                                {{focal, {0, 0}, {}, {EntriesOf("∂r.x/∂x")}},
                                 {focal, {1, 1}, {}, {EntriesOf("∂r.y/∂y")}},
                                 {of_depth(p_C.x(), p_C.y()), {0, 2}, {}, {depth, EntriesOf("∂r.x/∂z")}},
                                 {of_depth(p_C.y(), p_C.x()), {1, 2}, {}, {depth, EntriesOf("∂r.y/∂z")}}});
  const Expression point = E * Transpose(R_B_C) * Transpose(R_W_B);
  const auto arm = [](const char* name, const Vec3& a) { return Matrix(name, Hat(a)); };
  const Expression rotation = E * Transpose(R_B_C) * arm("[p_B]", p_B);

  over_point = {point, {Matrix("∂r/∂p_C, x ↔ y", Value(E).colwise().reverse())}};
  over_position = {-point, {Named(rotation, "∂r/∂δθ")}};
  over_rotation = {rotation,
                   {arm("[p_C]", p_C), arm("[p_W − p]", d), arm("[p_W]", p_W), point * arm("[p_W − p]", d),
                    point * arm("[p_W]", p_W), point * arm("[p_B]", p_B), E * arm("[p_C]", p_C) * Transpose(R_B_C),
                    Named(-point, "∂r/∂δp")}};
}

// ---- 8c --------------------------------------------------------------------------------------------------------------

namespace {

// What the state's and the covariance's formulas have in common.
struct ImuTerms {
  Expression dt, half, I, R_0, Exp;

  explicit ImuTerms(const ImuStep& step)
      : dt(Number("dt", step.dt, 3)), half(Number("½", 0.5, 3)), I(Number("I", 1.0, 3)) {
    const Qd &q = step.before.q, turn = ExpSO3(step.dt * step.w), middle = q * ExpSO3(0.5 * step.dt * step.w);
    const MatXX given = q.toRotationMatrix(), at_end = (q * turn).toRotationMatrix();
    const auto rotation = [](const MatXX& A) { return Matrix("R", A); };
    R_0 = MistakenFor(rotation(given), {{rotation(at_end), "8.imu_turned_by_new"},
                                        {rotation(0.5 * (given + at_end)), "8.imu_turned_by_new"},
                                        {rotation(middle.toRotationMatrix()), "8.imu_turned_by_new"},
                                        {rotation(Reordered(q)), "formula.quaternion_order"}});
    const auto exp = [&](double times) { return Matrix("Exp(ω dt)", ExpSO3(times * step.w).toRotationMatrix()); };
    const Vec3 angles = 0.5 * step.dt * step.w;
    const Qd small = Qd(1.0, angles.x(), angles.y(), angles.z()).normalized();
    Exp = MistakenFor(exp(step.dt), {{exp(1.0), "8.imu_rate_without_dt"},
                                     {exp(0.5 * step.dt), "8.imu_half_turn"},
                                     {exp(2.0 * step.dt), "8.imu_double_turn"},
                                     {rotation(small.toRotationMatrix()), "8.imu_small_turn"}});
  }
};

Share Block(const Expression& x, const Place& at, const std::vector<Text>& kinds, const Place& elsewhere,
            const Text& where = "8.A_arm_at_mirror_place") {
  return {x, at, {}, kinds, {{where, elsewhere}}};
}

// A
Expression Transition(const ImuStep& step, const ImuTerms& terms) {
  const auto& [dt, half, I, R_0, Exp] = terms;
  const Expression R_arm = MistakenFor(Named(R_0 * Matrix("[a]", Hat(step.a)), "R [a]"),
                                       {{Matrix("[R a]", Hat(step.before.q * step.a)), "8.A_left_perturbation"}});
  const Expression first_order = Matrix("I − [ω] dt", MatXX::Identity(3, 3) - step.dt * Hat(step.w));
  const Expression turns = MistakenFor(Named(Transpose(Exp), "Exp(ω dt)ᵀ"),
                                       {{first_order, "8.A_turn_to_first_order"}, {I, "8.A_without_turn"}});
  const Text arms = EntriesOf("∂[δp', δv']/∂δθ");
  return Assembly("A", 9, 9,
                  {{I, {0, 0}, {}, {EntriesOf("∂δp'/∂δp")}},
                   Block(-(half * dt * dt * R_arm), {0, 3}, {arms, EntriesOf("∂δp'/∂δθ")}, {3, 0}),
                   Block(dt, {0, 6}, {EntriesOf("∂δp'/∂δv")}, {6, 0}, "8.A_block_at_mirror_place"),
                   {turns, {3, 3}, {}, {EntriesOf("∂δθ'/∂δθ")}},
                   Block(-(dt * R_arm), {6, 3}, {arms, EntriesOf("∂δv'/∂δθ")}, {3, 6}),
                   {I, {6, 6}, {}, {EntriesOf("∂δv'/∂δv")}}});
}

// B
Expression NoiseToError(const ImuStep& step, const ImuTerms& terms) {
  const Text of_a = EntriesOf("∂[δp', δv']/∂n_a");
  const Expression &dt = terms.dt, J_r = Matrix("J_r", RightJacobianSO3(step.dt * step.w));
  return Assembly(
      "B", 9, 6,
      {Block(terms.half * dt * dt * terms.R_0, {0, 0}, {of_a, EntriesOf("∂δp'/∂n_a")}, {0, 3}, "8.B_columns"),
       Block(dt * J_r, {3, 3}, {EntriesOf("∂δθ'/∂n_g")}, {3, 0}, "8.B_columns"),
       Block(dt * terms.R_0, {6, 0}, {of_a, EntriesOf("∂δv'/∂n_a")}, {6, 3}, "8.B_columns")});
}

// Q
Expression Noise(const ImuStep& step, const Expression& dt) {
  const auto variance = [&](double sigma, double other, int at, const char* name) {
    const Expression s = MistakenFor(Number("σ", sigma, 3), {{Number("σ", other, 3), "8.sigmas_exchanged"}});
    return Share{s * s * Inverse(dt), {at, at}, {}, {EntriesOf(name)}};
  };
  return Assembly("Q", 6, 6,
                  {variance(step.sigma_a, step.sigma_g, 0, "Q_a"), variance(step.sigma_g, step.sigma_a, 3, "Q_g")});
}

}  // namespace

Integrated::Integrated(const ImuStep& step) {
  const ImuTerms terms(step);
  const auto& [dt, half, I, R_0, Exp] = terms;
  const Expression R_a = R_0 * Matrix("a", step.a), gravity = Matrix("g", 9.81 * Vec3::UnitZ());
  const Expression turned =
      MistakenFor(Named(R_a, "R a"), {{R_a - gravity, "8.imu_gravity_added"}, {R_a + gravity, "8.imu_gravity_added"}});
  const Expression velocity = Matrix("v", step.before.v), v_end = Named(velocity + dt * R_a, "v'");

  p = {Matrix("p", step.before.p) + dt * MistakenFor(velocity, {{v_end, "8.imu_velocity_first"}}) +
       half * dt * dt * turned};
  v = {velocity + dt * turned};
  R = {R_0 * Exp};

  const Expression transition = Transition(step, terms), of_noise = NoiseToError(step, terms),
                   variances = Noise(step, dt), uncertain = Matrix("P", step.before.covariance);
  MatXX two_signs = Value(of_noise);  // which of the two is wrong cannot be seen
  two_signs.topRows(3) *= -1.0;
  const Expression noise_to_error = MistakenFor(of_noise, {{Matrix("B", two_signs), "8.B_two_signs"}});
  const Expression noise = MistakenFor(variances, {Matrix("Q^½", Value(variances).cwiseSqrt())});
  covariance = {Named(transition * uncertain * Transpose(transition), "A P Aᵀ") +
                noise_to_error * noise * Transpose(noise_to_error)};
  A = Value(transition), P = Value(uncertain), B = Value(of_noise), Q = Value(variances);
}

// ---- 8d --------------------------------------------------------------------------------------------------------------

Range::Range(const Transform& T_W_B, const Vec3& antenna, const Vec3& beacon, double range) {
  const Expression R = MistakenFor(Matrix("R", T_W_B.q.toRotationMatrix()),
                                   {{Matrix("R", Reordered(T_W_B.q)), "formula.quaternion_order"}});
  const Expression a = Matrix("a", antenna), from_beacon = Matrix("p", T_W_B.p) + R * a - Matrix("beacon", beacon);
  const auto norm = [](const MatXX& d) { return MatXX(MatXX::Constant(1, 1, d.norm())); };
  const double h = Value(from_beacon).norm();
  const Expression measured = Number("range", range), distance = Number("‖d‖", h);
  residual = {
      Named(Seen(from_beacon, norm), "‖p + R a − beacon‖") - measured,
      {Number("|‖d‖ − range|", std::abs(h - range)), measured - distance, Number("‖d‖ / range − 1", h / range - 1.0),
       Number("‖d‖² − range", h * h - range), Number("‖d‖² − range²", h * h - range * range),
       Number("½ (‖d‖² − range²)", 0.5 * (h * h - range * range))}};

  const VecX u = Value(from_beacon) / h;
  const Expression along = MistakenFor(Matrix("u", u), {{Matrix("d", h * u), "8.range_not_a_unit"},
                                                        {Matrix("d / range", h / range * u), "8.range_not_a_unit"}});
  const Expression arm = MistakenFor(Matrix("[a]", Hat(antenna)),
                                     {Matrix("[R a]", Hat(T_W_B.q * antenna)), Matrix("[beacon]", Hat(beacon)),
                                      Matrix("[p + R a − beacon]", Hat(h * u))}),
                   u_t = Transpose(along);
  const Expression rotation = -(u_t * R * arm);
  over_position = {u_t, {u_t * R, Named(rotation, "∂r/∂δθ"), Matrix("0", MatXX::Zero(1, 3))}};
  over_rotation = {rotation, {-(u_t * Matrix("[R a]", Hat(T_W_B.q * antenna))), -(u_t * arm), Named(u_t, "∂r/∂δp")}};
}

}  // namespace ch5::homework::right
