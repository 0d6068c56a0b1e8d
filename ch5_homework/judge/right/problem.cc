/// Stages 1.2 and 2.

#include "ch5_homework/judge/right/formulas.h"

#include <algorithm>
#include <numeric>
#include <tuple>

#include "ch5_backend/math/psd.h"

namespace ch5::homework::right {

SchurSolve::SchurSolve(const System& system, const Ordering& ordering, double lambda, Damping damping,
                       const VecX& got_b_S) {
  const int p = ordering.dim_poses, n = ordering.Size(), m = n - p;
  const Damping other = damping == Damping::kIdentity ? Damping::kDiagonal : Damping::kIdentity;
  const MatXX damped = Damped(system.H, lambda, damping);
  const std::vector<Part> parts = PartsOf(ordering);
  MatXX multiplied = damped;
  multiplied.diagonal() *= 1.0 + lambda;
  const Source H(
      "H", damped,
      {{"1.2.without_lambda", system.H},
       {"1.2.with_lambda_twice", 2.0 * damped - system.H},
       {"1.2.with_lambda_twice", multiplied},
       {{"1.2.with_other_damping", {{"D", Word(std::string(other == Damping::kDiagonal ? "diag(H)" : "I"))}}},
        Damped(system.H, lambda, other)}},
      parts);
  const Source rhs("b_", system.b, {}, parts);

  const Expression H_pp = H.Block("H_pp", 0, 0, p, p, "1.2b"), H_pm = H.Block("H_pm", 0, p, p, m, "1.2a"),
                   H_mp = H.Block("H_mp", p, 0, m, p, "1.2a"), H_mm = H.Block("H_mm", p, p, m, m, "1.2a"),
                   b_p = rhs.Segment("b_p", 0, p, "1.2a"), b_m = rhs.Segment("b_m", p, m, "1.2a");
  const Expression H_mm_inverse = WrittenAt("1.2d 1.2b", Inverse(H_mm, SizesOf(ordering.landmarks)));
  const Expression tempH = Named(H_pm * H_mm_inverse, "tempH");

  b_S = {WrittenAt("1.2b", b_p - H_pm * H_mm_inverse * b_m), {H_mp}};
  const Expression read_H_pm = Equal(got_b_S, Value(b_S.right), 1e-9) ? Matrix("H_pm", Value(H_pm), "1.2a") : H_pm;
  S = {WrittenAt("1.2b", H_pp - read_H_pm * H_mm_inverse * H_mp), {tempH, b_p}};
  S.rows = b_S.rows = {parts.begin(), parts.begin() + static_cast<ptrdiff_t>(ordering.poses.size())};

  const Expression x_p = Matrix("Δx_p", Solve(Value(S.right), Value(b_S.right)));
  const auto here = [](const Expression& x) { return WrittenAt("1.2c", x); };  // the blocks' numbers were right in S
  const Expression of_landmarks =
      here(Inverse(here(H_mm), SizesOf(ordering.landmarks)) * (here(b_m) - here(H_mp) * x_p));
  const Expression dense = Inverse(H.Block("H", 0, 0, n, n, "1.2a")) * rhs.Segment("b_", 0, n, "1.2b");
  delta_x = {Stack({x_p, of_landmarks}), {b_p, Named(b_S.right, "b_pp_schur_"), H_pm, tempH, H_pp}, {dense}};
}

namespace {

/// What `order` makes of rows, as a matrix.
Expression Picked(const Order& order) {
  const auto n = static_cast<Eigen::Index>(order.size());
  MatXX P = MatXX::Zero(n, n);
  for (Eigen::Index k = 0; k < n; ++k) P(k, order[static_cast<size_t>(k)]) = 1.0;
  return Matrix("P", P);
}

Order AsGiven(int n) {
  Order order(static_cast<size_t>(n));
  std::iota(order.begin(), order.end(), 0);
  return order;
}

/// What comes of rows that are added to, or subtracted from, what stands where they land, or land with the other sign.
std::vector<Instead> WrongSigns(const Order& right, int idx, int dim, const Text& rows) {
  const int n = static_cast<int>(right.size()), tail = n - idx - dim;
  std::vector<Instead> wrong;
  for (const auto& [first, count] : {std::pair{idx, tail}, {n - dim, dim}, {idx, tail + dim}}) {
    for (const auto& [cause, sign, kept] : {std::tuple{"2.added_to_what_stands_there", 1.0, 1.0},
                                            {"2.subtracted_from_what_stands_there", -1.0, 1.0},
                                            {"2.moved_with_other_sign", -1.0, 0.0},
                                            {"2.zero_there", 0.0, 0.0}}) {
      MatXX P = Value(Picked(right));
      P.middleRows(first, count) *= sign;
      P.middleRows(first, count) += kept * MatXX::Identity(n, n).middleRows(first, count);
      wrong.emplace_back(Matrix("P", P), Text(cause, {{"rows", rows}}));
    }
  }
  return wrong;
}

/// Where rows may land by mistake: `rows` is what moves, "2.rows", "2.columns" or "2.entries_b".
/// @param other  the order of the other way to move them
std::vector<Instead> WrongOrders(const Order& right, const Order& other, int idx, int dim, const Text& rows) {
  const int n = static_cast<int>(right.size()), tail = n - idx - dim;
  const Order given = AsGiven(n);
  const auto placed = [n](Order order, int at, int first, int count) {  // rows first, first + 1, … land at `at`
    for (int k = 0; k < count && at + count <= n; ++k) order[static_cast<size_t>(at + k)] = first + k;
    return order;
  };
  std::vector<Instead> wrong;
  const auto add = [&](const char* cause, const Order& order) {
    wrong.emplace_back(Picked(order), Text(cause, {{"rows", rows}}));
  };
  add("2.not_moved", given);
  add("2.moved_the_other_way", other);
  Order front = right, backwards = right, neighbor = given, one_by_one = given;
  std::rotate(front.begin(), front.end() - dim, front.end());
  std::rotate(neighbor.begin() + idx, neighbor.begin() + idx + dim, neighbor.begin() + idx + dim + std::min(dim, tail));
  std::reverse(backwards.end() - dim, backwards.end());
  for (auto from = one_by_one.begin() + idx; from != one_by_one.begin() + idx + dim; ++from) {
    std::rotate(from, from + 1, one_by_one.end());  // though the rows behind move up each time
  }
  add("2.variable_moved_front", front);
  add("2.swapped_with_neighbor", neighbor);
  add("2.one_by_one", one_by_one);
  add("2.reverse_order", backwards);
  const Order up = placed(given, idx, idx + dim, tail);  // the others alone move up
  add("2.variable_lost", up);
  add("2.others_not_moved_up", placed(given, n - dim, idx, dim));
  add("2.lands_at_idx_plus_dim", placed(up, idx + dim, idx, dim));
  add("2.written_over_first", placed(up, 0, idx, dim));
  for (int at = n - dim; at < n; ++at) add("2.first_alone", placed(up, at, idx, 1));
  Order first_exchanged = given;
  std::swap(first_exchanged[static_cast<size_t>(idx)], first_exchanged.back());
  add("2.first_alone", first_exchanged);
  Order overwritten = up;
  std::copy_n(up.begin() + idx, dim, overwritten.end() - dim);
  add("2.read_after_overwriting", overwritten);
  const std::vector<Instead> of_signs = WrongSigns(right, idx, dim, rows);
  wrong.insert(wrong.end(), of_signs.begin(), of_signs.end());
  return wrong;
}

Order OrderOf(int n, int idx, int dim, bool exchanging) {
  Order order = AsGiven(n);
  const auto begin = order.begin() + idx;
  if (exchanging) {
    for (int k = dim - 1; k >= 0; --k) std::swap(begin[k], order[static_cast<size_t>(n - dim + k)]);
  } else {
    std::rotate(begin, begin + dim, order.end());
  }
  return order;
}

}  // namespace

Moved::Moved(const System& given, int idx, int dim, bool exchanging)
    : order(OrderOf(static_cast<int>(given.b.size()), idx, dim, exchanging)) {
  const Order other = OrderOf(static_cast<int>(given.b.size()), idx, dim, !exchanging);
  const Expression H_given = Matrix("H", given.H), b_given = Matrix("b", given.b), P = Picked(order);
  const auto moved = [&](const Text& what) { return MistakenFor(P, WrongOrders(order, other, idx, dim, what)); };
  std::vector<Instead> both;
  for (const Instead& wrong : WrongOrders(order, other, idx, dim, "2.rows")) {
    both.emplace_back(wrong.x * H_given * Transpose(wrong.x), wrong.cause);
  }
  MatXX before_moved = given.H * Value(P).transpose();
  before_moved.leftCols(idx) = (Value(P) * given.H).leftCols(idx);
  both.emplace_back(Matrix("H_marg", before_moved), "2.columns_before_rows_moved");
  H.listed_alone = b.listed_alone = true;  // students move blocks, and know no P
  H.right =
      MistakenFor(WrittenAt("2a", moved("2.rows") * H_given * WrittenAt("2b", Transpose(moved("2.columns")))), both);
  b.right = WrittenAt("2a", moved("2.entries_b") * b_given);
}

Prior::Prior(const System& moved, const System& given, int dim) {
  const Eigen::Index m = dim, n = moved.H.rows() - m;
  const Source H_marg("H_marg", moved.H, {{"2.before_the_move", given.H}});
  const Source b_marg("b_marg", moved.b, {{"2.before_the_move", given.b}});

  const Expression A_rr = H_marg.Block("A_rr", 0, 0, n, n, "2c"), A_rm = H_marg.Block("A_rm", 0, n, n, m, "2c"),
                   A_mr = H_marg.Block("A_mr", n, 0, m, n, "2c"), A_mm = H_marg.Block("A_mm", n, n, m, m, "2e 2d"),
                   b_r = b_marg.Segment("b_r", 0, n), b_m = b_marg.Segment("b_m", n, m);
  const Expression A_mm_inverse = WrittenAt("2e 2d", Inverse(A_mm));
  const Expression tempB = Named(A_rm * A_mm_inverse, "tempB");

  H = {A_rr - A_rm * A_mm_inverse * A_mr,
       {tempB, Matrix("H_marg", moved.H), Matrix("(H⁻¹)_rr", PseudoInversePsd(moved.H).topLeftCorner(n, n))}};
  const auto here = [](const Expression& x) { return WrittenAt("2d", x); };  // A_rm was right in H_prior
  b = {here(b_r - here(A_rm) * A_mm_inverse * b_m), {tempB, Matrix("b_marg", moved.b)}};
  b.beside.push_back(Named(Inverse(Named(H.right, "H_prior")) * b.right, "H_prior⁻¹ b_prior"));
}

}  // namespace ch5::homework::right
