/// Stage 1.2: Δx equals a dense solve of the damped system (H + λD) Δx = b. H and b come from elsewhere, so that
/// stage 1.1 may be blank. From simple to hard; the first failure ends the check.

#include <gtest/gtest.h>

#include "ch5_backend/linear/dense_solvers.h"
#include "ch5_backend/math/psd.h"
#include "tests/homework/narrate.h"
#include "tests/homework/scenes.h"
#include "tests/homework/submission.h"

namespace ch5::homework {
namespace {

/// A damped system taken apart, and what follows from it.
struct Parts {
  MatXX H_pp, H_pm, H_mm, H_mm_inverse;
  VecX b_p, b_m;

  Parts(const MatXX& H, const VecX& b, int p) {
    const auto m = H.rows() - p;
    H_pp = H.topLeftCorner(p, p);
    H_pm = H.topRightCorner(p, m);
    H_mm = H.bottomRightCorner(m, m);
    H_mm_inverse = PseudoInversePsd(H_mm);
    b_p = b.head(p);
    b_m = b.tail(m);
  }
  MatXX Schur() const { return H_pp - H_pm * H_mm_inverse * H_pm.transpose(); }
  VecX Reduced() const { return b_p - H_pm * H_mm_inverse * b_m; }
};

VecX Solve(const MatXX& A, const VecX& b) {
  VecX x = VecX::Zero(b.size());
  SolveLdlt(A, b, &x);
  return x;
}

// H with λ_p D on the poses' diagonal and λ_m D on the landmarks'.
MatXX Damp(const MatXX& H, int p, double lambda_p, double lambda_m, Damping damping) {
  const VecX D = damping == Damping::kIdentity ? VecX::Ones(H.rows()) : VecX(H.diagonal());
  MatXX damped = H;
  damped.diagonal().head(p) += lambda_p * D.head(p);
  damped.diagonal().tail(H.rows() - p) += lambda_m * D.tail(H.rows() - p);
  return damped;
}

struct DampingMistake {
  const char* cause;
  MatXX H;
};

/// Everything that can be asked about one call of SolveLinearSystem.
struct Case {
  System system;
  int p;  // dimension of the poses
  double lambda;
  Damping damping;

  MatXX Damped() const { return Damp(system.H, p, lambda, lambda, damping); }
  Parts Right() const { return Parts(Damped(), system.b, p); }

  std::vector<DampingMistake> DampingMistakes() const {
    const Damping other = damping == Damping::kIdentity ? Damping::kDiagonal : Damping::kIdentity;
    const auto damp = [&](double p_times, double m_times) {
      return Damp(system.H, p, p_times * lambda, m_times * lambda, damping);
    };
    return {{"λ is missing: the blocks come from the undamped Hessian_ instead of H", system.H},
            {"λ is missing on the landmarks: H_mm must be damped before it is inverted (take it from H)", damp(1, 0)},
            {"λ is missing on the poses: the corner H_pp comes from the undamped Hessian_ instead of H", damp(0, 1)},
            {"λ is added twice to the poses: H is damped already", damp(2, 1)},
            {"λ is added twice: H is damped already", damp(2, 2)},
            {"λ is added twice to the landmarks: H is damped already", damp(1, 2)},
            {damping == Damping::kIdentity ? "the damping is λ·diag(H), but λ·I was asked: use DampedHessian"
                                           : "the damping is λ·I, but λ·diag(H) was asked: use DampedHessian",
             Damp(system.H, p, lambda, lambda, other)}};
  }

