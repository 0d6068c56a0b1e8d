#include "ch5_homework/judge/right/assembly.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <tuple>

namespace ch5::homework::right {
namespace {

// ---- the loops -------------------------------------------------------------------------------------------------------

/// One turn of the innermost loop: the vertices i and j ≥ i of an edge, both free. b has those with j = i.
struct Turn {
  const EdgeList& edges;
  size_t number, at_i, at_j;                   ///< of the edge, and of the vertices in its list
  Eigen::Index row, column;                    ///< where it is added
  bool is_mirrored = false, is_taken = false;  ///< something has been added there before

  const Edge& edge() const { return *edges[number]; }
  const Vertex& v_i() const { return *edge().Vertices()[at_i]; }
  const Vertex& v_j() const { return *edge().Vertices()[at_j]; }
  bool IsLast(size_t k) const { return k + 1 == edge().Vertices().size(); }
  bool SizesDiffer() const { return v_i().LocalDimension() != v_j().LocalDimension(); }
  bool IsPose() const { return v_i().GetRole() == Role::kPose; }
  Turn Mirrored() const { return {edges, number, at_i, at_j, column, row, true}; }
};

/// What a fixed vertex ends: its own turn (continue, as is right), the loop (break), or the function (return).
enum class Ends { kTurn, kLoop, kFunction };

template <typename Do>
void ForEachTurn(const Loop& loop, Ends at_fixed_i, Ends at_fixed_j, const Do& with) {
  for (size_t number = 0; number < loop.edges.size(); ++number) {
    const Edge& edge = *loop.edges[number];
    const auto& vertices = edge.Vertices();
    for (size_t i = 0; i < vertices.size(); ++i) {
      if (vertices[i]->IsFixed()) {
        if (at_fixed_i == Ends::kFunction) return;
        if (at_fixed_i == Ends::kLoop) break;
        continue;
      }
      for (size_t j = i; j < vertices.size(); ++j) {
        if (vertices[j]->IsFixed()) {
          if (at_fixed_j == Ends::kFunction) return;
          if (at_fixed_j == Ends::kLoop) break;
          continue;
        }
        with(Turn{loop.edges, number, i, j, loop.row_of(edge, i), loop.row_of(edge, j)});
      }
    }
  }
}

using Reached = std::set<std::tuple<size_t, size_t, size_t>>;

/// The turns that are left if break or return stands where a fixed vertex is to be skipped.
std::vector<Reached> EndedByFixed(const Loop& loop) {
  std::vector<Reached> all;
  for (const auto& [at_i, at_j] : {std::pair{Ends::kTurn, Ends::kLoop},
                                   {Ends::kTurn, Ends::kFunction},
                                   {Ends::kLoop, Ends::kTurn},
                                   {Ends::kFunction, Ends::kTurn},
                                   {Ends::kLoop, Ends::kLoop},
                                   {Ends::kFunction, Ends::kFunction}}) {
    Reached& reached = all.emplace_back();
    ForEachTurn(loop, at_i, at_j, [&](const Turn& t) { reached.insert({t.number, t.at_i, t.at_j}); });
  }
  return all;
}

// ---- where a block is added by mistake -------------------------------------------------------------------------------

struct LeftOut {
  const char* name;
  bool (*is)(const Turn& t);
};
constexpr LeftOut kLeftOut[] = {
    {"assembly.edges_left_out", [](const Turn& t) { return t.number == 0; }},
    {"assembly.edges_left_out", [](const Turn& t) { return t.number + 1 == t.edges.size(); }},
    {"assembly.edges_left_out", [](const Turn& t) { return t.number != 0; }},
    {"assembly.edges_left_out", [](const Turn& t) { return t.number + 1 != t.edges.size(); }},
    {"formula.edge_that_fits_left_out", [](const Turn& t) { return t.edge().Residual().isZero(0.0); }},
    {"assembly.vertex_left_out", [](const Turn& t) { return t.at_i == 0; }},
    {"assembly.vertex_left_out", [](const Turn& t) { return t.row == 0; }},
    {"assembly.vertex_left_out", [](const Turn& t) { return t.column == 0; }},
    {"assembly.vertex_left_out", [](const Turn& t) { return t.IsLast(t.at_i); }},
    {"assembly.vertex_left_out", [](const Turn& t) { return t.IsLast(t.at_j); }},
    {"assembly.only_one_vertex", [](const Turn& t) { return t.at_j != 0; }},
    {"assembly.only_one_vertex", [](const Turn& t) { return !t.IsLast(t.at_i); }},
    {"assembly.not_all_pairs", [](const Turn& t) { return t.at_j > t.at_i + 1; }},
    {"assembly.not_all_pairs", [](const Turn& t) { return t.at_j > 1; }},
    {"assembly.only_poses", [](const Turn& t) { return !t.IsPose(); }},
    {"assembly.only_landmarks", [](const Turn& t) { return t.IsPose(); }},
    {"assembly.only_first_block_kept", [](const Turn& t) { return t.is_taken; }},
    {"assembly.block_only_of_equal_sizes", [](const Turn& t) { return !t.is_mirrored && t.SizesDiffer(); }},
    {"assembly.only_one_triangle", [](const Turn& t) { return t.row > t.column; }},
    {"assembly.only_one_triangle", [](const Turn& t) { return t.row < t.column; }},
    {"assembly.mirror_only_of_equal_sizes", [](const Turn& t) { return t.is_mirrored && t.SizesDiffer(); }},
    {"assembly.mirror_only_if_v_i_first", [](const Turn& t) { return t.is_mirrored && t.column > t.row; }},
    {"assembly.block_only_if_v_i_first", [](const Turn& t) { return (t.row > t.column) != t.is_mirrored; }},
};
constexpr Place kNowhere{-1, -1};
constexpr const char* kBlockOfOther = "assembly.block_of_other_vertex";

std::vector<Loop::WrongRow> WrongRows(const Loop& loop) {
  const auto dim = [](const Edge& edge, size_t k) { return edge.Vertices()[k]->LocalDimension(); };
  const Text number = "assembly.number_in_edge_for_row", id = "assembly.id_for_first_row",
             other = "assembly.row_of_other_vertex";  // of b; of a block PlacesOf says so
  std::vector<Loop::WrongRow> rows = loop.wrong_rows;
  for (const Loop::WrongRow& row : std::vector<Loop::WrongRow>{
           {number, [](const Edge&, size_t k) { return static_cast<int>(k); }},
           {number, [dim](const Edge&edge, size_t k) { return static_cast<int>(k) * dim(edge, k); }},
           {id, [](const Edge&edge, size_t k) { return edge.Vertices()[k]->Id(); }},
           {id, [dim](const Edge&edge, size_t k) { return edge.Vertices()[k]->Id() * dim(edge, k); }},
           {other, [&loop](const Edge&edge, size_t) { return loop.row_of(edge, 0); }},
           {other, [&loop](const Edge&edge, size_t) { return loop.row_of(edge, edge.Vertices().size() - 1); }},
           {"assembly.size_for_row", dim}}) {  // last: another vertex may begin at that row
    rows.push_back(row);
  }
  return rows;
}

/// What all turns have in common.
struct Wrong {
  const std::vector<Loop::WrongRow> rows;
  const std::vector<Reached> ended;

