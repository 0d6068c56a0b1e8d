#pragma once
/// What typical mistakes in MakeHessian make of H and b.

#include <algorithm>
#include <string>
#include <utility>
#include <vector>

#include "ch5_backend/math/psd.h"
#include "ch5_homework/judge/diagnosis.h"
#include "ch5_homework/judge/mistakes/assembly.h"
#include "ch5_homework/judge/mistakes/formula.h"

namespace ch5::homework::stage_1_1 {

inline bool IsWritten(const MatXX& H, const Turn& t) {
  return !H.block(t.i, t.j, t.v_i().LocalDimension(), t.v_j().LocalDimension()).isZero(0.0);
}

struct TurningMistake {
  const char* todo;
  Text cause;
  Turning turning;
};

inline std::vector<TurningMistake> WrongTurnings() {
  const auto numbers = [](const char* these, const char* those) {
    return Text("1.1.numbers_in_edge_for_rows", {{"this", Word(these)}, {"that", Word(those)}});
  };
  const Text one_triangle = "1.1.only_one_triangle", first_kept = "1.1.only_first_block_kept";
  const Turning both = Two(kFirst, kMirror);
  return {{"1.1b", "1.1.mirror_missing", Two(kFirst, kNothing)},
          {"1.1b", "1.1.mirror_not_transposed", Two(kFirst, kMirror.Turned())},
          {"1.1a", "1.1.hessian_transposed", Two(kFirst.Turned(), kMirror)},
          {"1.1a", "1.1.both_blocks_assigned_not_added", Two(kFirst.Assigned(), kMirror.Assigned())},
          {"1.1a", "1.1.block_assigned_not_added", Two(kFirst.Assigned(), kMirror)},
          {"1.1b", "1.1.mirror_assigned_not_added", Two(kFirst, kMirror.Assigned())},
          {"1.1a", "1.1.places_exchanged", Two(kMirror.Turned(), kFirst.Turned())},
          {"1.1a", "1.1.row_column_exchanged", Two(kMirror.Turned(), kMirror)},
          {"1.1b", "1.1.mirror_at_same_place", Two(kFirst, kFirst.Turned())},
          {"1.1b", "1.1.diagonal_blocks_added_twice", Three(kFirst.Times(2.0), kFirst, kMirror)},
          {"1.1a", "1.1.blocks_subtracted", Two(kFirst.Times(-1.0), kMirror.Times(-1.0))},
          {"1.1a", "1.1.block_missing", Two(kNothing, kMirror)},
          {"1.1a", "1.1.only_diagonal_blocks_arrive", Three(kFirst, kNothing, kNothing)},
          {"1.1c 1.1a", "1.1.loss_forgotten", BothOf(&W)},
          {"1.1c 1.1a", "1.1.first_order_loss", BothOf(&RhoW)},
          {"1.1a", "1.1.loss_forgotten", Two(kFirst.Of(&W), kMirror)},
          {"1.1a", "1.1.first_order_loss", Two(kFirst.Of(&RhoW), kMirror)},
          {"1.1b", "1.1.loss_forgotten_mirrored_block", Two(kFirst, kMirror.Of(&W))},
          {"1.1a", one_triangle, [](MatXX* H, const Turn& t) { (t.i <= t.j ? kFirst : kMirror).Run(H, t); }},
          {"1.1a", one_triangle, [](MatXX* H, const Turn& t) { (t.i >= t.j ? kFirst : kMirror).Run(H, t); }},
          {"1.1b", "1.1.mirror_only_of_equal_sizes",
           [](MatXX* H, const Turn& t) {
             kFirst.Run(H, t);
             if (!t.IsDiagonal() && t.v_i().LocalDimension() == t.v_j().LocalDimension()) kMirror.Run(H, t);
           }},
          {"1.1b", "1.1.mirror_only_if_v_i_first",
           [](MatXX* H, const Turn& t) {
             kFirst.Run(H, t);
             if (t.i < t.j) kMirror.Run(H, t);
           }},
          {"1.1a", "1.1.moved_to_triangle_not_transposed",
           [](MatXX* H, const Turn& t) {
             const auto [upper, lower] = std::minmax(t.i, t.j);
             Put(H, upper, lower, t.Block());
             if (!t.IsDiagonal()) Put(H, lower, upper, t.Block().transpose());
           }},
          {"1.1a", "1.1.block_only_if_v_i_first",
           [=](MatXX* H, const Turn& t) {
             if (t.i <= t.j) both(H, t);
           }},
          {"1.1a", numbers("index_i", "index_j"), Two(kFirst.At(&NumbersInEdge), kMirror)},
          {"1.1a", numbers("index_i", "index_j"), Two(kFirst.At(&NumbersInEdge), kMirror.At(&NumbersInEdge))},
          {"1.1b", numbers("index_j", "index_i"), Two(kFirst, kMirror.At(&NumbersInEdge))},
          {"1.1a", numbers("index_i", "index_j"), Two(kFirst.At(&NumbersTimesSizes), kMirror.At(&NumbersTimesSizes))},
          {"1.1a", "1.1.id_for_first_row", Two(kFirst.At(&Ids), kMirror.At(&Ids))},
          {"1.1a", StandsFor("index_i", "index_j"), Two(kFirst.At(&RowOfI), kMirror)},
          {"1.1a", StandsFor("index_i", "index_j"), Two(kFirst.At(&RowOfI), kMirror.At(&RowOfI))},
          {"1.1a", first_kept,
           [](MatXX* H, const Turn& t) {
             if (!IsWritten(*H, t)) kFirst.Run(H, t);
             if (!t.IsDiagonal()) kMirror.Run(H, t);
           }},
          {"1.1a", first_kept,
           [=](MatXX* H, const Turn& t) {
             if (!IsWritten(*H, t)) both(H, t);
           }},
          {"1.1a", "1.1.block_added_twice", Two(kFirst.Times(2.0), kMirror)},
          {"1.1b", "formula.mirror_added_twice", Two(kFirst, kMirror.Times(2.0))},
          {"1.1b", "formula.mirror_subtracted", Two(kFirst, kMirror.Times(-1.0))},
          {"1.1a", "1.1.both_at_one_place",
           [](MatXX* H, const Turn& t) {
             const MatXX block = t.Block();
             if (block.rows() == block.cols()) Put(H, t.i, t.j, block + block.transpose());
           }},
          {"1.1c 1.1a", "1.1.weight_missing", BothOf(&NoWeight)},
          {"1.1b", "1.1.weight_missing_mirror", Two(kFirst, kMirror.Of(&NoWeight))},
          {"1.1c 1.1a", ActsTwice("ρ'", "W_ρ"), BothOf(&RhoWRho)},
          {"1.1b", "1.1.mirror_takes_sum",
           [](MatXX* H, const Turn& t) {
             kFirst.Run(H, t);
             const MatXX sum = H->block(t.i, t.j, t.v_i().LocalDimension(), t.v_j().LocalDimension());
             if (!t.IsDiagonal()) Put(H, t.j, t.i, sum.transpose());
           }},
          {"1.1c 1.1a", "formula.J_of_i_for_j", &WithJacobianOfI},
          {"1.1c 1.1a", StandsFor("J_j", "J_i", "J_iᵀ W_ρ J_j"), &WithJacobianOfJ},
          {"1.1c 1.1a", StandsFor("W_ρ⁻¹", "W_ρ"), BothOf(&Covariance)},
          {"1.1a", "formula.edge_that_fits_left_out", &WithoutEdgesThatFit},
          {"1.1a", "1.1.nothing_added_H", Two(kNothing, kNothing)},
          {"1.1a", "1.1.H_doubled", Two(kFirst.Times(2.0), kMirror.Times(2.0))}};
}

inline std::vector<Mistake> MistakesInH(const Loop& loop) {
  std::vector<Mistake> mistakes;
  for (const auto& [todo, cause, turning] : WrongTurnings()) {
    mistakes.push_back({todo, cause, AssembleH(loop, turning)});
  }
  return mistakes;
}

inline std::vector<Mistake> MistakesInB(const Loop& loop) {
  const auto is = [&](const Shares& shares) { return AssembleB(loop, -1.0, &RhoW, shares); };
  const Text mirror = "1.1.b_added_in_mirror", pairs = "1.1.b_added_with_each_block";
  return {{"1.1d 1.1b", "1.1.sign_b", is({-1, 0, 0})},
          {"1.1d 1.1b", "1.1.b_doubled", is({2, 0, 0})},
          {"1.1b", mirror, is({1, 0, 1})},
          {"1.1b", mirror, is({1, 1, 0})},
          {"1.1b", mirror, is({1, 1, 1})},
          {"1.1a", pairs, is({2, 1, 0})},
          {"1.1a", pairs, is({2, 0, 1})},
          {"", "1.1.weight_missing_b", AssembleB(loop, -1.0, &RhoAlone)},
          {"", "1.1.last_edge_left_in_b", AssembleB(loop, -1.0, &RhoW, kOnce, true)},
          {"", "1.1.loss_forgotten_b", AssembleB(loop, -1.0, &W)},
          {"", ActsTwice("ρ'", "Wr"), AssembleB(loop, -1.0, &RhoRhoW)},
          {"", ActsTwice("W", "Wr"), AssembleB(loop, -1.0, &RhoWW)},
          {"", "1.1.W_rho_in_b", AssembleB(loop, -1.0, &WRho)}};
}

// ---- where no typical mistake explains H -----------------------------------------------------------------------------

// "2 × hessian − hessianᵀ"
inline std::string Terms(double plain, double transposed) {
  std::string terms;
  for (const auto& [times, name] : {std::pair{plain, "hessian"}, std::pair{transposed, "hessianᵀ"}}) {
    if (times == 0.0) continue;
    terms += terms.empty() ? (times < 0.0 ? "−" : "") : (times < 0.0 ? " − " : " + ");
    if (std::abs(times) != 1.0) terms += Number(std::abs(times)) + " × ";
    terms += name;
  }
  return terms.empty() ? "0" : terms;
}

/// H as a sum of `hessian` and its transpose at both places, so many times each, by least squares; the mistake that it
/// is, if these numbers are whole.
inline Mistake FoundPlaces(const Loop& loop, const MatXX& got) {
  const Turning places[] = {Three(kNothing, kFirst, kNothing), Three(kNothing, kFirst.Turned(), kNothing),
                            Three(kNothing, kMirror.Turned(), kNothing), Three(kNothing, kMirror, kNothing),
                            Three(kFirst, kNothing, kNothing)};
  MatXX basis(got.size(), 5);
  for (int k = 0; k < 5; ++k) basis.col(k) = AssembleH(loop, places[k]).reshaped();
  const MatXX finite = got.array().isFinite().select(got, 0.0);
  const VecX times =
      (PseudoInversePsd(basis.transpose() * basis) * (basis.transpose() * finite.reshaped())).array().round();
  const bool first_is_right = times[0] == 1.0 && times[1] == 0.0 && times[4] == 1.0;
  return {first_is_right ? "1.1b" : "1.1a",
          {"1.1.added_at",
           {{"first", Word(Terms(times[0], times[1]))},
            {"mirror", Word(Terms(times[2], times[3]))},
            {"diagonal", Word(Terms(times[4], 0.0))}}},
          (basis * times).reshaped(got.rows(), got.cols())};
}

}  // namespace ch5::homework::stage_1_1
