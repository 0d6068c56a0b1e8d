#pragma once
/// What typical mistakes in BuildSystem make of b (7b) and H (7c).

#include <algorithm>
#include <functional>
#include <string>
#include <vector>

#include "ch5_backend/graph/ordering.h"
#include "ch5_homework/judge/diagnosis.h"
#include "ch5_homework/judge/mistakes/assembly.h"
#include "ch5_homework/judge/mistakes/formula.h"

namespace ch5::homework::stage_7 {

inline bool IsPose(const Vertex& vertex) { return vertex.GetRole() == Role::kPose; }

/// The number of a free vertex, as BlockIndexOf has it.
inline int NumberOf(const Vertex& vertex, const Ordering& ordering) {
  const auto& alike = IsPose(vertex) ? ordering.poses : ordering.landmarks;
  for (size_t k = 0; k < alike.size(); ++k) {
    if (alike[k].get() == &vertex) return static_cast<int>(k);
  }
  return -1;
}

// ---- 7b -------------------------------------------------------------------------------------------------------------

/// Where a student may take a vertex's rows of b to begin, by its number.
inline std::vector<RowsOfB> RowsByNumber(const Ordering& ordering) {
  const auto by = [&](const auto& row) {
    return [&ordering, row](const Edge& edge, size_t k) {
      const Vertex& v = *edge.Vertices()[k];
      return row(v, NumberOf(v, ordering));
    };
  };
  const auto pose_row = [&](const Vertex&, int number) {
    return number < static_cast<int>(ordering.poses.size()) ? ordering.poses[number]->OrderingId() : -1;
  };
  return {{"7.number_for_first_row", by([](const Vertex&, int number) { return number; })},
          {"7.pose_row_for_landmark", by(pose_row)},
          {"7.number_times_size_for_row", by([](const Vertex& v, int number) { return number * v.LocalDimension(); })}};
}

// ---- 7c -------------------------------------------------------------------------------------------------------------

enum class Part { kDiagonal, kPoses, kPoseLandmark, kLandmark };  // of H_pp: the blocks (i, i), the others

inline Part PartOf(const Turn& t) {
  if (!IsPose(t.v_i()) && !IsPose(t.v_j())) return Part::kLandmark;
  if (!IsPose(t.v_i()) || !IsPose(t.v_j())) return Part::kPoseLandmark;
  return t.IsDiagonal() ? Part::kDiagonal : Part::kPoses;
}

/// These parts of H so many times, or overwritten; the others rightly.
inline Turning Changed(const std::vector<Part>& parts, double times, bool overwrites = false) {
  return [=](MatXX* H, const Turn& t) {
    const bool changed = std::find(parts.begin(), parts.end(), PartOf(t)) != parts.end();
    Statement first = kFirst.Times(changed ? times : 1.0), mirror = kMirror.Times(changed ? times : 1.0);
    first.assigned = mirror.assigned = changed && overwrites;
    Two(first, mirror)(H, t);
  };
}

/// Of two poses, the mirror image's block is added at the place that is stored, not transposed; with the own one or alone.
inline MatXX WithMirror(const Loop& loop, const Ordering& ordering, bool alone) {
  MatXX H = AssembleH(loop, Two(kFirst, kMirror));
  for (const auto& a : ordering.poses) {
    for (const auto& c : ordering.poses) {
      const int rows = a->LocalDimension();
      if (a == c || c->LocalDimension() != rows) continue;
      auto block = H.block(a->OrderingId(), c->OrderingId(), rows, rows);
      block = (alone ? 0.0 : 1.0) * block + block.transpose().eval();
    }
  }
  return H;
}

inline std::vector<Mistake> MistakesInH(const Loop& loop, const Ordering& ordering) {
  const auto is = [&](const std::vector<Part>& parts, double times, bool overwrites = false) {
    return AssembleH(loop, Changed(parts, times, overwrites));
  };
  const auto added = [](const char* id, const char* matrix) { return Text(id, {{"matrix", Word(matrix)}}); };
  const Part d = Part::kDiagonal, p = Part::kPoses, pl = Part::kPoseLandmark, l = Part::kLandmark;
  std::vector<Mistake> mistakes{{"7c", added("7.nothing_added", "H_pp"), is({d, p}, 0)},
                                {"7c", added("7.nothing_added", "H_pl"), is({pl}, 0)},
                                {"7c", added("7.nothing_added", "H_ll"), is({l}, 0)},
                                {"7c", added("7.only_one_filled", "H_pp"), is({pl, l}, 0)},
                                {"7c", added("7.only_one_filled", "H_ll"), is({d, p, pl}, 0)},
                                {"7c", added("7.only_one_filled", "H_pl"), is({d, p, l}, 0)},
                                {"7c", "7.off_diagonal_H_pp_missing", is({p}, 0)},
                                {"7c", "7.diagonal_blocks_H_pp_missing", is({d}, 0)},
                                {"7c", Text("7.assigned", {{"blocks", Word("H_pp")}}), is({d, p}, 1, true)},
                                {"7c", "7.mirror_added_too", WithMirror(loop, ordering, false)},
                                {"7c", "7.mirror_for_block", WithMirror(loop, ordering, true)}};
  const std::vector<std::pair<Part, Text>> parts{
      {d, "7.diagonal_blocks_H_pp"}, {p, "7.off_diagonal_H_pp"}, {pl, Word("H_pl")}, {l, Word("H_ll")}};
  for (const auto& [part, name] : parts) {
    mistakes.push_back({"7c", {"7.added_twice", {{"blocks", name}}}, is({part}, 2)});
    mistakes.push_back({"7c", {"7.subtracted_not_added", {{"blocks", name}}}, is({part}, -1)});
    mistakes.push_back({"7c", {"7.assigned", {{"blocks", name}}}, is({part}, 1, true)});
  }
  for (const Mistake& mistake : MistakesInH(loop, "7c", "7c", "7c")) mistakes.push_back(mistake);
  return mistakes;
}

}  // namespace ch5::homework::stage_7