  explicit Wrong(const Loop& loop) : rows(WrongRows(loop)), ended(EndedByFixed(loop)) {}

  std::vector<Share::Elsewhere> PlacesOf(const Turn& t, bool of_b) const {
    const Place own{t.row, of_b ? 0 : t.column};
    std::vector<Share::Elsewhere> places;
    for (const auto& [name, is] : kLeftOut) places.push_back({name, is(t) ? kNowhere : own});
    for (const Reached& reached : ended) {
      const bool is = reached.count({t.number, t.at_i, t.at_j}) > 0;
      places.push_back({"assembly.break_at_fixed_vertex", is ? own : kNowhere});
    }
    if (!of_b) places.insert(places.end(), {{kBlockOfOther, {t.row, t.row}}, {kBlockOfOther, {t.column, t.column}}});
    for (const auto& [name, row_of] : rows) {
      Eigen::Index i = row_of(t.edge(), t.at_i), j = row_of(t.edge(), t.at_j);
      if (t.is_mirrored) std::swap(i, j);
      if (of_b) {
        places.push_back({name, {i, 0}});
        continue;
      }
      const bool is_other = name.Json() == Text("assembly.row_of_other_vertex").Json();
      for (const Place& place : {Place{i, j}, {i, t.column}, {t.row, j}})
        places.push_back({is_other ? kBlockOfOther : name, place});
    }
    if (of_b) return places;
    places.push_back({"assembly.places_exchanged", {t.column, t.row}});
    places.push_back({"assembly.mirror_at_first", t.is_mirrored ? Place{t.column, t.row} : own, t.is_mirrored});
    places.push_back(
        {"assembly.mirror_always_below", t.is_mirrored && t.row < t.column ? Place{t.column, t.row} : own});
    const Place swapped = (t.row > t.column) != t.is_mirrored ? Place{t.column, t.row} : own;
    places.push_back({"assembly.moved_to_triangle_not_transposed", swapped});
    return places;
  }
};

Text NameOf(const Edge& edge, size_t number) { return Word(edge.TypeInfo() + " " + std::to_string(number)); }

// ---- what is added ---------------------------------------------------------------------------------------------------

struct Weights {
  Expression W_rho, rho_W;

