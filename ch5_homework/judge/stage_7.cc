/// Stage 7: which blocks S has, H and b in blocks, then S and Δx, each against a dense oracle.
/// From simple to hard; the first failure ends the check.

#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <map>
#include <numeric>
#include <set>

#include "ch5_homework/judge/ask.h"
#include "ch5_homework/judge/oracle.h"
#include "ch5_homework/judge/right/assembly.h"
#include "ch5_homework/judge/right/formulas.h"
#include "ch5_homework/judge/scenes/bundle.h"

namespace ch5::homework {
namespace {

// ---- 7a: the pattern of S ----------------------------------------------------------------------------------------

using Pattern = std::set<std::pair<int, int>>;

// The numbers of the free poses that edges have: of each landmark's edges together, and of each edge alone.
struct Groups {
  std::vector<std::vector<int>> of_landmarks, of_edges;

  Groups(const Graph& graph, const Ordering& ordering) {
    std::map<int, std::vector<int>> seen_by;  // by the landmarks' ids, which are in their order
    for (const auto& edge : graph.Edges()) {
      const Vertex* landmark = nullptr;
      std::vector<int>& poses = of_edges.emplace_back();
      for (const auto& vertex : edge->Vertices()) {
        if (vertex->IsFixed()) continue;
        if (vertex->GetRole() == Role::kLandmark) landmark = vertex.get();
        const auto it = std::find(ordering.poses.begin(), ordering.poses.end(), vertex);
        if (it != ordering.poses.end()) poses.push_back(static_cast<int>(it - ordering.poses.begin()));
      }
      if (landmark != nullptr)
        seen_by[landmark->Id()].insert(seen_by[landmark->Id()].end(), poses.begin(), poses.end());
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

struct WrongPattern {
  Text cause;
  Pattern pattern;  ///< beside the blocks of H_pp
};

std::vector<WrongPattern> TypicalPatterns(const Groups& groups, int poses) {
  size_t longest = 0;  // of the landmarks' lists
  for (const auto& group : groups.of_landmarks) {
    longest = std::max(longest, std::set<int>(group.begin(), group.end()).size());
  }
  std::vector<int> all(static_cast<size_t>(poses));
  std::iota(all.begin(), all.end(), 0);
  const std::vector<int> positions(all.begin(), all.begin() + static_cast<ptrdiff_t>(longest));
  const auto with = [&](const auto& partner) {
    std::vector<std::vector<int>> pairs;
    for (const auto& group : groups.of_landmarks) {
      for (size_t k = 0; k < group.size(); ++k) pairs.push_back({group[k], partner(group, k)});
    }
    return PairsOf(pairs, IsLower);
  };
  return {
      {"7.only_blocks_H_pp", {}},
      {"7.S_full", PairsOf({all}, IsLower)},
      {{"7.number_0_left_out", {{"it", {"scene.pose", {{"n", Word(0)}}}}}},
       PairsOf(groups.of_landmarks, [](int i, int j) { return i >= j && j > 0; })},
      {"7.wrong_half_stored", PairsOf(groups.of_landmarks, [](int i, int j) { return i <= j; })},
      {"7.both_halves_stored", PairsOf(groups.of_landmarks, [](int, int) { return true; })},
      {"7.positions_for_numbers", PairsOf({positions}, IsLower)},
      {"7.only_neighbors_tied", with([](const auto& group, size_t k) { return group[std::max<size_t>(k, 1) - 1]; })},
      {"7.only_one_pose_tied", with([](const auto& group, size_t) { return group.front(); })},
      {"7.only_one_pose_tied", with([](const auto& group, size_t) { return group.back(); })}};
}

Text CauseOf(const Pattern& got, const Groups& groups, int poses) {
  const Pattern H_pp = PairsOf(groups.of_edges, IsLower);
  std::vector<WrongPattern> wrong = TypicalPatterns(groups, poses);
  std::set<int> differences;
  for (const auto& [i, j] : got) {
    if (H_pp.count({i, j}) == 0) differences.insert(i - j);
  }
  if (differences.size() < 3) {  // more are not what was meant
    wrong.push_back({{"7.only_differences_tied", {{"n", Word(Join({differences.begin(), differences.end()}))}}},
                     PairsOf(groups.of_landmarks, [&](int i, int j) { return differences.count(i - j) > 0; })});
  }
  for (auto one = groups.of_landmarks.begin() + 1; one < groups.of_landmarks.end();
       ++one) {  // where a loop may begin or end
    wrong.push_back({"7.landmarks_left_out", PairsOf({groups.of_landmarks.begin(), one}, IsLower)});
    wrong.push_back({"7.landmarks_left_out", PairsOf({one, groups.of_landmarks.end()}, IsLower)});
  }
  for (auto& [cause, pattern] : wrong) {
    pattern.insert(H_pp.begin(), H_pp.end());
    if (got == pattern) return cause;
  }
  const auto is_any = [&](const auto& is) { return std::any_of(got.begin(), got.end(), is); };
  if (is_any([](const auto& block) { return block.first < block.second; })) return "7.block_above_diagonal_stored";
  const Pattern tied = PairsOf(groups.of_landmarks, IsLower);
  const bool untied = is_any([&](const auto& block) { return tied.count(block) + H_pp.count(block) == 0; });
  return untied ? "7.untied_poses" : "7.none_typical";
}

void CheckPattern(Scene* scene, const Text& words) {
  const Answer answer = Ask("BuildStructure", *scene);
  const MatXX blocks = answer.Sized("pattern", 2, answer["pattern"].cols());
  Pattern got;
  for (Eigen::Index k = 0; k < blocks.cols(); ++k) got.insert({Whole(blocks(0, k)), Whole(blocks(1, k))});
  const Ordering ordering = MakeOrdering(scene->GetGraph());
  const Groups groups(scene->GetGraph(), ordering);
  Pattern expected = PairsOf(groups.of_landmarks, IsLower);
  expected.merge(PairsOf(groups.of_edges, IsLower));
  if (got == expected) return;
  std::vector<std::pair<int, int>> missing, superfluous;
  std::set_difference(expected.begin(), expected.end(), got.begin(), got.end(), std::back_inserter(missing));
  std::set_difference(got.begin(), got.end(), expected.begin(), expected.end(), std::back_inserter(superfluous));
  const auto& worst = missing.empty() ? superfluous[0] : missing[0];
  const Text difference(missing.empty() ? "7.blocks_too_many" : "7.blocks_missing",
                        {{"n", Word(got.size())}, {"i", Word(worst.first)}, {"j", Word(worst.second)}});
  Fail({{"7.pattern_of_S", {{"scene", words}}},
        {"7.blocks_expected", {{"n", Word(expected.size())}}},
        difference,
        CauseOf(got, groups, static_cast<int>(ordering.poses.size())),
        "7a"});
}

TEST(Stage7, TheBlocksOfS) {
  for (const bool fix_one : {false, true}) {
    GraphScene row("row", {fix_one});
    CheckPattern(&row, fix_one ? "7.row_one_fixed" : "7.row");
  }
}

TEST(Stage7, TheBlocksOfSWithoutLandmarks) {
  GraphScene row("row", {false});  // with blocks to find: finding none must not pass
  CheckPattern(&row, "7.row");
  GraphScene scene("without landmarks");
  CheckPattern(&scene, "7.no_landmarks");
}

// ---- 7b, 7c: b and H ---------------------------------------------------------------------------------------------

// The number of a free vertex, as BlockIndexOf has it.
int NumberOf(const Vertex& vertex, const Ordering& ordering) {
  const auto& alike = vertex.GetRole() == Role::kPose ? ordering.poses : ordering.landmarks;
  const auto at = std::find_if(alike.begin(), alike.end(), [&](const auto& one) { return one.get() == &vertex; });
  return at == alike.end() ? -1 : static_cast<int>(at - alike.begin());
}

// Where a student may take a vertex's rows to begin, by its number.
std::vector<right::Loop::WrongRow> RowsByNumber(const Ordering& ordering) {
  const auto by = [&](const auto& row) {
    return [&ordering, row](const Edge& edge, size_t k) {
      const Vertex& v = *edge.Vertices()[k];
      return row(v, NumberOf(v, ordering));
    };
  };
  const auto pose_row = [&](const Vertex&, int number) {
    const bool is = number >= 0 && number < static_cast<int>(ordering.poses.size());
    return is ? ordering.poses[static_cast<size_t>(number)]->OrderingId() : -1;
  };
  return {{"7.number_for_first_row", by([](const Vertex&, int number) { return number; })},
          {"7.pose_row_for_landmark", by(pose_row)},
          {"7.number_times_size_for_row", by([](const Vertex& v, int number) { return number * v.LocalDimension(); })}};
}

std::vector<Text> PartsOfH(const Vertex& i, const Vertex& j) {
  const bool i_is_pose = i.GetRole() == Role::kPose, j_is_pose = j.GetRole() == Role::kPose;
  const auto blocks_of = [](const char* part) { return Text("7.blocks_of", {{"matrix", Word(std::string(part))}}); };
  if (!i_is_pose && !j_is_pose) return {blocks_of("H_ll")};
  if (!i_is_pose || !j_is_pose) return {blocks_of("H_pl")};
  return {&i == &j ? "7.diagonal_blocks_H_pp" : "7.off_diagonal_H_pp", blocks_of("H_pp")};
}

void CheckSystem(const MatXX& H, const VecX& b, const Graph& graph, const Text& scene) {
  const Ordering ordering = MakeOrdering(graph);
  right::Loop loop{graph.Edges(), ordering.Size(), -1.0};
  loop.wrong_rows = RowsByNumber(ordering);
  loop.parts_of = &PartsOfH;
  const right::AssembledSystem right(loop);
  const Names names = RowNames(ordering, true);
  Require({{"scene.b_of", {{"what", scene}}}, "7b", "b_", names}, right.b, b);
  Require({{"scene.H_of", {{"what", scene}}}, "7c", "H", names}, right.H, H);
}

void CheckSystem(Scene* scene, const Text& words, int times = 1) {
  const Answer got = Ask("BuildSystem", *scene, {{"times", times}});
  for (int k = 0; k < times; ++k) {
    const std::string number = " " + std::to_string(k);
    CheckSystem(got["H" + number], got.Vector("b" + number), scene->GetGraph(), words);
  }
}

TEST(Stage7, RightHandSideAndHessian) {
  for (const bool fix_one : {false, true}) {
    GraphScene row("row", {fix_one});
    CheckSystem(&row, fix_one ? "7.row_one_fixed" : "7.row");
  }
  GraphScene light("light row", {false}), heavy("heavy row", {false});
  CheckSystem(&light, "scene.light_row");
  CheckSystem(&heavy, "scene.heavy_row");
}

TEST(Stage7, HessianOfMixedLandmarksAndLosses) {
  GraphScene scene("mixed landmarks");
  CheckSystem(&scene, "7.mixed_landmarks", /*times=*/2);  // the second time H is not empty at the start
}

// ---- 7d, 7e: S and Δx --------------------------------------------------------------------------------------------

struct Call {
  double lambda;
  Damping damping;
};

void CheckCall(const Solved& got, const Call& call, const Graph& graph, const Text& scene) {
  const double lambda = call.lambda;  // bound names may not enter a lambda
  const Damping damping = call.damping;
  const auto& [solved, delta_x, b_S, b, S, H] = got;
  const Ordering ordering = MakeOrdering(graph);
  const System system = StackedNormalEquations(graph, ordering.Size());
  const auto with = [&](const Text& quantity) { return right::With(quantity, scene, lambda, damping); };
  const Names names = RowNames(ordering, true);
  const right::BlockSolve right(system, ordering, lambda, damping);
  Require({with(Word("b_p − Σ_l H_pl H_ll⁻¹ b_l")), "7d", "b_schur_", names, 1e-9}, right.b_S, b_S);
  Require({with(Word("S = H_pp − Σ_l H_pl H_ll⁻¹ H_plᵀ")), "7d", "S_", names, 1e-9}, right.S, S);
  if (!solved) {
    Fail({with(Word("Δx")), "7.solver_returns_true", Word("false"), "7.function_gave_up", "7d"});
  }
  Require({with(Word("Δx")), "7e", "delta_x", names, 1e-8}, right.delta_x, delta_x);
  Require({with("7.H_after_solve"), {}, {}, names, 1e-9, {{"7d", right::ChangedInPlace("H", "S_"), H}}}, system.H, H);
  if (!Equal(b, system.b, 1e-9)) {
    const int p = ordering.dim_poses;
    Fail({with("7.b_after_solve"), "7.b_unchanged", "7.another_b", right::ChangedInPlace("b_", "b_schur_, rest"),
          b.size() >= p && Equal(b.head(p), system.b.head(p), 1e-9) ? "7e" : "7d"});
  }
}

// Calls of one solver, one after the other. @return the answer, for what else was asked
Answer CheckSolve(Scene* scene, const std::vector<Call>& calls, const Text& words, Values given = {}) {
  VecX lambdas(calls.size()), dampings(calls.size());
  for (size_t k = 0; k < calls.size(); ++k) {
    lambdas[static_cast<Eigen::Index>(k)] = calls[k].lambda;
    dampings[static_cast<Eigen::Index>(k)] = static_cast<double>(calls[k].damping);
  }
  given.Put("lambdas", lambdas);
  given.Put("dampings", dampings);
  Answer answer = Ask("Solve", *scene, given);
  for (size_t k = 0; k < calls.size(); ++k) CheckCall({answer, k}, calls[k], scene->GetGraph(), words);
  return answer;
}

TEST(Stage7, SchurComplementAndStep) {
  for (const bool fix_one : {false, true}) {
    GraphScene row("row", {fix_one});
    CheckSolve(&row, {{0.0, Damping::kIdentity}}, fix_one ? "7.row_one_fixed" : "7.row");
  }
  GraphScene light("light row", {false});
  CheckSolve(&light, {{0.0, Damping::kIdentity}}, "scene.light_row");
  GraphScene scene("poses of two sizes");
  CheckSolve(&scene, {{0.0, Damping::kIdentity}}, "7.poses_of_two_sizes");
  GraphScene heavy("heavy row", {false});
  CheckSolve(&heavy, {{0.0, Damping::kIdentity}}, "scene.heavy_row");
}

TEST(Stage7, LambdaOnEveryDiagonalEntry) {
  GraphScene row("row", {false});
  std::vector<Call> calls;
  for (const double lambda : {10.0, 1e-3, 0.5}) {
    for (const Damping damping : {Damping::kIdentity, Damping::kDiagonal}) calls.push_back({lambda, damping});
  }
  CheckSolve(&row, calls, "7.row");
}

TEST(Stage7, LandmarksOrPosesAlone) {
  for (const bool landmarks : {true, false}) {
    GraphScene row("row", {false});
    for (const auto& pose : row.poses) pose->SetFixed(landmarks);
    for (const auto& point : row.points) point->SetFixed(!landmarks);
    CheckSolve(&row, {{0.1, Damping::kIdentity}}, landmarks ? "7.only_points" : "7.only_poses");
  }
}

TEST(Stage7, BundleAdjustmentOfTheCourse) {
  const int frames = Vary(9, 12, 76);  // more than the row's
  BundleScene scene(frames, Vary(20, 30, 74), true);
  const Text words("7.course_scene", {{"n", Word(frames)}});
  const Answer end = CheckSolve(&scene, {{1e-2, Damping::kIdentity}}, words, {{"minimize", true}});
  const double before = Cost(scene.ba.graph);
  scene.SetStates(end.Vector("states"));
  const double after = Cost(scene.ba.graph);
  const std::string message = end.Word("message").substr(0, 200);
  if (end.Number("converged") == 0.0 || !(after <= 1e-2 * before)) {
    Fail({"7.course_scene_solved", "7.converged",
          Text("7.ended_at", {{"message", Text::Quoted(message)}, {"a", Word(after)}, {"b", Word(before)}}),
          "7.something_kept_between_calls", ""});
  }
}

}  // namespace
}  // namespace ch5::homework
