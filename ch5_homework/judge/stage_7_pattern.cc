/// Stage 7, TODO 7a: which blocks S has. The rest of the stage is in stage_7.cc.

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <set>

#include "ch5_homework/judge/diagnosis.h"
#include "ch5_homework/judge/stage_7_scene.h"

namespace ch5::homework {
namespace {

// ---- 7a: the pattern of S ----------------------------------------------------------------------------------------

using Pattern = std::set<std::pair<int, int>>;

// The numbers of the free poses that edges have: of each landmark's edges together, and of each edge alone.
struct Groups {
  std::vector<std::vector<int>> of_landmarks, of_edges;

  Groups(const Graph& graph, const Ordering& ordering) {
    std::map<const Vertex*, std::vector<int>> seen_by;
    for (const auto& edge : graph.Edges()) {
      const Vertex* landmark = nullptr;
      std::vector<int>& poses = of_edges.emplace_back();
      for (const auto& vertex : edge->Vertices()) {
        if (vertex->IsFixed()) continue;
        if (vertex->GetRole() == Role::kLandmark) landmark = vertex.get();
        const auto it = std::find(ordering.poses.begin(), ordering.poses.end(), vertex);
        if (it != ordering.poses.end()) poses.push_back(static_cast<int>(it - ordering.poses.begin()));
      }
      if (landmark != nullptr) seen_by[landmark].insert(seen_by[landmark].end(), poses.begin(), poses.end());
    }
    for (const auto& one : seen_by) of_landmarks.push_back(one.second);
  }
};

// All pairs (i, j) of a group that `keep` keeps.
template <typename Keep>
Pattern PairsOf(const std::vector<std::vector<int>>& groups, const Keep& keep) {
  Pattern pattern;
  for (const auto& group : groups) {
    for (const int i : group) {
      for (const int j : group) {
        if (keep(i, j)) pattern.insert({i, j});
      }
    }
  }
  return pattern;
}

bool IsLower(int i, int j) { return i >= j; }

// Whether the blocks are just those of some landmarks, though not of all.
bool LandmarksLeftOut(const Pattern& got, const Groups& groups, Pattern pattern) {
  for (const auto& group : groups.of_landmarks) {
    const Pattern own = PairsOf({group}, IsLower);
    if (std::includes(got.begin(), got.end(), own.begin(), own.end())) pattern.insert(own.begin(), own.end());
  }
  return got == pattern;
}

Text CauseOf(const Pattern& got, const Groups& groups, int poses) {
  const Pattern H_pp = PairsOf(groups.of_edges, IsLower);
  const auto is_H_pp_and = [&](Pattern pattern) {
    pattern.insert(H_pp.begin(), H_pp.end());
    return got == pattern;
  };
  std::vector<int> all;
  for (int i = 0; i < poses; ++i) all.push_back(i);
  if (got == H_pp) return "7.only_blocks_H_pp";
  if (is_H_pp_and(PairsOf({all}, IsLower))) {
    return "7.S_full";
  }
  if (is_H_pp_and(PairsOf(groups.of_landmarks, [](int i, int j) { return i <= j; }))) {
    return "7.wrong_half_stored";
  }
  if (is_H_pp_and(PairsOf(groups.of_landmarks, [](int, int) { return true; }))) {
    return "7.both_halves_stored";
  }
  std::vector<int> positions;  // in the longest of the landmarks' lists
  for (const auto& group : groups.of_landmarks) {
    const auto length = std::set<int>(group.begin(), group.end()).size();
    while (positions.size() < length) positions.push_back(static_cast<int>(positions.size()));
  }
  if (is_H_pp_and(PairsOf({positions}, IsLower))) {
    return "7.positions_for_numbers";
  }
  const auto chain = [&](const auto& keep) {
    std::vector<std::vector<int>> pairs;
    for (const auto& group : groups.of_landmarks) {
      for (size_t k = 1; k < group.size(); ++k) pairs.push_back({group[k], keep(group, k)});
    }
    return PairsOf(pairs, IsLower);
  };
  if (is_H_pp_and(chain([](const auto& group, size_t k) { return group[k - 1]; }))) {
    return "7.only_neighbors_tied";
  }
  if (is_H_pp_and(chain([](const auto& group, size_t) { return group[0]; }))) {
    return "7.only_first_pose_tied";
  }
  if (LandmarksLeftOut(got, groups, H_pp)) {
    return "7.landmarks_left_out";
  }
  for (const auto& block : got) {
    if (block.first < block.second) return "7.block_above_diagonal_stored";
  }
  return "7.none_typical";
}

void CheckPattern(const PlainBlockSolver& solver, const Graph& graph, const Text& scene) {
  const Ordering& ordering = solver.GetOrdering();
  const Groups groups(graph, ordering);
  const auto blocks = solver.SchurPattern();
  const Pattern got(blocks.begin(), blocks.end());
  Pattern expected = PairsOf(groups.of_landmarks, IsLower);
  expected.merge(PairsOf(groups.of_edges, IsLower));
  if (got == expected) return;
  std::vector<std::pair<int, int>> missing, superfluous;
  std::set_difference(expected.begin(), expected.end(), got.begin(), got.end(), std::back_inserter(missing));
  std::set_difference(got.begin(), got.end(), expected.begin(), expected.end(), std::back_inserter(superfluous));
  const auto& worst = missing.empty() ? superfluous[0] : missing[0];
  const Text difference(missing.empty() ? "7.blocks_too_many" : "7.blocks_missing",
                        {{"n", Word(got.size())}, {"i", Word(worst.first)}, {"j", Word(worst.second)}});
  Fail({"7",
        {"7.pattern_of_S", {{"scene", scene}}},
        {"7.blocks_expected", {{"n", Word(expected.size())}}},
        difference,
        CauseOf(got, groups, static_cast<int>(ordering.poses.size())),
        "7a"});
}

TEST(Stage7, TheBlocksOfS) {
  for (const bool fix_one : {false, true}) {
    GraphScene row("row", {fix_one});
    CheckPattern(*MakeSolver(&row.graph), row.graph, fix_one ? "7.row_one_fixed" : "7.row");
  }
}

TEST(Stage7, TheBlocksOfSWithoutLandmarks) {
  GraphScene row("row", {false});  // where there are blocks to find: who finds none passes nothing
  CheckPattern(*MakeSolver(&row.graph), row.graph, "7.row");
  GraphScene scene("without landmarks");
  CheckPattern(*MakeSolver(&scene.graph), scene.graph, "7.no_landmarks");
}

}  // namespace
}  // namespace ch5::homework
