/// Stage 7, TODOs 7b to 7e: H and b in blocks, then S and Δx, each against a dense oracle; stage_7_pattern.cc comes before.
/// From simple to hard; the first failure ends the check.

#include <gtest/gtest.h>

#include <sstream>

#include "ch5_backend/linear/dense_solvers.h"
#include "ch5_backend/math/psd.h"
#include "ch5_backend/world/simulate/mono_ba.h"
#include "tests/homework/narrate.h"
#include "tests/homework/stage_7_scene.h"

namespace ch5::homework {
namespace {

// ---- 7b, 7c: b and H ---------------------------------------------------------------------------------------------

/// The right H and b, and the parts that a mistake loses.
struct Parts {
  System right;
  Ordering ordering;
  int p;

  Parts(const Graph& graph, const Ordering& of)
      : right(StackedNormalEquations(graph, of.Size())), ordering(of), p(of.dim_poses) {}

  // H with the blocks (row, column) set to zero for which `drop` says so; both are vertices.
  template <typename Drop>
  MatXX Without(const Drop& drop) const {
    MatXX H = right.H;
    std::vector<std::shared_ptr<Vertex>> all = ordering.poses;
    all.insert(all.end(), ordering.landmarks.begin(), ordering.landmarks.end());
    for (const auto& v : all) {
      for (const auto& w : all) {
        if (!drop(*v, *w)) continue;
        H.block(v->OrderingId(), w->OrderingId(), v->LocalDimension(), w->LocalDimension()).setZero();
      }
    }
    return H;
  }
  static bool IsPose(const Vertex& vertex) { return vertex.GetRole() == Role::kPose; }

