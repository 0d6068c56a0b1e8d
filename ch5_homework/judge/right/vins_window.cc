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
  VecX S, S_pinv;

  explicit CutEigen(const MatXX& A) {
    const SymmetricEigen eigen = DecomposeSymmetric(A);
    const auto counts = eigen.S.array() > kEps;
    V = eigen.V;
    S = counts.select(eigen.S, 0.0);
    S_pinv = counts.select(eigen.S.cwiseInverse(), 0.0);
  }
};

/// Which blocks count where, as a matrix of numbers of times.
class Counts {
 public:
  explicit Counts(const std::vector<bool>& dropped) : dropped_(dropped), blocks_(static_cast<int>(dropped.size())) {}

  bool Drops(int l) const { return dropped_[static_cast<size_t>(l)]; }
  bool Before(int k, int l) const { return Drops(l) == Drops(k) ? l < k : Drops(l); }
  /// The last one of these that comes before k.
  bool IsLast(int k, int l, bool dropped) const {
    for (int other = l + 1; other < k; ++other) {
      if (Drops(other) == dropped) return false;
    }
    return l < k && Drops(l) == dropped;
  }

  /// @param in_row  how often block l counts in the first row of block k;  @param in_m, in_n  in m and n
  template <typename InRow, typename InM, typename InN>
  MatXX Of(const InRow& in_row, const InM& in_m, const InN& in_n) const {
    MatXX counts(blocks_ + 2, blocks_);
    for (int l = 0; l < blocks_; ++l) {
      for (int k = 0; k < blocks_; ++k) counts(k, l) = in_row(k, l);
      counts(blocks_, l) = in_m(l);
      counts(blocks_ + 1, l) = in_n(l);
    }
    return counts;
  }
  template <typename InRow>
  MatXX Of(const InRow& in_row) const {
    return Of(
        in_row, [this](int l) { return Drops(l); }, [this](int l) { return !Drops(l); });
  }
  MatXX Right() const {
    return Of([this](int k, int l) { return Before(k, l); });
  }
  /// m or n is set to the rows of a block, not raised by them.
  MatXX Assigned(bool m, bool n) const {
    const auto in_m = [=](int k, int l) { return m ? IsLast(k, l, true) : Drops(l) && l < k; };
    const auto in_n = [=](int k, int l) { return n ? IsLast(k, l, false) : !Drops(l) && l < k; };
    return Of([&](int k, int l) { return Drops(k) ? in_m(k, l) : in_m(blocks_, l) || in_n(k, l); },
              [&](int l) { return in_m(blocks_, l); }, [&](int l) { return in_n(blocks_, l); });
  }

 private:
  std::vector<bool> dropped_;
  int blocks_;
};

std::vector<Instead> WrongCounts(const Counts& c, const std::vector<bool>& dropped) {
  const auto all = [](int) { return 1.0; };
  const auto none = [](int) { return 0.0; };
  const auto drops = [&](int l) { return c.Drops(l); };
  const auto stays = [&](int l) { return !c.Drops(l); };
  std::vector<Instead> wrong;
  const auto add = [&](const Text& cause, const MatXX& counts) { wrong.emplace_back(Matrix("counts", counts), cause); };
  add("6.one_loop_for_both", c.Of([](int k, int l) { return l < k; }));
  add("6.one_loop_for_both", c.Of([&](int k, int l) { return l < k && (!c.Drops(k) || c.Drops(l)); }));
  add("6.numbered_in_both_loops", c.Of([&](int k, int l) { return c.Drops(l) + (l < k); }, drops, all));
  add("6.numbered_in_both_loops",
      c.Of([&](int k, int l) { return c.Drops(k) ? l < k : 1 + (l < k && !c.Drops(l)); }, all, stays));
  add("6.every_kept_block_begins_m", c.Of([&](int k, int l) { return c.Drops(l) && (l < k || !c.Drops(k)); }));
  add("6.kept_begin_at_zero", c.Of([&](int k, int l) { return l < k && c.Drops(l) == c.Drops(k); }));
  add("6.kept_rows_counted_in_m", c.Of([&](int k, int l) { return c.Before(k, l); }, all, none));
  for (const auto& [of_dropped, of_kept] : {std::pair{true, true}, {true, false}, {false, true}}) {
    add("6.idx_set_after_count_moved", c.Of([&, d = of_dropped, s = of_kept](int k, int l) {
      return c.Before(k, l) + (k == l && (c.Drops(k) ? d : s));
    }));
    const char* const it = of_dropped && of_kept ? "m_, n_" : of_dropped ? "m_" : "n_";
    add({"6.count_assigned", {{"it", Word(std::string(it))}}}, c.Assigned(of_dropped, of_kept));
  }
  std::vector<bool> kept = dropped;
  kept.flip();
  const Counts exchanged(kept);
  add("6.kept_first_m_n_exchanged", exchanged.Right());
  add("6.kept_first", exchanged.Of([&](int k, int l) { return exchanged.Before(k, l); }, drops, stays));
  return wrong;
}

}  // namespace

