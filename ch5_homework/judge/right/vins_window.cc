/// Stage 6.

#include "ch5_homework/judge/right/formulas.h"

#include "ch5_backend/marginalize/square_root.h"

namespace ch5::homework::right {

namespace {

constexpr double kEps = 1e-8;  // eigenvalues up to it count as zero

Expression Diagonal(const char* name, const VecX& entries) { return Matrix(name, entries.asDiagonal()); }

/// A = V S Vᵀ, and S⁺.
struct CutEigen {
  MatXX V;
  VecX S, S_pinv, one_for_zero;

  explicit CutEigen(const MatXX& A) {
    const SymmetricEigen eigen = DecomposeSymmetric(A);
    const auto counts = eigen.S.array() > kEps;
    V = eigen.V;
    S = counts.select(eigen.S, 0.0);
    S_pinv = counts.select(eigen.S.cwiseInverse(), 0.0);
    one_for_zero = counts.select(eigen.S.cwiseInverse(), 1.0);
  }
};

// ---- 6b: the two loops that give each block its first row -----------------------------------------------------------

enum Blocks { kDropped, kKept, kAll, kNone };

/// One of the loops, by its statements.
struct Loop {
  Blocks takes;                 ///< all others are skipped
  double m_in_idx, n_in_idx;    ///< idx = m_in_idx · m_ + n_in_idx · n_
  double to_m, to_n;            ///< m_ += to_m · rows, n_ += to_n · rows
  bool assigns = false;         ///< = for +=
  bool counts_first = false;    ///< idx is set after the counts
  bool ends_at_others = false;  ///< break for continue
};
constexpr Loop kOverDropped{kDropped, 1, 0, 1, 0}, kOverKept{kKept, 1, 1, 0, 1};

/// How often each block's rows are counted in each first row, and in m_ and n_, which are the last rows.
class Counts {
 public:
  explicit Counts(const std::vector<bool>& dropped) : dropped_(dropped) {}

  /// One loop after the other, or the statements of both in one.
  MatXX Of(const Loop& first, const Loop& second, bool in_one = false) const {
    MatXX counts = MatXX::Zero(Size() + 2, Size());
    for (const Loop& loop : {first, second}) {
      for (Eigen::Index k = 0; k < Size() && !in_one && !(loop.ends_at_others && !Takes(loop, k)); ++k) {
        Turn(loop, k, &counts);
      }
    }
    for (Eigen::Index k = 0; k < Size() && in_one; ++k) {
      for (const Loop& loop : {first, second}) Turn(loop, k, &counts);
    }
    return counts;
  }

 private:
  Eigen::Index Size() const { return static_cast<Eigen::Index>(dropped_.size()); }
  bool Takes(const Loop& loop, Eigen::Index k) const {
    return loop.takes == kAll || loop.takes == (dropped_[static_cast<size_t>(k)] ? kDropped : kKept);
  }
  void Turn(const Loop& loop, Eigen::Index k, MatXX* counts) const {
    if (!Takes(loop, k)) return;
    auto m = counts->row(Size()), n = counts->row(Size() + 1);
    const auto set_idx = [&] { counts->row(k) = loop.m_in_idx * m + loop.n_in_idx * n; };
    if (!loop.counts_first) set_idx();
    if (loop.assigns) (loop.to_m != 0.0 ? m : n).setZero();
    m[k] += loop.to_m;
    n[k] += loop.to_n;
    if (loop.counts_first) set_idx();
  }