  // What is left if each edge overwrites what was there.
  System LastEdgeOnly(const Graph& graph) const {
    System last{MatXX::Zero(ordering.Size(), ordering.Size()), VecX::Zero(ordering.Size())};
    for (const auto& edge : graph.Edges()) {
      double drho;
      MatXX W;
      edge->RobustInfo(&drho, &W);
      const VecX Wr = drho * (edge->Information() * edge->Residual());
      for (size_t i = 0; i < edge->Vertices().size(); ++i) {
        const Vertex& v = *edge->Vertices()[i];
        if (v.IsFixed()) continue;
        last.b.segment(v.OrderingId(), v.LocalDimension()) = -edge->Jacobian(i).transpose() * Wr;
        for (size_t k = 0; k < edge->Vertices().size(); ++k) {
          const Vertex& w = *edge->Vertices()[k];
          if (w.IsFixed()) continue;
          last.H.block(v.OrderingId(), w.OrderingId(), v.LocalDimension(), w.LocalDimension()) =
              edge->Jacobian(i).transpose() * W * edge->Jacobian(k);
        }
      }
    }
    return last;
  }
};

void CheckSystem(PlainBlockSolver* solver, const Graph& graph, const std::string& scene) {
  solver->BuildSystem();
  const Parts parts(graph, solver->GetOrdering());
  const System& right = parts.right;
  const Names names = RowNames(solver->GetOrdering());
  const System last = parts.LastEdgeOnly(graph);
  ASSERT_NO_STORY({"7",
                   "b of " + scene,
                   right.b,
                   solver->RightHandSide(),
                   names,
                   {{"7b", "the sign: b = −Σ JᵀWr, as in HΔx = b", [&] { return VecX(-right.b); }},
                    {"7b", "nothing is written to b", [&] { return VecX::Zero(right.b.size()); }},
                    {"7b", "= stands where −= is meant: only the last edge's share is left", [&] { return last.b; }},
                    {"7b", "= stands where −= is meant, and the sign is lost", [&] { return VecX(-last.b); }}}});
  const auto is_pose = [](const Vertex& v) { return Parts::IsPose(v); };
  const MatXX no_pl = parts.Without([&](const Vertex& v, const Vertex& w) { return is_pose(v) != is_pose(w); });
  const MatXX no_ll = parts.Without([&](const Vertex& v, const Vertex& w) { return !is_pose(v) && !is_pose(w); });
  const MatXX no_pairs =
      parts.Without([&](const Vertex& v, const Vertex& w) { return is_pose(v) && is_pose(w) && &v != &w; });
  const MatXX no_diagonal = parts.Without([&](const Vertex& v, const Vertex& w) { return is_pose(v) && &v == &w; });
  const MatXX no_pp = parts.Without([&](const Vertex& v, const Vertex& w) { return is_pose(v) && is_pose(w); });
  ASSERT_NO_STORY(
      {"7",
       "H of " + scene,
       right.H,
       solver->DenseHessian(),
       names,
       {{"7c", "nothing is added to H_pl", [=] { return no_pl; }},
        {"7c", "nothing is added to H_ll", [=] { return no_ll; }},
        {"7c", "nothing is added to H_pp", [=] { return no_pp; }},
        {"7c", "the blocks of two different poses are missing in H_pp: a.number may exceed c.number",
         [=] { return no_pairs; }},
        {"7c", "the diagonal blocks of H_pp are missing: a.number may equal c.number", [=] { return no_diagonal; }},
        {"7c", "= stands where += is meant: only the last edge's share is left", [&] { return last.H; }}}});
}

TEST(Stage7, RightHandSideAndHessian) {
  for (const bool fix_one : {false, true}) {
    Row row(fix_one);
    CheckSystem(MakeSolver(&row.graph).get(), row.graph,
                fix_one ? "5 points and 5 poses in a row, one of them fixed" : "5 points and 5 poses in a row");
    if (HasFatalFailure()) return;
  }
}

TEST(Stage7, HessianOfMixedLandmarksAndLosses) {
  Random random(Seed(73));
  Graph graph;
  const Poses poses = AddPoses(&graph, 3);
  const auto depths = AddInverseDepths(&graph, 3);
  const Points points = AddPoints(&graph, 2);
  for (const auto& depth : depths) {
    AddRandomEdge<2>(&graph, &random, depth, poses[0], poses[2]);
    AddRandomEdge<2>(&graph, &random, poses[2], depth, poses[1]);  // the later pose first
    graph.Edges().back()->SetLossFunction(std::make_shared<CauchyLoss>(1.0));
  }
  for (const auto& point : points) AddRandomEdge<2>(&graph, &random, poses[1], point);
  const auto solver = MakeSolver(&graph);
  for (int again = 0; again < 2; ++again) {  // the second time H is not empty at the start
    CheckSystem(solver.get(), graph, "3 poses, 3 inverse depths and 2 points, edges of three vertices, Cauchy losses");
    if (HasFatalFailure()) return;
  }
}

// ---- 7d, 7e: S and Δx --------------------------------------------------------------------------------------------

/// A damped system, its Schur complement, and what typical mistakes make of them.
struct Case {
  int p;
  MatXX H_pp, H_pl, H_ll_inverse;
  VecX b_p, b_l;
  std::vector<int> dims;  // of the poses