  std::vector<Mistake> SchurMistakes() const {
    const Parts r = Right();
    std::vector<Mistake> mistakes{
        {"1.2b", "the sign: H_pm H_mm⁻¹ H_mp is added, not subtracted",
         [=] { return MatXX(r.H_pp + r.H_pm * r.H_mm_inverse * r.H_pm.transpose()); }},
        {"1.2b", "nothing is subtracted: this is H_pp alone", [=] { return r.H_pp; }},
        {"1.2b", "H_mm⁻¹ is missing in H_pm H_mm⁻¹ H_mp", [=] { return MatXX(r.H_pp - r.H_pm * r.H_pm.transpose()); }},
        {"1.2b", "H_mm stands where its inverse is meant",
         [=] { return MatXX(r.H_pp - r.H_pm * r.H_mm * r.H_pm.transpose()); }}};
    if (r.H_pm.rows() == r.H_pm.cols()) {  // here an exchange of p and m goes unseen by Eigen
      const MatXX Q = r.H_pm.transpose();
      mistakes.push_back({"1.2a", "H_pm and H_mp are exchanged: H_pm is at the top right, rows of poses",
                          [=] { return MatXX(r.H_pp - Q * r.H_mm_inverse * r.H_pm); }});
      mistakes.push_back({"1.2a", "H_mp holds H_pm: H_mp is at the bottom left, rows of landmarks",
                          [=] { return MatXX(r.H_pp - r.H_pm * r.H_mm_inverse * r.H_pm); }});
      mistakes.push_back({"1.2a", "H_pm holds H_mp: H_pm is at the top right, rows of poses",
                          [=] { return MatXX(r.H_pp - Q * r.H_mm_inverse * Q); }});
      mistakes.push_back({"1.2b", "the corner of the landmarks, H_mm, stands where the poses' H_pp is meant",
                          [=] { return MatXX(r.H_mm - r.H_pm * r.H_mm_inverse * Q); }});
    }
    for (const DampingMistake& damping_mistake : DampingMistakes()) {
      const MatXX wrong = Parts(damping_mistake.H, system.b, p).Schur();
      mistakes.push_back({"1.2a", damping_mistake.cause, [=] { return wrong; }});
    }
    return mistakes;
  }

  std::vector<Mistake> ReducedMistakes() const {
    const Parts r = Right();
    std::vector<Mistake> mistakes{
        {"1.2b", "the right-hand side is not reduced: H_pm H_mm⁻¹ b_m is not subtracted", [=] { return r.b_p; }},
        {"1.2b", "the sign: H_pm H_mm⁻¹ b_m is added, not subtracted",
         [=] { return VecX(r.b_p + r.H_pm * r.H_mm_inverse * r.b_m); }},
        {"1.2b", "H_mm⁻¹ is missing in H_pm H_mm⁻¹ b_m", [=] { return VecX(r.b_p - r.H_pm * r.b_m); }},
        {"1.2a",
         "the beginning of b, the poses' part, stands where the landmarks' is meant; that starts at reserve_size",
         [=] { return VecX(r.b_p - r.H_pm * r.H_mm_inverse * system.b.head(r.b_m.size())); }}};
    if (r.b_p.size() == r.b_m.size()) {
      mistakes.push_back(
          {"1.2a", "b_p and b_m are exchanged", [=] { return VecX(r.b_m - r.H_pm * r.H_mm_inverse * r.b_p); }});
    }
    return mistakes;
  }

