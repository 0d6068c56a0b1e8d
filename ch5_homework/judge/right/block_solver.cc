/// Stage 7.

#include <algorithm>

#include "ch5_homework/judge/right/formulas.h"

namespace ch5::homework::right {

namespace {

/// Which poses see which landmarks, and the blocks of both.
struct Sights {
  const MatXX &damped, &undamped;
  const VecX& b;
  const Ordering& ordering;

  MatXX Block(const MatXX& H, const Vertex& a, const Vertex& c) const {
    return H.block(a.OrderingId(), c.OrderingId(), a.LocalDimension(), c.LocalDimension());
  }
  /// The factors of the pair (i, j), by the names of the loop.
  struct Factors {
    Expression H_il, H_jl, H_ll_inverse, b_l;
  };
  Factors Of(const Vertex& i, const Vertex& j, const Vertex& l) const {
    const Expression H_il = Matrix("H_il", Block(damped, i, l)), H_jl = Matrix("H_jl", Block(damped, j, l)),
                     H_ll = Matrix("H_ll", Block(damped, l, l)),
                     undamped_H_ll = Matrix("H_ll (λ = 0)", Block(undamped, l, l));
    return {MistakenFor(H_il, {H_jl}), MistakenFor(H_jl, {H_il}), Inverse(MistakenFor(H_ll, {undamped_H_ll})),
            Matrix("b_l", b.segment(l.OrderingId(), l.LocalDimension()))};
  }

  /// As the student's loops come by: in the order in which edges tie them.
  std::vector<const Vertex*> PosesThatSee(const Vertex& landmark) const {
    std::vector<const Vertex*> poses;
    for (const auto& edge : ordering.edges) {
      const auto& all = edge->Vertices();
      if (std::none_of(all.begin(), all.end(), [&](const auto& one) { return one.get() == &landmark; })) continue;
      for (const auto& one : all) {
        const bool is_new = std::find(poses.begin(), poses.end(), one.get()) == poses.end();
        if (one->GetRole() == Role::kPose && one->OrderingId() >= 0 && is_new) poses.push_back(one.get());
      }
    }
    return poses;
  }

  struct WrongRow {
    Text name;
    Eigen::Index row;
  };
  /// Where the rows of a pose are taken to begin by mistake, in the turn of a landmark.
  std::vector<WrongRow> WrongRowsOf(const Vertex& pose, size_t landmark) const {
    const auto& poses = ordering.poses;
    const auto is = [&](const auto& one) { return one.get() == &pose; };
    const auto i = std::find_if(poses.begin(), poses.end(), is) - poses.begin();
    return {{"7.pose_number_for_row", i},
            {"7.six_rows_each", 6 * i},
            {"7.landmark_number_for_pose", poses[std::min(landmark, poses.size() - 1)]->OrderingId()},
            {"7.first_pose_for_each", 0}};
  }

  std::vector<Text> KindsOf(const Vertex& pose) const {
    if (&pose != ordering.poses[0].get()) return {};
    return {{"7.products_of", {{"it", {"scene.pose", {{"n", Word(0)}}}}}}};
  }