  Case(const System& system, const Ordering& ordering, double lambda, Damping damping) : p(ordering.dim_poses) {
    MatXX H = system.H;
    for (int i = 0; i < H.rows(); ++i) H(i, i) += lambda * DampingEntry(damping, H(i, i));
    const auto l = H.rows() - p;
    H_pp = H.topLeftCorner(p, p);
    H_pl = H.topRightCorner(p, l);
    H_ll_inverse = PseudoInversePsd(H.bottomRightCorner(l, l));
    b_p = system.b.head(p);
    b_l = system.b.tail(l);
    for (const auto& pose : ordering.poses) dims.push_back(pose->LocalDimension());
  }
  MatXX Subtrahend() const { return H_pl * H_ll_inverse * H_pl.transpose(); }
  MatXX Schur() const { return H_pp - Subtrahend(); }
  VecX Reduced() const { return b_p - H_pl * H_ll_inverse * b_l; }
  // The diagonal blocks of A, or all others.
  MatXX DiagonalBlocks(const MatXX& A, bool others) const {
    MatXX kept = others ? A : MatXX::Zero(p, p);
    int row = 0;
    for (const int dim : dims) {
      if (others) kept.block(row, row, dim, dim).setZero();
      if (!others) kept.block(row, row, dim, dim) = A.block(row, row, dim, dim);
      row += dim;
    }
    return kept;
  }
  VecX Step(const VecX& of_landmarks) const {
    VecX x(p + of_landmarks.size());
    VecX of_poses = VecX::Zero(p);
    if (p > 0) SolveLdlt(Schur(), Reduced(), &of_poses);
    x << of_poses, of_landmarks;
    return x;
  }
  VecX Rest(double sign) const { return b_l + sign * H_pl.transpose() * Step(b_l).head(p); }
};

std::vector<Mistake> ReducedMistakes(const Case& c) {
  return {{"7d", "the right-hand side is not reduced: K_il b_l is not subtracted", [=] { return c.b_p; }},
          {"7d", "the sign: K_il b_l is added, not subtracted",
           [=] { return VecX(c.b_p + c.H_pl * c.H_ll_inverse * c.b_l); }},
          {"7d", "H_ll⁻¹ is missing: use K_il, not H_pl_(i, l)", [=] { return VecX(c.b_p - c.H_pl * c.b_l); }}};
}

std::vector<Mistake> SchurMistakes(const Case& c) {
  const MatXX all = c.Subtrahend();
  return {{"7d", "nothing is subtracted: S is H_pp alone", [=] { return c.H_pp; }},
          {"7d", "the sign: K_il H_jlᵀ is added, not subtracted", [=] { return MatXX(c.H_pp + all); }},
          {"7d", "only the diagonal blocks S(i, i) are reduced: j runs over all poses that see the landmark",
           [=] { return MatXX(c.H_pp - c.DiagonalBlocks(all, false)); }},
          {"7d", "the diagonal blocks S(i, i) are not reduced: a pose makes a pair with itself too, i ≥ j",
           [=] { return MatXX(c.H_pp - c.DiagonalBlocks(all, true)); }},
          {"7d", "H_ll⁻¹ is missing: use K_il, not H_pl_(i, l)",
           [=] { return MatXX(c.H_pp - c.H_pl * c.H_pl.transpose()); }}};
}

std::vector<Mistake> StepMistakes(const Case& c) {
  const auto step = [&](const VecX& of_landmarks) {
    const VecX x = c.Step(of_landmarks);
    return std::function<MatXX()>([x] { return x; });
  };
  return {{"7e", "the landmarks do not hear of the poses: H_ilᵀ Δx_i is not subtracted", step(c.H_ll_inverse * c.b_l)},
          {"7e", "the sign: it is b_l − Σ_i H_ilᵀ Δx_i, not +", step(c.H_ll_inverse * c.Rest(+1.0))},
          {"7e", "H_ll⁻¹ is missing: this is b_l − Σ_i H_ilᵀ Δx_i", step(c.Rest(-1.0))},
          {"7e", "the landmarks do not move", step(VecX::Zero(c.b_l.size()))},
          {"7e", "b_l is missing: this is −H_ll⁻¹ Σ_i H_ilᵀ Δx_i", step(c.H_ll_inverse * (c.Rest(-1.0) - c.b_l))},
          {"7e", "the sign of the whole landmark step is wrong", step(-c.H_ll_inverse * c.Rest(-1.0))}};
}

void CheckSolve(PlainBlockSolver* solver, const Graph& graph, double lambda, Damping damping,
                const std::string& scene) {
  const System system = StackedNormalEquations(graph, solver->Size());
  const Case c(system, solver->GetOrdering(), lambda, damping);
  solver->SetDamping(damping);
  solver->BuildSystem();
  VecX delta_x;
  const bool solved = solver->Solve(lambda, &delta_x);
  std::ostringstream where;
  where << " of " << scene << ", λ = " << lambda << (damping == Damping::kIdentity ? "" : ", D = diag(H)");
  const Names names = RowNames(solver->GetOrdering());
  ASSERT_NO_STORY({"7", "b_p − Σ_l H_pl H_ll⁻¹ b_l" + where.str(), c.Reduced(), solver->ReducedRightHandSide(), names,
                   ReducedMistakes(c), 1e-9});
  ASSERT_NO_STORY({"7", "S = H_pp − Σ_l H_pl H_ll⁻¹ H_plᵀ" + where.str(), c.Schur(), solver->SchurComplement(), names,
                   SchurMistakes(c), 1e-9});
  if (!solved) {
    FAIL() << Story("7", "Δx" + where.str(), "Solve returns true, the system is positive definite", "false",
                    "the function gave up: S is not positive definite, or Δx is not finite", "");
  }
  ASSERT_NO_STORY(
      {"7", "Δx" + where.str(), c.Step(c.H_ll_inverse * c.Rest(-1.0)), delta_x, names, StepMistakes(c), 1e-8});
  ASSERT_NO_STORY(
      {"7", "H after Solve (one H serves many λ)" + where.str(), system.H, solver->DenseHessian(), names, {}, 1e-9});
}

TEST(Stage7, SchurComplementAndStep) {
  for (const bool fix_one : {false, true}) {
    Row row(fix_one);
    CheckSolve(MakeSolver(&row.graph).get(), row.graph, 0.0, Damping::kIdentity,
               fix_one ? "5 points and 5 poses in a row, one of them fixed" : "5 points and 5 poses in a row");
    if (HasFatalFailure()) return;
  }
}

TEST(Stage7, LambdaOnEveryDiagonalEntry) {
  Row row;
  const auto solver = MakeSolver(&row.graph);
  for (const double lambda : {10.0, 1e-3, 0.5}) {  // the same solver each time
    for (const Damping damping : {Damping::kIdentity, Damping::kDiagonal}) {
      CheckSolve(solver.get(), row.graph, lambda, damping, "5 points and 5 poses in a row");
      if (HasFatalFailure()) return;
    }
  }
}

TEST(Stage7, LandmarksOrPosesAlone) {
  for (const bool landmarks : {true, false}) {
    Row row;
    for (const auto& pose : row.poses) pose->SetFixed(landmarks);
    for (const auto& point : row.points) point->SetFixed(!landmarks);
    CheckSolve(MakeSolver(&row.graph).get(), row.graph, 0.1, Damping::kIdentity,
               landmarks ? "5 points, all poses fixed" : "5 poses, all points fixed");
    if (HasFatalFailure()) return;
  }
}

TEST(Stage7, BundleAdjustmentOfTheCourse) {
  MonoBaOptions options;
  options.seed = Seed(options.seed);
  options.frames = 4;
  options.points = Vary(20, 30, 74);
  MonoBa ba;
  BuildMonoBa(SimulateMonoBa(options), Gauge::kFixTwoFrames, 1.0, 0.0, &ba);
  const auto solver = MakeSolver(&ba.graph);
  CheckSolve(solver.get(), ba.graph, 1e-2, Damping::kIdentity, "the course's scene, 2 of 4 poses fixed");
  if (HasFatalFailure()) return;
  const double before = solver->ComputeChi();
  const Summary summary = Minimize(solver.get(), SolveOptions{});
  if (!IsConverged(summary.termination) || summary.final_cost > 1e-2 * before) {
    FAIL() << Story("7", "the course's scene solved with your BuildSystem and Solve",
                    "converged, at less than a hundredth of the cost",
                    summary.message + ", at " + std::to_string(summary.final_cost) + " from " + std::to_string(before),
                    "one call is right, many are not: something is kept from the call before", "");
  }
}

}  // namespace
}  // namespace ch5::homework