  std::vector<bool> dropped_;
};

/// "m_ − n_"
std::string Combination(double m, double n) {
  const Expression x = Matrix("m_", MatXX::Zero(1, 1)), y = Matrix("n_", MatXX::Zero(1, 1));
  if (m == 0.0 && n == 0.0) return "0";
  return NameOf(m == 0.0 ? Sum({y}, {n}) : n == 0.0 ? Sum({x}, {m}) : Sum({x, y}, {m, n}));
}

/// One statement changed in one of the loops.
void ChangeOneLoop(const Counts& c, bool kept, std::vector<Instead>* wrong) {
  const Loop right = kept ? kOverKept : kOverDropped;
  const Text loop = kept ? "6.loop_over_kept" : "6.loop_over_dropped";
  const auto add = [&](const Text& cause, const Loop& changed) {
    wrong->emplace_back(Matrix("counts", kept ? c.Of(kOverDropped, changed) : c.Of(changed, kOverKept)), cause);
  };
  for (const Blocks takes : {kNone, kept ? kDropped : kKept}) {
    Loop changed = right;
    changed.takes = takes;
    add({takes == kNone ? "6.loop_numbers_nothing" : "6.loop_takes_the_others", {{"loop", loop}}}, changed);
  }
  Loop ended = right;
  ended.ends_at_others = true;
  add({"6.loop_ends_at_others", {{"loop", loop}}}, ended);
  for (int m = -2; m <= 2; ++m) {
    for (int n = -2; n <= 2; ++n) {
      const Text it = Word(Combination(m, n));
      Loop changed = right;
      changed.m_in_idx = m, changed.n_in_idx = n;
      if (kept || n == 0) add({"6.idx_is", {{"loop", loop}, {"this", it}}}, changed);  // before, n_ is 0
      changed = right;
      changed.to_m = m, changed.to_n = n;
      add({"6.rows_counted_as", {{"loop", loop}, {"this", it}}}, changed);
    }
  }
}

std::vector<Instead> WrongCounts(const Counts& c) {
  std::vector<Instead> wrong;
  const auto add = [&](const Text& cause, const MatXX& counts) { wrong.emplace_back(Matrix("counts", counts), cause); };
  const auto second = [&](const char* cause, const Loop& loop) { add(cause, c.Of(kOverDropped, loop)); };
  add("6.one_loop_for_both", c.Of({kDropped, 1, 1, 1, 0}, kOverKept, true));
  add("6.one_loop_for_both", c.Of(kOverDropped, kOverKept, true));
  second("6.numbered_in_both_loops", {kAll, 1, 1, 0, 1});
  add("6.numbered_in_both_loops", c.Of({kAll, 1, 0, 1, 0}, kOverKept));
  second("6.every_kept_block_begins_m", {kKept, 1, 0, 0, 1});
  second("6.kept_begin_at_zero", {kKept, 0, 1, 0, 1});
  second("6.kept_rows_counted_in_m", {kKept, 1, 1, 1, 0});
  for (const auto& [of_dropped, of_kept] : {std::pair{true, true}, {true, false}, {false, true}}) {
    Loop first = kOverDropped, last = kOverKept;
    first.counts_first = of_dropped, last.counts_first = of_kept;
    add("6.idx_set_after_count_moved", c.Of(first, last));
    first = kOverDropped, last = kOverKept;
    first.assigns = of_dropped, last.assigns = of_kept;
    const char* const it = of_dropped && of_kept ? "m_, n_" : of_dropped ? "m_" : "n_";
    add({"6.count_assigned", {{"it", Word(std::string(it))}}}, c.Of(first, last));
  }
  add("6.kept_first_m_n_exchanged", c.Of({kKept, 1, 0, 1, 0}, {kDropped, 1, 1, 0, 1}));
  add("6.kept_first", c.Of({kKept, 0, 1, 0, 1}, {kDropped, 1, 1, 1, 0}));
  for (const bool kept : {false, true}) ChangeOneLoop(c, kept, &wrong);
  return wrong;
}

}  // namespace

Numbering::Numbering(const VecX& sizes, const VecX& parameters, const std::vector<bool>& dropped) {
  const Counts counts(dropped);
  const VecX one = VecX::Ones(sizes.size());
  VecX drops = one;
  for (size_t k = 0; k < dropped.size(); ++k) drops[static_cast<Eigen::Index>(k)] = dropped[k];
  const Expression all = Matrix("counts", counts.Of(kOverDropped, kOverKept));
  std::vector<Instead> wrong_sizes, shifted;
  const Text parameters_for_size = "6.parameters_size_for_local_dimension", off_by_one = "6.off_by_one";
  for (const VecX& which : {one, drops, VecX(one - drops)}) {
    const auto add = [&](const Text& cause, const VecX& of) {
      wrong_sizes.emplace_back(Matrix("sizes", sizes + which.cwiseProduct(of - sizes)), cause);
    };
    for (const int n : {1, 6}) add({"6.block_counts", {{"n", Word(n)}}}, n * one);
    add(parameters_for_size, parameters);
    for (const double more : {1.0, -1.0}) {
      add(off_by_one, sizes + more * one);
      VecX rows = Value(all) * sizes;
      rows.head(sizes.size()) += more * which;
      shifted.emplace_back(Matrix("rows", rows), off_by_one);
    }
  }
  rows = {
      MistakenFor(MistakenFor(all, WrongCounts(counts)) * MistakenFor(Matrix("sizes", sizes), wrong_sizes), shifted)};
}

KeptRows::KeptRows(const MatXX& A, const VecX& b, int m) {
  const Eigen::Index n = A.rows() - m;
  const Source all("A_", A), rhs("b_", b);
  const Expression A_rr = all.Block("A_rr", m, m, n, n), A_rm = all.Block("A_rm", m, 0, n, m),
                   A_mr = all.Block("A_mr", 0, m, m, n), A_mm = all.Block("A_mm", 0, 0, m, m),
                   b_r_given = rhs.Segment("b_r", m, n), b_m = rhs.Segment("b_m", 0, m);
  const CutEigen mm(Value(A_mm));
  std::vector<Instead> cuts{{Diagonal("S⁺", mm.one_for_zero), "6.one_for_zero"}};
  for (const double limit : mm.S) {
    const VecX left = (mm.S.array() > limit).select(mm.S_pinv, 0.0);
    cuts.emplace_back(Diagonal("S⁺", left),
                      Text("formula.known_direction_cut", {{"matrix", Word(std::string("A_mm"))}}));
  }
  const Expression V = Matrix("V", mm.V), S_pinv = MistakenFor(Diagonal("S⁺", mm.S_pinv), cuts),
                   A_mm_pinv = Named(V * S_pinv * Transpose(V), "A_mm⁺");

  A_r = {A_rr - A_rm * A_mm_pinv * A_mr, {A_mm, Matrix("A_", A)}};
  b_r = {b_r_given - A_rm * A_mm_pinv * b_m, {A_mm, Matrix("b_", b)}};
  if ((mm.S.array() == 0.0).any()) return;  // there A_mm⁻¹ is another matrix
  A_r.as_well = {A_rr - A_rm * Inverse(A_mm) * A_mr};
  b_r.as_well = {b_r_given - A_rm * Inverse(A_mm) * b_m};
}

Factored::Factored(const MatXX& A, const VecX& b) {
  const CutEigen eigen(A);
  eigenvalues = eigen.S;
  const Expression V = Matrix("V", eigen.V), S_sqrt = Diagonal("S^½", eigen.S.cwiseSqrt()),
                   S_pinv_sqrt = Diagonal("S^-½", eigen.S_pinv.cwiseSqrt()), A_r = Matrix("A_r", A),
                   S = Diagonal("S", eigen.S), J = Named(S_sqrt * Transpose(V), "J");
  const MatXX Jt = Value(J).transpose();
  r0 = Value(S_pinv_sqrt * Transpose(V) * Matrix("b_r", b));

  JtJ = {Seen(J, [](const MatXX& any) { return MatXX(any.transpose() * any); }),
         {S, S_pinv_sqrt, A_r, Diagonal("S^¼", eigen.S.array().pow(0.25))}};
  Jtr0 = {Seen(S_pinv_sqrt * Transpose(V) * Matrix("b_r", b),
               [Jt](const MatXX& r0) { return r0.rows() == Jt.cols() ? MatXX(Jt * r0) : MatXX(); }),
          {S_sqrt, S, Diagonal("S⁻¹", eigen.S_pinv), Diagonal("S^-¼", eigen.S_pinv.array().pow(0.25)), J}};
}

}  // namespace ch5::homework::right