Numbering::Numbering(const VecX& sizes, const VecX& parameters, const std::vector<bool>& dropped) {
  const Counts counts(dropped);
  const VecX one = VecX::Ones(sizes.size());
  VecX drops = one;
  for (size_t k = 0; k < dropped.size(); ++k) drops[static_cast<Eigen::Index>(k)] = dropped[k];
  const Expression all = Matrix("counts", counts.Right());
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
  rows = {MistakenFor(MistakenFor(all, WrongCounts(counts, dropped)) * MistakenFor(Matrix("sizes", sizes), wrong_sizes),
                      shifted)};
}

KeptRows::KeptRows(const MatXX& A, const VecX& b, int m) {
  const Eigen::Index n = A.rows() - m;
  const Source all("A_", A), rhs("b_", b);
  const Expression A_rr = all.Block("A_rr", m, m, n, n), A_rm = all.Block("A_rm", m, 0, n, m),
                   A_mr = all.Block("A_mr", 0, m, m, n), A_mm = all.Block("A_mm", 0, 0, m, m),
                   b_r_given = rhs.Segment("b_r", m, n), b_m = rhs.Segment("b_m", 0, m);
  const CutEigen mm(Value(A_mm));
  const Expression V = Matrix("V", mm.V), A_mm_pinv = Named(V * Diagonal("S⁺", mm.S_pinv) * Transpose(V), "A_mm⁺");

  A_r = {A_rr - A_rm * A_mm_pinv * A_mr, {A_mm, Matrix("A_", A)}};
  b_r = {b_r_given - A_rm * A_mm_pinv * b_m, {A_mm, Matrix("b_", b)}};
  if ((mm.S.array() == 0.0).any()) return;  // there A_mm⁻¹ is another matrix
  A_r.as_well = {A_rr - A_rm * Inverse(A_mm) * A_mr};
  b_r.as_well = {b_r_given - A_rm * Inverse(A_mm) * b_m};
}

Factored::Factored(const MatXX& A, const VecX& b) {
  const CutEigen eigen(A);
  eigenvalues = eigen.S;
  cost = b.dot(eigen.V * eigen.S_pinv.asDiagonal() * eigen.V.transpose() * b);
  const Expression V = Matrix("V", eigen.V), S_sqrt = Diagonal("S^½", eigen.S.cwiseSqrt()),
                   S_pinv_sqrt = Diagonal("S^-½", eigen.S_pinv.cwiseSqrt()), A_r = Matrix("A_r", A),
                   S = Diagonal("S", eigen.S), J = Named(S_sqrt * Transpose(V), "J");
  const MatXX Jt = Value(J).transpose();

  JtJ = {Seen(J, [](const MatXX& any) { return MatXX(any.transpose() * any); }),
         {S, S_pinv_sqrt, A_r, Diagonal("S^¼", eigen.S.array().pow(0.25))}};
  Jtr0 = {Seen(S_pinv_sqrt * Transpose(V) * Matrix("b_r", b),
               [Jt](const MatXX& r0) { return r0.rows() == Jt.cols() ? MatXX(Jt * r0) : MatXX(); }),
          {S_sqrt, S, Diagonal("S⁻¹", eigen.S_pinv), Diagonal("S^-¼", eigen.S_pinv.array().pow(0.25)), J}};
}

}  // namespace ch5::homework::right
