#pragma once
/// What typical mistakes in BuildSystem make of b (7b) and H (7c).

#include <functional>
#include <string>
#include <vector>

#include "ch5_backend/graph/graph.h"
#include "ch5_backend/graph/ordering.h"
#include "ch5_homework/judge/diagnosis.h"

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

/// Where a student may take a vertex's rows of b to begin; negative: nowhere.
struct Rows {
  Text cause;  ///< empty if it is right
  std::function<int(const Vertex& v, int place_in_edge)> begin;
};
/// What may stand for Wr.
struct Weight {
  Text cause;
  std::function<VecX(const Edge& edge)> times_r;
};
/// What may stand for −=.
struct Operation {
  Text cause;
  double sign;
  bool overwrites;
};

inline VecX AssembleB(const Graph& graph, int size, const Rows& rows, const Weight& weight, const Operation& how) {
  VecX b = VecX::Zero(size);
  for (const auto& edge : graph.Edges()) {
    const VecX Wr = weight.times_r(*edge);
    for (size_t i = 0; i < edge->Vertices().size(); ++i) {
      const Vertex& v = *edge->Vertices()[i];
      const int row = v.IsFixed() ? -1 : rows.begin(v, static_cast<int>(i));
      if (row < 0 || row + v.LocalDimension() > size) continue;
      auto part = b.segment(row, v.LocalDimension());
      part =
          (how.overwrites ? VecX(VecX::Zero(part.size())) : VecX(part)) + how.sign * edge->Jacobian(i).transpose() * Wr;
    }
  }
  return b;
}

inline VecX WeightedResidual(const Edge& edge, int times_drho, bool robust) {
  double drho;
  MatXX W;
  edge.RobustInfo(&drho, &W);
  VecX Wr = (robust ? W : MatXX(edge.Information())) * edge.Residual();
  for (int k = 0; k < times_drho; ++k) Wr *= drho;
  return Wr;
}

inline std::vector<Rows> RowsInB(const Ordering& ordering) {
  const auto number = [ordering](const Vertex& v) { return NumberOf(v, ordering); };
  const auto pose_row = [ordering, number](const Vertex& v, int) {
    const auto k = static_cast<size_t>(number(v));
    return k < ordering.poses.size() ? ordering.poses[k]->OrderingId() : -1;
  };
  return {{{}, [](const Vertex& v, int) { return v.OrderingId(); }},
          {"7.number_for_first_row", [=](const Vertex& v, int) { return number(v); }},
          {"7.pose_row_for_landmark", pose_row},
          {"7.number_in_edge_for_first_row", [](const Vertex&, int i) { return i; }},
          {"7.number_times_size_for_row", [=](const Vertex& v, int) { return number(v) * v.LocalDimension(); }},
          {"7.only_poses_rows_b_written", [](const Vertex& v, int) { return IsPose(v) ? v.OrderingId() : -1; }},
          {"7.only_landmarks_rows_b_written", [](const Vertex& v, int) { return IsPose(v) ? -1 : v.OrderingId(); }}};
}

inline std::vector<Mistake> MistakesInB(const Graph& graph, const Ordering& ordering) {
  const std::vector<Rows> rows = RowsInB(ordering);
  const std::vector<Weight> weights{
      {{}, [](const Edge& edge) { return WeightedResidual(edge, 1, false); }},
      {Text("formula.acts_twice", {{"this", Word("ρ'")}, {"that", Word("Wr")}}),
       [](const Edge& edge) { return WeightedResidual(edge, 2, false); }},
      {"7.loss_forgotten", [](const Edge& edge) { return WeightedResidual(edge, 0, false); }},
      {"7.W_rho_in_b", [](const Edge& edge) { return WeightedResidual(edge, 0, true); }},
      {Text("formula.acts_twice", {{"this", Word("W")}, {"that", Word("Wr")}}),
       [](const Edge& edge) { return VecX(edge.Information() * WeightedResidual(edge, 1, false)); }},
      {"7.W_missing", [](const Edge& edge) { return VecX(edge.Residual()); }}};
  const std::vector<Operation> operations{{{}, -1.0, false},
                                          {"7.sign_of_b", 1.0, false},
                                          {"7.last_edge_left_in_b", -1.0, true},
                                          {"7.assigned_and_sign_lost", 1.0, true}};
  std::vector<Mistake> mistakes{
      {"7b", Text("formula.nothing_written", {{"matrix", Word("b")}}), [=] { return VecX::Zero(ordering.Size()); }}};
  for (const Operation& how : operations) {
    for (const Weight& weight : weights) {
      for (const Rows& row : rows) {
        const Text cause = !row.cause.empty() ? row.cause : (!weight.cause.empty() ? weight.cause : how.cause);
        if (cause.empty()) continue;
        mistakes.push_back({"7b", cause, [=, &graph] { return AssembleB(graph, ordering.Size(), row, weight, how); }});
      }
    }
  }
  return mistakes;
}

// ---- 7c -------------------------------------------------------------------------------------------------------------

enum class Part { kDiagonal, kPoses, kPoseLandmark, kLandmark };  // of H_pp: the blocks (i, i), the others

/// What is done with one part of H, by factor; or it is overwritten.
struct PartWay {
  Part part;
  double times;
  bool overwrites;
};
enum class LossWay { kRight, kForgotten, kFirstOrder };

