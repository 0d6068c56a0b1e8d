#pragma once
/// Correct and incorrect ways to assemble H and b in a loop over the pairs of an edge's vertices: stages 1.1, 6 and 7.

#include <algorithm>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "ch5_backend/math/psd.h"
#include "ch5_homework/judge/diagnosis.h"
#include "ch5_homework/judge/mistakes/formula.h"
#include "ch5_homework/judge/scenes/scene.h"

namespace ch5::homework {

/// One turn of the inner loop: the vertices i and j ≥ i of an edge, both free.
struct Turn {
  const Edge& edge;
  double drho;  ///< ρ'
  const MatXX& W_rho;
  size_t at_i, at_j;  ///< their numbers in the edge's list
  int i, j;           ///< where they begin in H and b

  const Vertex& v_i() const { return *edge.Vertices()[at_i]; }
  const Vertex& v_j() const { return *edge.Vertices()[at_j]; }
  bool IsDiagonal() const { return at_i == at_j; }
  MatXX Block(const MatXX& W) const { return edge.Jacobian(at_i).transpose() * W * edge.Jacobian(at_j); }
  MatXX Block() const { return Block(W_rho); }
};

inline int OrderedRow(const Edge& edge, size_t k) { return edge.Vertices()[k]->OrderingId(); }

/// What the code does at a fixed vertex: continue (correct), break, or return.
enum class Ends { kTurn, kLoop, kFunction };

struct Loop {
  const EdgeList& edges;
  int size;
  std::function<int(const Edge& edge, size_t k)> row_of = &OrderedRow;  ///< where the edge's vertex k begins
  Ends at_fixed_i = Ends::kTurn, at_fixed_j = Ends::kTurn;
};

/// All early exits at a fixed vertex.
inline std::vector<Loop> EndedByFixed(Loop loop) {
  std::vector<Loop> loops;
  for (const auto& [at_i, at_j] : {std::pair{Ends::kTurn, Ends::kLoop},
                                   {Ends::kTurn, Ends::kFunction},
                                   {Ends::kLoop, Ends::kTurn},
                                   {Ends::kFunction, Ends::kTurn},
                                   {Ends::kLoop, Ends::kLoop},
                                   {Ends::kFunction, Ends::kFunction}}) {
    loop.at_fixed_i = at_i;
    loop.at_fixed_j = at_j;
    loops.push_back(loop);
  }
  return loops;
}

template <typename Do>
void ForEachTurn(const Loop& loop, const Do& with) {
  for (const auto& edge : loop.edges) {
    double drho;
    MatXX W_rho;
    edge->RobustInfo(&drho, &W_rho);
    const auto& vertices = edge->Vertices();
    for (size_t i = 0; i < vertices.size(); ++i) {
      if (vertices[i]->IsFixed()) {
        if (loop.at_fixed_i == Ends::kFunction) return;
        if (loop.at_fixed_i == Ends::kLoop) break;
        continue;
      }
      for (size_t j = i; j < vertices.size(); ++j) {
        if (vertices[j]->IsFixed()) {
          if (loop.at_fixed_j == Ends::kFunction) return;
          if (loop.at_fixed_j == Ends::kLoop) break;
          continue;
        }
        with(Turn{*edge, drho, W_rho, i, j, loop.row_of(*edge, i), loop.row_of(*edge, j)});
      }
    }
  }
}

// ---- what may stand between two Jacobians, or before the residual ----------------------------------------------------

using Weight = MatXX (*)(const Turn& t);

inline MatXX WRho(const Turn& t) { return t.W_rho; }
inline MatXX W(const Turn& t) { return t.edge.Information(); }
inline MatXX RhoW(const Turn& t) { return t.drho * W(t); }
inline MatXX RhoRhoW(const Turn& t) { return t.drho * RhoW(t); }
inline MatXX RhoWRho(const Turn& t) { return t.drho * t.W_rho; }
inline MatXX RhoWW(const Turn& t) { return RhoW(t) * W(t); }
inline MatXX Covariance(const Turn& t) { return t.W_rho.inverse(); }
inline MatXX DiagonalOfWRho(const Turn& t) { return t.W_rho.diagonal().asDiagonal(); }
inline MatXX WRhoWRho(const Turn& t) { return t.W_rho * t.W_rho; }
inline MatXX RootL(const Turn& t) { return t.W_rho.llt().matrixL(); }  // W_ρ = L Lᵀ
inline MatXX RootLt(const Turn& t) { return t.W_rho.llt().matrixU(); }
inline MatXX NoWeight(const Turn& t) { return MatXX::Identity(t.W_rho.rows(), t.W_rho.cols()); }
inline MatXX RhoAlone(const Turn& t) { return t.drho * NoWeight(t); }

// ---- H ---------------------------------------------------------------------------------------------------------------

/// What a turn of the loop does to H.
using Turning = std::function<void(MatXX* H, const Turn& t)>;

inline MatXX AssembleH(const Loop& loop, const Turning& turning) {
  MatXX H = MatXX::Zero(loop.size, loop.size);
  ForEachTurn(loop, [&](const Turn& t) { turning(&H, t); });
  return H;
}

// A block that would not fit (there, Eigen's assertion ends the student's run) is left out.
inline void Put(MatXX* H, int row, int column, const MatXX& block, bool assigned = false) {
  if (row + block.rows() > H->rows() || column + block.cols() > H->cols()) return;
  auto place = H->block(row, column, block.rows(), block.cols());
  place = assigned ? block : MatXX(place + block);
}

using Place = std::pair<int, int> (*)(const Turn& t);

inline std::pair<int, int> Rows(const Turn& t) { return {t.i, t.j}; }
inline std::pair<int, int> RowOfI(const Turn& t) { return {t.i, t.i}; }
inline std::pair<int, int> NumbersInEdge(const Turn& t) { return {static_cast<int>(t.at_i), static_cast<int>(t.at_j)}; }
inline std::pair<int, int> NumbersTimesSizes(const Turn& t) {
  return {static_cast<int>(t.at_i) * t.v_i().LocalDimension(), static_cast<int>(t.at_j) * t.v_j().LocalDimension()};
}
inline std::pair<int, int> Ids(const Turn& t) {
  return {t.v_i().Id() * t.v_i().LocalDimension(), t.v_j().Id() * t.v_j().LocalDimension()};
}

/// A statement of the loop: += of the block, or at the mirrored place of its transpose.
struct Statement {
  bool mirrored = false;
  double times = 1.0;
  Weight weight = &WRho;
  Place place = &Rows;
  bool turned = false;    ///< the transpose of what is right there
  bool assigned = false;  ///< = for +=