  explicit Weights(const Edge& edge) {
    double rho;
    MatXX robust;
    edge.RobustInfo(&rho, &robust);
    const MatXX plain = edge.Information(), I = MatXX::Identity(plain.rows(), plain.cols());
    const Expression W = Matrix("W", plain), of_H = Matrix("W_ρ", robust), of_b = Matrix("ρ'W", rho * plain),
                     twice = Matrix("ρ'W_ρ", rho * robust), squared = Matrix("ρ'²W", rho * rho * plain),
                     first = Matrix("W_ρ(0, 0) I", robust(0, 0) * I);
    const MatXX L = robust.llt().matrixL();
    W_rho = MistakenFor(of_H, {W, of_b, twice, squared, first, Matrix("ρ'", rho * I), Matrix("L of W_ρ = L Lᵀ", L),
                               Matrix("Lᵀ of W_ρ = L Lᵀ", L.transpose())});
    rho_W = MistakenFor(of_b, {W, of_H, twice, squared, Matrix("ρ'", rho * I), Matrix("√ρ'W", std::sqrt(rho) * plain),
                               Matrix("ρ'W⁻¹", rho * plain.inverse()), Matrix("ρ'WW", rho * plain * plain),
                               Matrix("W_ρW", robust * plain), Matrix("ρ'W_ρW", rho * robust * plain)});
  }
};

Expression BlockOf(const Turn& t) {
  const Expression J_i = Matrix("J_i", t.edge().Jacobian(t.at_i)), J_j = Matrix("J_j", t.edge().Jacobian(t.at_j)),
                   J_0 = Matrix("J_0", t.edge().Jacobian(0));
  const Expression block =
      Transpose(MistakenFor(J_i, {J_j, J_0})) * Weights(t.edge()).W_rho * MistakenFor(J_j, {J_i, J_0});
  return MistakenFor(Named(block, NameOf(block)), {block + Transpose(block)});
}

/// What a vertex adds to b; also as often as a loop over pairs comes by.
Expression SegmentOf(const Turn& t) {
  const Expression J_i = Matrix("J_i", t.edge().Jacobian(t.at_i)), J_0 = Matrix("J_0", t.edge().Jacobian(0));
  const Expression segment =
      Transpose(MistakenFor(J_i, {J_0})) * Weights(t.edge()).rho_W * Matrix("r", t.edge().Residual());
  int before = 0, all = 0;  // free vertices
  for (size_t k = 0; k < t.edge().Vertices().size(); ++k) {
    if (t.edge().Vertices()[k]->IsFixed()) continue;
    ++all;
    before += k < t.at_i;
  }
  std::vector<Instead> often;
  for (const int times : {all - before, before + 1, all - before + 1, before + 2}) {
    often.push_back(Named(times * segment, "Σ_j " + NameOf(segment)));
  }
  often.push_back({all * segment, "assembly.b_for_each_vertex"});  // or twice everywhere, where each edge has two
  return MistakenFor(Named(segment, NameOf(segment)), often);
}

/// What a block is one of.
std::vector<Text> KindsOfBlock(const Loop& loop, const Turn& t) {
  const bool is_diagonal = t.at_i == t.at_j;
  std::vector<Text> kinds = loop.parts_of ? loop.parts_of(t.v_i(), t.v_j()) : std::vector<Text>();
  if (is_diagonal) kinds.insert(kinds.begin(), "assembly.blocks_ii");
  if (t.is_mirrored) kinds.insert(kinds.begin(), "assembly.blocks_ji");
  if (!is_diagonal) kinds.push_back("assembly.blocks_of_two_vertices");
  if (!t.is_mirrored) kinds.push_back("assembly.blocks_ij");
  return kinds;
}

}  // namespace

AssembledSystem::AssembledSystem(const Loop& loop) {
  for (const auto& edge : loop.edges) edge->Linearize();
  const Wrong wrong(loop);
  std::vector<Share> to_H, to_b;
  std::set<std::pair<Eigen::Index, Eigen::Index>> taken;
  ForEachTurn(loop, Ends::kTurn, Ends::kTurn, [&](Turn t) {
    const Text from = NameOf(t.edge(), t.number);
    const Expression block = WrittenAt(loop.todo_block, BlockOf(t)),
                     transposed = WrittenAt(loop.todo_mirror, Transpose(block));
    const auto add = [&](const Expression& x, Turn* at) {
      at->is_taken = !taken.insert({at->row, at->column}).second;
      to_H.push_back({x, {at->row, at->column}, from, KindsOfBlock(loop, *at), wrong.PlacesOf(*at, false)});
    };
    add(WrittenAt(loop.todo_first, 1.0 * block), &t);
    if (Turn mirrored = t.Mirrored(); t.at_i != t.at_j) return add(transposed, &mirrored);
    const Share::Elsewhere again{"assembly.diagonal_blocks_added_twice", {t.row, t.column}};
    to_H.push_back({transposed, kNowhere, {}, {}, {again}});  // the mirrored block is the same one
    to_b.push_back({loop.sign_of_b * SegmentOf(t), {t.row, 0}, from, {}, wrong.PlacesOf(t, true)});
  });
  H = {WrittenAt(loop.todo_first, Assembly(loop.name, loop.size, loop.size, to_H))};
  b = {WrittenAt(loop.todo_b, Assembly("b", loop.size, 1, to_b))};
}

}  // namespace ch5::homework::right