  std::vector<Mistake> StepMistakes() const {
    const Parts r = Right();
    const VecX x_p = Solve(r.Schur(), r.Reduced());
    const VecX H_mp_x = r.H_pm.transpose() * x_p;
    const auto step = [x_p](const VecX& x_m) {
      VecX x(x_p.size() + x_m.size());
      x << x_p, x_m;
      return std::function<MatXX()>([x] { return x; });
    };
    std::vector<Mistake> mistakes{
        {"1.2c", "the landmarks do not hear of the poses: − H_mp Δx_p is missing before H_mm⁻¹ is applied",
         step(r.H_mm_inverse * r.b_m)},
        {"1.2c", "the sign: it is b_m − H_mp Δx_p, not +", step(r.H_mm_inverse * (r.b_m + H_mp_x))},
        {"1.2c", "the sign of the whole landmark step is wrong", step(-r.H_mm_inverse * (r.b_m - H_mp_x))},
        {"1.2c", "H_mm⁻¹ is missing: this is b_m − H_mp Δx_p", step(r.b_m - H_mp_x)},
        {"1.2c", "H_mm stands where its inverse is meant", step(r.H_mm * (r.b_m - H_mp_x))},
        {"1.2c", "b_m is missing: this is −H_mm⁻¹ H_mp Δx_p", step(-r.H_mm_inverse * H_mp_x)},
        {"1.2c", "H_mm⁻¹ is applied to b_m only: the brackets around b_m − H_mp Δx_p are missing",
         step(r.H_mm_inverse * r.b_m - H_mp_x)},
        {"1.2c", "the landmarks do not move: delta_x_ll is zero", step(VecX::Zero(r.b_m.size()))}};
    if (r.b_p.size() == r.b_m.size()) {  // here Eigen does not see it
      mistakes.push_back({"1.2c", "H_pm stands where H_mp is meant: H_mp has the landmarks' rows",
                          step(r.H_mm_inverse * (r.b_m - r.H_pm * x_p))});
      mistakes.push_back(
          {"1.2c", "the poses' b_p stands where the landmarks' b_m is meant", step(r.H_mm_inverse * (r.b_p - H_mp_x))});
      mistakes.push_back({"1.2c", "the poses' reduced b stands where the landmarks' b_m is meant",
                          step(r.H_mm_inverse * (r.Reduced() - H_mp_x))});
    }
    for (const DampingMistake& damping_mistake : DampingMistakes()) {
      const VecX wrong = Solve(damping_mistake.H, system.b);
      mistakes.push_back({"1.2a", damping_mistake.cause, [=] { return wrong; }});
      const MatXX H_mm_inverse = Parts(damping_mistake.H, system.b, p).H_mm_inverse;
      mistakes.push_back({"1.2c", "the poses are right; for the landmarks " + std::string(damping_mistake.cause),
                          step(H_mm_inverse * (r.b_m - H_mp_x))});
    }
    return mistakes;
  }
};

// One call, checked in the order in which a student computes.
void CheckCall(Problem* problem, const Case& c, const std::string& scene) {
  problem->SetDamping(c.damping);
  VecX delta_x;
  const bool solved = problem->SolveLinearSystem(c.lambda, &delta_x);

  std::ostringstream where;
  where << " of " << scene << ", λ = " << c.lambda << (c.damping == Damping::kIdentity ? "" : ", D = diag(H)");
  const Names names = RowNames(problem->GetOrdering());
  const Parts right = c.Right();
  // Who solves the whole system without a Schur complement is right too: then there is none to compare.
  const bool reduced = problem->SchurComplement().size() > 0 && right.b_m.size() > 0;
  if (reduced) {
    ASSERT_NO_STORY({"1.2", "H_pp − H_pm H_mm⁻¹ H_mp" + where.str(), right.Schur(), problem->SchurComplement(), names,
                     c.SchurMistakes(), 1e-9});
    ASSERT_NO_STORY({"1.2", "b_p − H_pm H_mm⁻¹ b_m" + where.str(), right.Reduced(), ReducedRightHandSide(*problem),
                     names, c.ReducedMistakes(), 1e-9});
  }
  if (!solved) {
    FAIL() << Story("1.2", "Δx" + where.str(), "SolveLinearSystem returns true, the system is positive definite",
                    "false", "the function gave up: a block is not positive definite, or Δx is not finite", "");
  }
  // Explicit inverses and conjugate gradients are welcome, and lose some digits.
  ASSERT_NO_STORY({"1.2", "Δx" + where.str(), Solve(c.Damped(), c.system.b), delta_x, names, c.StepMistakes(), 1e-7});
}

/// A problem over a graph whose vertices all have an edge, with a random system in place of MakeHessian's.
void CheckRandom(Graph* graph, double lambda, Damping damping, const std::string& scene) {
  Random random(Seed(21));
  for (const auto& vertex : graph->Vertices()) {
    if (auto pose = std::dynamic_pointer_cast<VertexPose>(vertex)) AddRandomEdge<1>(graph, &random, pose);
    if (auto depth = std::dynamic_pointer_cast<VertexInverseDepth>(vertex)) AddRandomEdge<1>(graph, &random, depth);
    if (auto point = std::dynamic_pointer_cast<VertexPointXYZ>(vertex)) AddRandomEdge<1>(graph, &random, point);
  }
  const auto problem = Chosen().make_problem(graph);
  const System system = RandomSystem(problem->GetOrdering(), &random);
  SetSystem(system, problem.get());
  CheckCall(problem.get(), {system, problem->GetOrdering().dim_poses, lambda, damping}, scene);
}

TEST(Stage12, AsManyPoseRowsAsLandmarkRows) {  // first: here no assertion betrays an exchange of p and m
  Graph graph;
  AddPoses(&graph, 1);
  AddInverseDepths(&graph, 6);
  CheckRandom(&graph, 0.0, Damping::kIdentity, "a random system, 6 rows of a pose and 6 inverse depths");
}

TEST(Stage12, LandmarksOfDimensionOne) {
  Graph graph;
  AddPoses(&graph, 2);
  const int depths = Vary(5, 9, 22);
  AddInverseDepths(&graph, depths);
  CheckRandom(&graph, 0.0, Damping::kIdentity,
              "a random system, 2 poses and " + std::to_string(depths) + " inverse depths");
}

TEST(Stage12, LandmarksOfDimensionThree) {
  Graph graph;
  AddPoints(&graph, 2);  // smaller ids than the poses, later rows
  AddPoses(&graph, 2);
  AddInverseDepths(&graph, 1);
  AddPoints(&graph, 1);
  CheckRandom(&graph, 0.0, Damping::kIdentity, "a random system, 2 poses, 3 points of dimension 3, an inverse depth");
}

TEST(Stage12, WithOneLandmarkAndWithNone) {
  for (const int landmarks : {1, 0}) {
    Graph graph;
    AddPoses(&graph, 2);
    AddInverseDepths(&graph, landmarks);
    CheckRandom(&graph, 0.5, Damping::kIdentity,
                "a random system, 2 poses and " + std::string(landmarks ? "one landmark" : "no landmarks"));
    if (HasFatalFailure()) return;
  }
}

TEST(Stage12, LambdaOnEveryDiagonalEntry) {
  for (const double lambda : {1e-3, 0.3, 10.0}) {
    Graph graph;
    AddPoses(&graph, 2);
    AddInverseDepths(&graph, 3);
    AddPoints(&graph, 1);
    CheckRandom(&graph, lambda, Damping::kIdentity, "a random system, 2 poses, 3 inverse depths and a point");
    if (HasFatalFailure()) return;
  }
}

TEST(Stage12, LambdaTimesTheDiagonal) {
  Graph graph;
  AddPoses(&graph, 2);
  const int depths = Vary(7, 11, 23);
  AddInverseDepths(&graph, depths);
  CheckRandom(&graph, 0.3, Damping::kDiagonal,
              "a random system, 2 poses and " + std::to_string(depths) + " inverse depths");
}

TEST(Stage12, BundleAdjustmentWithManyLambdas) {
  MonoBaOptions options;
  options.seed = Seed(options.seed);
  options.frames = 4;
  MonoBa ba;
  BuildMonoBa(SimulateMonoBa(options), Gauge::kFixTwoFrames, 1.0, 0.0, &ba);
  const auto problem = Chosen().make_problem(&ba.graph);
  const System system = StackedNormalEquations(ba.graph, problem->Size());
  SetSystem(system, problem.get());
  for (const double lambda : {1.0, 0.0, 1e-4}) {  // the same H each time, as LM asks for it
    const Case c{system, problem->GetOrdering().dim_poses, lambda, Damping::kIdentity};
    CheckCall(problem.get(), c, "the course's scene, 2 of 4 poses fixed, 20 inverse depths");
    if (HasFatalFailure()) return;
    const Mistake damped{"1.2a",
                         "λ was written into Hessian_ itself, where the next call meets it; H is its damped copy",
                         [&] { return c.Damped(); }};
    ASSERT_NO_STORY({"1.2",
                     "Hessian_ after a call (MakeHessian's H serves many λ)",
                     system.H,
                     problem->Hessian(),
                     RowNames(problem->GetOrdering()),
                     {damped}});
  }
}

}  // namespace
}  // namespace ch5::homework