inline MatXX AssembleH(const Graph& graph, int size, const std::vector<PartWay>& ways, LossWay loss = LossWay::kRight) {
  MatXX H = MatXX::Zero(size, size);
  for (const auto& edge : graph.Edges()) {
    double drho;
    MatXX W;
    edge->RobustInfo(&drho, &W);
    if (loss != LossWay::kRight) W = (loss == LossWay::kFirstOrder ? drho : 1.0) * edge->Information();
    for (size_t i = 0; i < edge->Vertices().size(); ++i) {
      for (size_t k = 0; k < edge->Vertices().size(); ++k) {
        const Vertex &a = *edge->Vertices()[i], &c = *edge->Vertices()[k];
        if (a.IsFixed() || c.IsFixed()) continue;
        Part part = IsPose(c) ? (i == k ? Part::kDiagonal : Part::kPoses) : Part::kPoseLandmark;
        if (!IsPose(a)) part = IsPose(c) ? Part::kPoseLandmark : Part::kLandmark;
        PartWay how{part, 1.0, false};
        for (const PartWay& way : ways) how = way.part == part ? way : how;
        auto block = H.block(a.OrderingId(), c.OrderingId(), a.LocalDimension(), c.LocalDimension());
        if (how.overwrites) block.setZero();
        block += how.times * edge->Jacobian(i).transpose() * W * edge->Jacobian(k);
      }
    }
  }
  return H;
}

/// Of two poses, block and mirror image are both added at the place that is stored, neither of them transposed.
inline MatXX MirrorAddedToo(const Graph& graph, int size) {
  MatXX H = AssembleH(graph, size, {});
  for (const auto& a : graph.Vertices()) {
    for (const auto& c : graph.Vertices()) {
      if (a == c || !IsPose(*a) || !IsPose(*c) || a->OrderingId() < 0 || c->OrderingId() < 0) continue;
      const int rows = a->LocalDimension();
      if (c->LocalDimension() != rows) continue;
      auto block = H.block(a->OrderingId(), c->OrderingId(), rows, rows);
      block += block.transpose().eval();
    }
  }
  return H;
}

inline std::vector<Mistake> MistakesInH(const Graph& graph, int size) {
  const auto is = [&graph, size](const std::vector<PartWay>& ways, LossWay loss = LossWay::kRight) {
    return [=, &graph] { return AssembleH(graph, size, ways, loss); };
  };
  const Part d = Part::kDiagonal, p = Part::kPoses, pl = Part::kPoseLandmark, l = Part::kLandmark;
  std::vector<Mistake> mistakes{
      {"7c", Text("7.nothing_added", {{"matrix", Word("H")}}),
       is({{d, 0, false}, {p, 0, false}, {pl, 0, false}, {l, 0, false}})},
      {"7c", Text("7.nothing_added", {{"matrix", Word("H_pp")}}), is({{d, 0, false}, {p, 0, false}})},
      {"7c", Text("7.nothing_added", {{"matrix", Word("H_pl")}}), is({{pl, 0, false}})},
      {"7c", Text("7.nothing_added", {{"matrix", Word("H_ll")}}), is({{l, 0, false}})},
      {"7c", Text("7.only_one_filled", {{"matrix", Word("H_pp")}}), is({{pl, 0, false}, {l, 0, false}})},
      {"7c", Text("7.only_one_filled", {{"matrix", Word("H_ll")}}), is({{d, 0, false}, {p, 0, false}, {pl, 0, false}})},
      {"7c", Text("7.only_one_filled", {{"matrix", Word("H_pl")}}), is({{d, 0, false}, {p, 0, false}, {l, 0, false}})},
      {"7c", "7.off_diagonal_H_pp_missing", is({{p, 0, false}})},
      {"7c", "7.diagonal_blocks_H_pp_missing", is({{d, 0, false}})},
      {"7c", "7.last_edge_left_in_H", is({{d, 1, true}, {p, 1, true}, {pl, 1, true}, {l, 1, true}})},
      {"7c", Text("7.assigned", {{"blocks", Word("H_pp")}}), is({{d, 1, true}, {p, 1, true}})},
      {"7c", "7.blocks_subtracted", is({{d, -1, false}, {p, -1, false}, {pl, -1, false}, {l, -1, false}})},
      {"7c", "7.mirror_added_too", [=, &graph] { return MirrorAddedToo(graph, size); }},
      {"7c", "7.loss_forgotten_in_H", is({}, LossWay::kForgotten)},
      {"7c", "7.first_order_loss", is({}, LossWay::kFirstOrder)}};
  const std::vector<std::pair<Part, Text>> parts{
      {d, "7.diagonal_blocks_H_pp"}, {p, "7.off_diagonal_H_pp"}, {pl, Word("H_pl")}, {l, Word("H_ll")}};
  for (const auto& [part, name] : parts) {
    mistakes.push_back({"7c", {"7.added_twice", {{"blocks", name}}}, is({{part, 2, false}})});
    mistakes.push_back({"7c", {"7.subtracted_not_added", {{"blocks", name}}}, is({{part, -1, false}})});
    mistakes.push_back({"7c", {"7.assigned", {{"blocks", name}}}, is({{part, 1, true}})});
  }
  return mistakes;
}

}  // namespace ch5::homework::stage_7