  /// with(pose, landmark, turns)
  template <typename Do>
  void ForEach(const Do& with) const {
    const Text over_landmarks = "7.loop_over_landmarks", over_poses = "7.loop_over_poses";
    for (size_t l = 0; l < ordering.landmarks.size(); ++l) {
      const Vertex& landmark = *ordering.landmarks[l];
      const auto poses = PosesThatSee(landmark);
      for (size_t k = 0; k < poses.size(); ++k) {
        with(*poses[k], landmark,
             std::vector<Share::Turn>{{over_landmarks, l, ordering.landmarks.size()}, {over_poses, k, poses.size()}});
      }
    }
  }
};

Expression SchurLoop(const Sights& sights, const MatXX& H_pp) {
  const Text over_others = "7.loop_over_poses_j";
  std::vector<Share> shares{{Matrix("H_pp", H_pp), {0, 0}}};
  sights.ForEach([&](const Vertex& pose, const Vertex& landmark, std::vector<Share::Turn> turns) {
    const auto others = sights.PosesThatSee(landmark);
    for (size_t k = 0; k < others.size(); ++k) {
      const Vertex& other = *others[k];
      if (pose.OrderingId() < other.OrderingId()) continue;
      const auto of = sights.Of(pose, other, landmark);
      const Expression product = -(of.H_il * of.H_ll_inverse * Transpose(of.H_jl));
      const bool same = &pose == &other;
      std::vector<Text> kinds = sights.KindsOf(pose);
      kinds.insert(kinds.begin(), same ? "7.products_on_the_diagonal" : "7.products_off_the_diagonal");
      turns.resize(2);
      turns.push_back({over_others, k, others.size()});
      const auto add = [&](const Expression& x, const Vertex& row, const Vertex& column) {
        shares.push_back({x, {row.OrderingId(), column.OrderingId()}, {}, kinds, {}, false, turns});
      };
      add(product, pose, other);
      if (!same) add(Transpose(product), other, pose);
    }
  });
  return Assembly("S", H_pp.rows(), H_pp.cols(), shares);
}

Expression ReducedLoop(const Sights& sights, const VecX& b_p) {
  std::vector<Share> shares{{Matrix("b_p", b_p), {0, 0}}};
  sights.ForEach([&](const Vertex& pose, const Vertex& landmark, const std::vector<Share::Turn>& turns) {
    const auto of = sights.Of(pose, pose, landmark);
    std::vector<Share::Elsewhere> elsewhere;
    for (const auto& [name, row] : sights.WrongRowsOf(pose, turns[0].number)) elsewhere.push_back({name, {row, 0}});
    shares.push_back({-(of.H_il * of.H_ll_inverse * of.b_l),
                      {pose.OrderingId(), 0},
                      {},
                      sights.KindsOf(pose),
                      elsewhere,
                      false,
                      turns});
  });
  return Assembly("b_schur_", b_p.size(), 1, shares);
}

// b_l − Σ_i H_ilᵀ Δx_i of all landmarks.
Expression RestLoop(const Sights& sights, const VecX& b_l, const VecX& x_p) {
  const int first_row = sights.ordering.dim_poses;
  std::vector<Share> shares{{Matrix("b_l", b_l), {0, 0}}};
  sights.ForEach([&](const Vertex& pose, const Vertex& landmark, const std::vector<Share::Turn>& turns) {
    const auto step_at = [&, size = pose.LocalDimension()](Eigen::Index row) {
      return Matrix("Δx_i", x_p.segment(std::min(row, x_p.size() - size), size));
    };
    std::vector<Instead> others;
    for (const auto& [name, row] : sights.WrongRowsOf(pose, turns[0].number)) others.emplace_back(step_at(row), name);
    const Expression H_il = Matrix("H_il", sights.Block(sights.damped, pose, landmark)),
                     step = MistakenFor(step_at(pose.OrderingId()), others);
    shares.push_back({-(Transpose(H_il) * step), {landmark.OrderingId() - first_row, 0}, {}, {}, {}, false, turns});
  });
  return Assembly("rest", b_l.size(), 1, shares);
}

}  // namespace

BlockSolve::BlockSolve(const System& system, const Ordering& ordering, double lambda, Damping damping) {
  const int p = ordering.dim_poses, m = ordering.Size() - p;
  const MatXX damped = Damped(system.H, lambda, damping);
  const std::vector<Part> parts = PartsOf(ordering, true);
  const std::vector<int> sizes = SizesOf(ordering.landmarks);
  const Source H("H", damped, {{"7.without_lambda", system.H}}, parts), rhs("b_", system.b, {}, parts);

  const Expression H_pp = H.Block("H_pp", 0, 0, p, p), H_pl = H.Block("H_pl", 0, p, p, m),
                   H_lp = H.Block("H_plᵀ", p, 0, m, p), H_ll = H.Block("H_ll", p, p, m, m),
                   b_p = rhs.Segment("b_p", 0, p), b_l = rhs.Segment("b_l", p, m);
  const Sights sights{damped, system.H, system.b, ordering};
  S = {H_pp - H_pl * Inverse(H_ll, sizes) * H_lp, {}, {SchurLoop(sights, Value(H_pp))}};
  b_S = {b_p - H_pl * Inverse(H_ll, sizes) * b_l, {}, {ReducedLoop(sights, Value(b_p))}};
  S.rows = b_S.rows = {parts.begin(), parts.begin() + static_cast<ptrdiff_t>(ordering.poses.size())};

  const Expression x_p = Matrix("Δx_p", Solve(Value(S.right), Value(b_S.right)));
  const Expression K_transposed = Named(Inverse(H_ll, sizes) * H_lp, "K_ilᵀ");
  delta_x = {Stack({x_p, Inverse(H_ll, sizes) * (b_l - H_lp * x_p)}),
             {b_p, Named(b_S.right, "b_schur_"), K_transposed},
             {Stack({x_p, Inverse(H_ll, sizes) * RestLoop(sights, Value(b_l), Value(x_p))})}};
}

}  // namespace ch5::homework::right