  Statement Times(double n) const { return With(&Statement::times, n); }
  Statement Of(Weight other) const { return With(&Statement::weight, other); }
  Statement At(Place other) const { return With(&Statement::place, other); }
  Statement Turned() const { return With(&Statement::turned, true); }
  Statement Assigned() const { return With(&Statement::assigned, true); }

  void Run(MatXX* H, const Turn& t) const {
    const auto [row, column] = place(t);
    MatXX block = times * t.Block(weight(t));
    if (mirrored != turned) block.transposeInPlace();
    Put(H, mirrored ? column : row, mirrored ? row : column, block, assigned);
  }

 private:
  template <typename T>
  Statement With(T Statement::*member, T value) const {
    Statement changed = *this;
    changed.*member = value;
    return changed;
  }
};

const Statement kFirst{}, kMirror{true}, kNothing = kFirst.Times(0.0);

/// On a diagonal block; on another one and on its mirror image.
inline Turning Three(const Statement& diagonal, const Statement& first, const Statement& mirror) {
  return [=](MatXX* H, const Turn& t) {
    (t.IsDiagonal() ? diagonal : first).Run(H, t);
    if (!t.IsDiagonal()) mirror.Run(H, t);
  };
}
inline Turning Two(const Statement& first, const Statement& mirror) { return Three(first, first, mirror); }
inline Turning BothOf(Weight weight) { return Two(kFirst.Of(weight), kMirror.Of(weight)); }
/// J_i, or J_j, stands for both; where Eigen would not let it, each for itself.
inline Turning OneJacobian(size_t Turn::*at) {
  return [at](MatXX* H, const Turn& t) {
    const bool alike = t.v_i().LocalDimension() == t.v_j().LocalDimension();
    const MatXX J = t.edge.Jacobian(t.*at), block = alike ? MatXX(J.transpose() * t.W_rho * J) : t.Block();
    Put(H, t.i, t.j, block);
    if (!t.IsDiagonal()) Put(H, t.j, t.i, block.transpose());
  };
}
/// Skips an edge whose residual is zero.
inline void WithoutEdgesThatFit(MatXX* H, const Turn& t) {
  if (!t.edge.Residual().isZero(0.0)) Two(kFirst, kMirror)(H, t);
}
/// `hessian` is static: it keeps the first block of its size, or all blocks add up in it.
inline Turning Static(bool adds_up) {
  return [adds_up, hessian = MatXX()](MatXX* H, const Turn& t) mutable {
    const MatXX block = t.Block();
    const bool fits = hessian.rows() == block.rows() && hessian.cols() == block.cols();
    if (!fits) hessian = block;
    if (fits && adds_up) hessian += block;
    Put(H, t.i, t.j, hessian);
    if (!t.IsDiagonal()) Put(H, t.j, t.i, hessian.transpose());
  };
}
/// Leaves out the pairs for which this holds.
inline Turning Without(bool (*is_left_out)(const Turn& t)) {
  return [is_left_out](MatXX* H, const Turn& t) {
    if (!is_left_out(t)) Two(kFirst, kMirror)(H, t);
  };
}

inline bool IsWritten(const MatXX& H, const Turn& t) {
  return !H.block(t.i, t.j, t.v_i().LocalDimension(), t.v_j().LocalDimension()).isZero(0.0);
}

struct TurningMistake {
  const char* todo;
  Text cause;
  Turning turning;
};

/// @param first, mirror, block  where to read of the block (i, j), of its mirror image, and of what a pair adds
inline std::vector<TurningMistake> WrongTurnings(const char* first, const char* mirror, const char* block) {
  const Text one_triangle = "assembly.only_one_triangle", first_kept = "assembly.only_first_block_kept";
  const Text numbers = "assembly.numbers_in_edge_for_rows", assigned = "assembly.assigned";
  const Text left_out = "assembly.vertex_left_out", kept = "assembly.hessian_kept";
  const Turning both = Two(kFirst, kMirror);
  return {{mirror, "assembly.mirror_missing", Two(kFirst, kNothing)},
          {mirror, "assembly.mirror_not_transposed", Two(kFirst, kMirror.Turned())},
          {first, "assembly.hessian_transposed", Two(kFirst.Turned(), kMirror)},
          {first, assigned, Two(kFirst.Assigned(), kMirror.Assigned())},
          {first, assigned, Two(kFirst.Assigned(), kMirror)},
          {mirror, assigned, Two(kFirst, kMirror.Assigned())},
          {first, "assembly.places_exchanged", Two(kMirror.Turned(), kFirst.Turned())},
          {first, "assembly.row_column_exchanged", Two(kMirror.Turned(), kMirror)},
          {mirror, "assembly.mirror_at_same_place", Two(kFirst, kFirst.Turned())},
          {mirror, "assembly.diagonal_blocks_added_twice", Three(kFirst.Times(2.0), kFirst, kMirror)},
          {first, "assembly.blocks_subtracted", Two(kFirst.Times(-1.0), kMirror.Times(-1.0))},
          {first, "assembly.block_missing", Two(kNothing, kMirror)},
          {first, "assembly.only_diagonal_blocks_arrive", Three(kFirst, kNothing, kNothing)},
          {block, "assembly.loss_forgotten", BothOf(&W)},
          {block, "assembly.first_order_loss", BothOf(&RhoW)},
          {first, "assembly.loss_forgotten", Two(kFirst.Of(&W), kMirror)},
          {first, "assembly.first_order_loss", Two(kFirst.Of(&RhoW), kMirror)},
          {mirror, "assembly.loss_forgotten_mirrored_block", Two(kFirst, kMirror.Of(&W))},
          {first, one_triangle, [](MatXX* H, const Turn& t) { (t.i <= t.j ? kFirst : kMirror).Run(H, t); }},
          {first, one_triangle, [](MatXX* H, const Turn& t) { (t.i >= t.j ? kFirst : kMirror).Run(H, t); }},
          {mirror, "assembly.mirror_only_of_equal_sizes",
           [](MatXX* H, const Turn& t) {
             kFirst.Run(H, t);
             if (!t.IsDiagonal() && t.v_i().LocalDimension() == t.v_j().LocalDimension()) kMirror.Run(H, t);
           }},
          {mirror, "assembly.mirror_only_if_v_i_first",
           [](MatXX* H, const Turn& t) {
             kFirst.Run(H, t);
             if (t.i < t.j) kMirror.Run(H, t);
           }},
          {first, "assembly.moved_to_triangle_not_transposed",
           [](MatXX* H, const Turn& t) {
             const auto [upper, lower] = std::minmax(t.i, t.j);
             Put(H, upper, lower, t.Block());
             if (!t.IsDiagonal()) Put(H, lower, upper, t.Block().transpose());
           }},
          {first, "assembly.block_only_if_v_i_first",
           [=](MatXX* H, const Turn& t) {
             if (t.i <= t.j) both(H, t);
           }},
          {first, numbers, Two(kFirst.At(&NumbersInEdge), kMirror)},
          {first, numbers, Two(kFirst.At(&NumbersInEdge), kMirror.At(&NumbersInEdge))},
          {mirror, numbers, Two(kFirst, kMirror.At(&NumbersInEdge))},
          {first, numbers, Two(kFirst.At(&NumbersTimesSizes), kMirror.At(&NumbersTimesSizes))},
          {first, "assembly.id_for_first_row", Two(kFirst.At(&Ids), kMirror.At(&Ids))},
          {first, StandsFor("i", "j", "(i, j)"), Two(kFirst.At(&RowOfI), kMirror)},
          {first, StandsFor("i", "j", "(i, j)"), Two(kFirst.At(&RowOfI), kMirror.At(&RowOfI))},
          {first, first_kept,
           [](MatXX* H, const Turn& t) {
             if (!IsWritten(*H, t)) kFirst.Run(H, t);
             if (!t.IsDiagonal()) kMirror.Run(H, t);
           }},
          {first, first_kept,
           [=](MatXX* H, const Turn& t) {
             if (!IsWritten(*H, t)) both(H, t);
           }},
          {first, "assembly.block_added_twice", Two(kFirst.Times(2.0), kMirror)},
          {mirror, "formula.mirror_added_twice", Two(kFirst, kMirror.Times(2.0))},
          {mirror, "formula.mirror_subtracted", Two(kFirst, kMirror.Times(-1.0))},
          {first, "assembly.both_at_one_place",
           [](MatXX* H, const Turn& t) {
             const MatXX block = t.Block();
             if (block.rows() == block.cols()) Put(H, t.i, t.j, block + block.transpose());
           }},
          {block, "assembly.weight_missing", BothOf(&NoWeight)},
          {mirror, "assembly.weight_missing_mirror", Two(kFirst, kMirror.Of(&NoWeight))},
          {block, ActsTwice("ρ'", "W_ρ"), BothOf(&RhoWRho)},
          {mirror, "assembly.mirror_takes_sum",
           [](MatXX* H, const Turn& t) {
             kFirst.Run(H, t);
             const MatXX sum = H->block(t.i, t.j, t.v_i().LocalDimension(), t.v_j().LocalDimension());
             if (!t.IsDiagonal()) Put(H, t.j, t.i, sum.transpose());
           }},
          {block, "formula.J_of_i_for_j", OneJacobian(&Turn::at_i)},
          {block, StandsFor("J_j", "J_i", "J_iᵀ W_ρ J_j"), OneJacobian(&Turn::at_j)},
          {block, StandsFor("W_ρ⁻¹", "W_ρ"), BothOf(&Covariance)},
          {block, "assembly.root_once", BothOf(&RootL)},
          {block, "assembly.root_once", BothOf(&RootLt)},
          {block, ActsTwice("W_ρ", "JᵀW_ρJ"), BothOf(&WRhoWRho)},
          {block, DiagonalAlone("W_ρ"), BothOf(&DiagonalOfWRho)},
          {block, kept, Static(false)},
          {block, kept, Static(true)},
          {first, left_out, Without([](const Turn& t) { return t.at_i == 0; })},
          {first, left_out, Without([](const Turn& t) { return t.at_i + 1 == t.edge.Vertices().size(); })},
          {first, left_out, Without([](const Turn& t) { return t.at_j + 1 == t.edge.Vertices().size(); })},
          {first, "formula.edge_that_fits_left_out", &WithoutEdgesThatFit},
          {first, "assembly.nothing_added", Two(kNothing, kNothing)},
          {first, "assembly.off_diagonal_added_twice", Three(kFirst, kFirst.Times(2.0), kMirror.Times(2.0))},
          {first, "assembly.diagonal_blocks_missing", Three(kNothing, kFirst, kMirror)},
          {block, ActsTwice("ρ'", "W_ρ"), BothOf(&RhoRhoW)}};
}

/// What is left of the edges if the loop over them takes the first or the last alone, or begins late or ends early.
inline std::vector<EdgeList> SomeEdges(const EdgeList& all) {
  if (all.size() < 2) return {};
  return {{all.begin(), all.begin() + 1},
          {all.end() - 1, all.end()},
          {all.begin() + 1, all.end()},
          {all.begin(), all.end() - 1}};
}

/// Where all numbers are as small, zero is what a threshold makes of them.
constexpr double kSmall = 1e-6;
inline const Text kSmallLeftOut = "formula.small_left_out";

inline std::vector<Mistake> MistakesInH(const Loop& loop, const char* first, const char* mirror, const char* block) {
  std::vector<Mistake> mistakes;
  const MatXX right = AssembleH(loop, Two(kFirst, kMirror));
  if (right.norm() < kSmall) mistakes.push_back({first, kSmallLeftOut, 0.0 * right});
  for (const auto& [todo, cause, turning] : WrongTurnings(first, mirror, block)) {
    mistakes.push_back({todo, cause, AssembleH(loop, turning)});
  }
  for (const Loop& ended : EndedByFixed(loop)) {
    mistakes.push_back({first, "assembly.break_at_fixed_vertex", AssembleH(ended, Two(kFirst, kMirror))});
  }
  for (const EdgeList& some : SomeEdges(loop.edges)) {
    mistakes.push_back(
        {first, "assembly.edges_left_out", AssembleH({some, loop.size, loop.row_of}, Two(kFirst, kMirror))});
  }
  return mistakes;
}

// "2 × hessian − hessianᵀ"
inline std::string Terms(const std::string& block, double plain, double transposed) {
  std::string terms;
  for (const auto& [times, name] : {std::pair{plain, block}, std::pair{transposed, block + "ᵀ"}}) {
    if (times == 0.0) continue;
    terms += terms.empty() ? (times < 0.0 ? "−" : "") : (times < 0.0 ? " − " : " + ");
    if (std::abs(times) != 1.0) terms += Number(std::abs(times)) + " × ";
    terms += name;
  }
  return terms.empty() ? "0" : terms;
}

/// H as a sum of `block`, as the student's code calls it, and its transpose at both places, so many times each, by least
/// squares; the mistake that it is, if these numbers are whole.
inline Mistake FoundPlaces(const Loop& loop, const MatXX& got, const char* block, const char* first,
                           const char* mirror) {
  const Turning places[] = {Three(kNothing, kFirst, kNothing), Three(kNothing, kFirst.Turned(), kNothing),
                            Three(kNothing, kMirror.Turned(), kNothing), Three(kNothing, kMirror, kNothing),
                            Three(kFirst, kNothing, kNothing)};
  MatXX basis(got.size(), 5);
  for (int k = 0; k < 5; ++k) basis.col(k) = AssembleH(loop, places[k]).reshaped();
  const MatXX finite = got.array().isFinite().select(got, 0.0);
  const VecX times =
      (PseudoInversePsd(basis.transpose() * basis) * (basis.transpose() * finite.reshaped())).array().round();
  const bool first_is_right = times[0] == 1.0 && times[1] == 0.0 && times[4] == 1.0;
  return {first_is_right ? mirror : first,
          {"assembly.added_at",
           {{"block", Word(std::string(block))},
            {"first", Word(Terms(block, times[0], times[1]))},
            {"mirror", Word(Terms(block, times[2], times[3]))},
            {"diagonal", Word(Terms(block, times[4], 0.0))}}},
          (basis * times).reshaped(got.rows(), got.cols())};
}

// ---- b ---------------------------------------------------------------------------------------------------------------

/// How often a turn adds JᵀWr to b: of i where j is i, else of i and of j. Right is once, where j is i.
struct Shares {
  double diagonal, of_i, of_j;
};
constexpr Shares kOnce{1, 0, 0};

inline VecX AssembleB(const Loop& loop, double sign, Weight weight, const Shares& shares = kOnce,
                      bool assigned = false) {
  VecX b = VecX::Zero(loop.size);
  ForEachTurn(loop, [&](const Turn& t) {
    const auto write = [&](size_t k, int row, double times) {
      const Eigen::Index dim = t.edge.Vertices()[k]->LocalDimension();
      if (times == 0.0 || row < 0 || row + dim > b.size()) return;
      const VecX share = sign * times * t.edge.Jacobian(k).transpose() * weight(t) * t.edge.Residual();
      b.segment(row, dim) = assigned ? share : VecX(b.segment(row, dim) + share);
    };
    write(t.at_i, t.i, t.IsDiagonal() ? shares.diagonal : shares.of_i);
    if (!t.IsDiagonal()) write(t.at_j, t.j, shares.of_j);
  });
  return b;
}

/// Where a student may take a vertex's rows of b to begin; negative: nowhere.
struct RowsOfB {
  Text cause;  ///< empty if it is right
  std::function<int(const Edge& edge, size_t k)> begin;
};

inline std::vector<RowsOfB> WrongRowsOfB(const Loop& loop) {
  const auto right = loop.row_of;
  const auto dim = [](const Edge& edge, size_t k) { return edge.Vertices()[k]->LocalDimension(); };
  const auto only = [right](auto is) {
    return [right, is](const Edge& edge, size_t k) { return is(edge, k) ? right(edge, k) : -1; };
  };
  const auto of_pose = [](const Edge& edge, size_t k) { return edge.Vertices()[k]->GetRole() == Role::kPose; };
  const auto is_last = [](const Edge& edge, size_t k) { return k + 1 == edge.Vertices().size(); };
  const Text number = "assembly.number_in_edge_for_row", other = "assembly.row_of_other_vertex",
             one = "assembly.only_one_vertex_in_b", id = "assembly.id_for_first_row";
  return {{number, [](const Edge&, size_t k) { return static_cast<int>(k); }},
          {number, [dim](const Edge& edge, size_t k) { return static_cast<int>(k) * dim(edge, k); }},
          {id, [](const Edge& edge, size_t k) { return edge.Vertices()[k]->Id(); }},
          {id, [dim](const Edge& edge, size_t k) { return edge.Vertices()[k]->Id() * dim(edge, k); }},
          {other, [right](const Edge& edge, size_t) { return right(edge, 0); }},
          {other, [right](const Edge& edge, size_t) { return right(edge, edge.Vertices().size() - 1); }},
          {one, only([](const Edge&, size_t k) { return k == 0; })},
          {one, only(is_last)},
          {"assembly.only_poses_in_b", only(of_pose)},
          {"assembly.only_landmarks_in_b", only([of_pose](const Edge& edge, size_t k) { return !of_pose(edge, k); })}};
}

/// @param sign  the right one;  @param of_sign  what to say of the other;  @param rows  the stage's own wrong rows
inline std::vector<Mistake> MistakesInB(const std::string& todo, const Loop& loop, double sign, const Text& of_sign,
                                        std::vector<RowsOfB> rows = {}) {
  struct WeightOfB {
    Text cause;
    Weight weight;
  };
  const Text W_twice = ActsTwice("W", "Wr"), W_rho = "assembly.W_rho_in_b";
  const WeightOfB weights[] = {
      {{}, &RhoW},
      {"assembly.loss_forgotten_in_b", &W},
      {ActsTwice("ρ'", "ρ'Wr"), &RhoRhoW},
      {StandsFor("W⁻¹", "W"), [](const Turn& t) -> MatXX { return t.drho * W(t).inverse(); }},
      {StandsFor("√ρ'", "ρ'"), [](const Turn& t) -> MatXX { return std::sqrt(t.drho) * W(t); }},
      {W_rho, &WRho},
      {W_rho, &RhoWRho},
      {W_twice, &RhoWW},
      {W_twice, [](const Turn& t) -> MatXX { return t.W_rho * W(t); }},
      {W_twice, [](const Turn& t) -> MatXX { return t.drho * t.W_rho * W(t); }},
      {"assembly.W_missing_in_b", &RhoAlone},
      {"assembly.W_missing_in_b", &NoWeight}};
  for (const RowsOfB& one : WrongRowsOfB(loop)) rows.push_back(one);
  rows.insert(rows.begin(), {{}, loop.row_of});
  const VecX right = AssembleB(loop, sign, &RhoW);
  std::vector<Mistake> mistakes{{todo, right.norm() < kSmall ? kSmallLeftOut : NothingWritten("b"), 0.0 * right}};
  for (const double times : {sign, -sign}) {
    for (const bool assigned : {false, true}) {
      for (const auto& [wrong_weight, weight] : weights) {
        for (const auto& [wrong_row, row_of] : rows) {
          const Text of_assigned = assigned ? "assembly.assigned" : Text(), of_times = times == sign ? Text() : of_sign;
          Text cause;
          int wrong = 0;
          for (const Text& one : {of_times, of_assigned, wrong_weight, wrong_row}) {
            if (!one.empty()) ++wrong, cause = one;
          }
          if (wrong == 0 || wrong > 2) continue;
          mistakes.push_back({todo, cause, AssembleB({loop.edges, loop.size, row_of}, times, weight, kOnce, assigned)});
        }
      }
    }
  }
  for (const Shares& shares : {Shares{1, 0, 1}, {1, 1, 0}, {1, 1, 1}, {2, 1, 0}, {2, 0, 1}}) {
    mistakes.push_back({todo, "assembly.b_in_inner_loop", AssembleB(loop, sign, &RhoW, shares)});
  }
  for (const Loop& ended : EndedByFixed(loop)) {
    mistakes.push_back({todo, "assembly.break_at_fixed_vertex", AssembleB(ended, sign, &RhoW)});
  }
  for (const EdgeList& some : SomeEdges(loop.edges)) {
    mistakes.push_back({todo, "assembly.edges_left_out", AssembleB({some, loop.size, loop.row_of}, sign, &RhoW)});
  }
  return mistakes;
}

}  // namespace ch5::homework
