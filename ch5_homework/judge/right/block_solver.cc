/// Stage 7.

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
  bool Sees(const Vertex& pose, const Vertex& landmark) const { return !Block(damped, pose, landmark).isZero(0.0); }

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

  /// with(i, pose, l, landmark)
  template <typename Do>
  void ForEach(const Do& with) const {
    for (size_t l = 0; l < ordering.landmarks.size(); ++l) {
      for (size_t i = 0; i < ordering.poses.size(); ++i) {
        const Vertex &pose = *ordering.poses[i], &landmark = *ordering.landmarks[l];
        if (Sees(pose, landmark)) with(i, pose, l, landmark);
      }
    }
  }
};

std::vector<Text> NumberZero(size_t i, size_t l) {
  std::vector<Text> kinds;
  if (i == 0) kinds.push_back({"7.products_of", {{"it", {"scene.pose", {{"n", Word(0)}}}}}});
  if (l == 0) kinds.push_back({"7.products_of", {{"it", {"scene.landmark", {{"n", Word(0)}}}}}});
  return kinds;
}

Expression SchurLoop(const Sights& sights, const MatXX& H_pp) {
  std::vector<Share> shares{{Matrix("H_pp", H_pp), {0, 0}}};
  sights.ForEach([&](size_t i, const Vertex& pose, size_t l, const Vertex& landmark) {
    for (size_t j = 0; j <= i; ++j) {
      const Vertex& other = *sights.ordering.poses[j];
      if (!sights.Sees(other, landmark)) continue;
      const auto of = sights.Of(pose, other, landmark);
      const Expression product = -(of.H_il * of.H_ll_inverse * Transpose(of.H_jl));
      std::vector<Text> kinds = NumberZero(i, l);
      kinds.insert(kinds.begin(), i == j ? "7.products_on_the_diagonal" : "7.products_off_the_diagonal");
      shares.push_back({product, {pose.OrderingId(), other.OrderingId()}, {}, kinds});
      if (i != j) shares.push_back({Transpose(product), {other.OrderingId(), pose.OrderingId()}, {}, kinds});
    }
  });
  return Assembly("S", H_pp.rows(), H_pp.cols(), shares);
}

Expression ReducedLoop(const Sights& sights, const VecX& b_p) {
  std::vector<Share> shares{{Matrix("b_p", b_p), {0, 0}}};
  sights.ForEach([&](size_t i, const Vertex& pose, size_t l, const Vertex& landmark) {
    const auto of = sights.Of(pose, pose, landmark);
    const int number = static_cast<int>(i);
    shares.push_back({-(of.H_il * of.H_ll_inverse * of.b_l),
                      {pose.OrderingId(), 0},
                      {},
                      NumberZero(i, l),
                      {{"7.pose_number_for_row", {number, 0}}, {"7.six_rows_each", {6 * number, 0}}}});
  });
  return Assembly("b_schur_", b_p.size(), 1, shares);
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
             {b_p, Named(b_S.right, "b_schur_"), K_transposed}};
}

}  // namespace ch5::homework::right
