/// Stage 6, TODOs 6a to 6c: VINS-Mono's MarginalizationInfo up to A and b. Its functions are called in their order, on
/// numbers without structure that could hide a mistake; the first failure ends the check. stage_6_prior.cc goes on.

#include <gtest/gtest.h>

#include "ch5_homework/judge/right/assembly.h"
#include "ch5_homework/judge/stage_6_scene.h"

namespace ch5::homework {
namespace {

// ---- 6a, 6b PreMarginalize ----------------------------------------------------------------------------------------

struct Block {
  int id, idx;
  std::shared_ptr<Vertex> vertex;
  VecX x0;
};
// What PreMarginalize has left.
struct Evaluated {
  std::vector<Block> blocks;
  VecX fresh, keep;
  double m, n;

  Evaluated(FactorScene* scene, int times) {
    const Answer answer = Ask("PreMarginalize", *scene, {{"times", times}});
    const MatXX rows = answer.Sized("blocks", 3, answer["blocks"].cols());
    for (int k = 0; k < rows.cols(); ++k) {
      const VecX one = rows.col(k);
      blocks.push_back({Whole(one[0]), Whole(one[2]), scene->At(one[1]), answer.Vector("x0 " + std::to_string(k))});
    }
    fresh = answer.Sized("fresh", static_cast<Eigen::Index>(scene->factors.size()), 1);
    keep = answer.Vector("keep");
    m = answer.Number("m");
    n = answer.Number("n");
  }
};

TEST(Stage6, RemembersTheFreeBlocks) {
  FactorScene scene;
  const std::vector<Block> blocks = Evaluated(&scene, 1).blocks;
  std::string right, got;
  for (const auto& vertex : scene.free) right += (right.empty() ? "" : ", ") + vertex->Name();
  for (const Block& block : blocks) got += (got.empty() ? "" : ", ") + block.vertex->Name();
  const auto has = [&](const auto& is) { return std::any_of(blocks.begin(), blocks.end(), is); };
  const bool misplaced = has([](const Block& block) { return block.vertex->Id() != block.id; });
  if (misplaced || got != right) {
    const bool with_fixed = has([&](const Block& block) { return block.id == scene.fixed->Id(); });
    Fail({"6", "6.blocks_remembered", Word(right), got.empty() ? "6.none" : Word(got),
          blocks.empty() ? "6.no_vertex_remembered"
          : misplaced    ? "6.block_under_wrong_id"
          : with_fixed   ? "6.fixed_vertex_no_columns"
                         : "6.free_vertex_missing",
          "6a"});
  }
  for (const Block& block : blocks) {
    const VecX x = block.vertex->Parameters();
    if (Equal(block.x0, x, 0.0)) continue;
    Fail({"6", Text("6.remembered_state", {{"vertex", Word(block.vertex->Name())}}),
          Text("6.numbers_parameters", {{"n", Word(x.size())}}),
          block.x0.size() == x.size() ? "6.other_numbers" : Text("6.numbers", {{"n", Word(block.x0.size())}}),
          "6.x0_is_parameters", "6a"});
  }
}

TEST(Stage6, EvaluatesEachResidual) {
  FactorScene scene;
  const Evaluated evaluated(&scene, 1);
  for (size_t k = 0; k < scene.factors.size(); ++k) {
    if (evaluated.fresh[static_cast<Eigen::Index>(k)] == 1.0) continue;
    Fail({"6", Text("6.residual_evaluated", {{"edge", Word(scene.factors[k].edge->TypeInfo())}}),
          "6.r_J_present_states", "6.those_older_state", "6.edge_linearize", "6a"});
  }
}

// The first rows of the blocks in order of id, then m and n.
struct Layout {
  const FactorScene& scene;

  using SizeOf = Eigen::Index (*)(const Vertex&);
  static Eigen::Index LocalSize(const Vertex& v) { return v.LocalDimension(); }
  static Eigen::Index GlobalSize(const Vertex& v) { return v.Parameters().size(); }
  static Eigen::Index One(const Vertex&) { return 1; }
  static Eigen::Index OneMore(const Vertex& v) { return v.LocalDimension() + 1; }
  static Eigen::Index OneLess(const Vertex& v) { return v.LocalDimension() - 1; }
  static Eigen::Index Six(const Vertex&) { return 6; }

  /// @param of_first, of_others  how many rows a block counts
  /// @param m_assigned, n_assigned  m_ or n_ is set to the rows of a block, not raised by them
  VecX Of(const std::vector<std::shared_ptr<Vertex>>& first, SizeOf of_first = &LocalSize,
          SizeOf of_others = &LocalSize, bool m_assigned = false, bool n_assigned = false) const {
    VecX rows = VecX::Zero(static_cast<Eigen::Index>(scene.free.size()) + 2);
    Eigen::Index m = 0, n = 0;
    for (const bool goes : {true, false}) {
      for (size_t k = 0; k < scene.free.size(); ++k) {
        const auto& v = scene.free[k];
        if ((std::find(first.begin(), first.end(), v) != first.end()) != goes) continue;
        rows[k] = static_cast<double>(m + n);
        Eigen::Index& count = goes ? m : n;
        count = (goes ? of_first : of_others)(*v) + ((goes ? m_assigned : n_assigned) ? 0 : count);
      }
    }
    rows.tail<2>() << static_cast<double>(m), static_cast<double>(n);
    return rows;
  }
  bool Drops(size_t k) const {
    const auto dropped = scene.Dropped();
    return std::find(dropped.begin(), dropped.end(), scene.free[k]) != dropped.end();
  }
  std::vector<Mistake> CountingMistakes() const {
    const VecX right = Of(scene.Dropped());
    VecX alike = right, running = right, alone = right, all_again = right, from_zero = right, kept_in_m = right;
    VecX late = right, late_dropped = right, late_kept = right, both_loops = right, copies = VecX::Zero(right.size());
    copies.tail<2>() = right.tail<2>();
    kept_in_m.tail<2>() << right.tail<2>().sum(), 0.0;
    const auto dropped = scene.Dropped();
    double row = 0.0, row_dropped = 0.0, row_kept = 0.0, m = right[right.size() - 2], all = right.tail<2>().sum();
    for (size_t k = 0; k < scene.free.size(); ++k) {
      const bool drops = Drops(k);
      const int size = scene.free[k]->LocalDimension();
      alike[k] = row;
      running[k] = drops ? row_dropped : row;
      all_again[k] = m + row;
      if (!drops) alone[k] = m;
      if (!drops) from_zero[k] -= m;
      late[k] += size;
      (drops ? late_dropped : late_kept)[k] += size;
      both_loops[k] = drops ? row : all + row_kept;
      row += size;
      (drops ? row_dropped : row_kept) += size;
    }
    all_again[right.size() - 1] = row;
    both_loops[right.size() - 2] = all;
    return {{"6b", "6.one_loop_for_both", alike},
            {"6b", "6.one_loop_for_both", running},
            {"6b", "6.numbered_in_both_loops", all_again},
            {"6b", "6.numbered_in_both_loops", both_loops},
            {"6b", "6.every_kept_block_begins_m", alone},
            {"6b", {"6.block_counts", {{"n", Word(1)}}}, Of(dropped, &One, &One)},
            {"6b", {"6.block_counts", {{"n", Word(6)}}}, Of(dropped, &Six, &Six)},
            {"6b", {"6.count_assigned", {{"it", Word("m_")}}}, Of(dropped, &LocalSize, &LocalSize, true)},
            {"6b", {"6.count_assigned", {{"it", Word("n_")}}}, Of(dropped, &LocalSize, &LocalSize, false, true)},
            {"6b", {"6.count_assigned", {{"it", Word("m_, n_")}}}, Of(dropped, &LocalSize, &LocalSize, true, true)},
            {"6b", "6.no_rows_given", VecX::Zero(right.size())},
            {"6b", "6.idx_written_to_copy", copies},
            {"6b", "6.kept_rows_counted_in_m", kept_in_m},
            {"6b", "6.idx_set_after_count_moved", late},
            {"6b", "6.idx_set_after_count_moved", late_dropped},
            {"6b", "6.idx_set_after_count_moved", late_kept},
            {"6b", "6.kept_begin_at_zero", from_zero}};
  }
  std::vector<Mistake> OffByOneMistakes() const {
    const auto dropped = scene.Dropped();
    const VecX right = Of(dropped), none = VecX::Zero(right.size());
    VecX of_dropped = none, of_kept = none;
    for (size_t k = 0; k < scene.free.size(); ++k) (Drops(k) ? of_dropped : of_kept)[k] = 1.0;
    const Text cause = "6.off_by_one";
    std::vector<Mistake> mistakes;
    for (const VecX& shift : {of_dropped, of_kept, VecX(of_dropped + of_kept)}) {
      mistakes.push_back({"6b", cause, right + shift});
      mistakes.push_back({"6b", cause, right - shift});
    }
    for (const SizeOf other : {&OneMore, &OneLess}) {
      mistakes.push_back({"6b", cause, Of(dropped, other)});
      mistakes.push_back({"6b", cause, Of(dropped, &LocalSize, other)});
      mistakes.push_back({"6b", cause, Of(dropped, other, other)});
    }
    return mistakes;
  }
  std::vector<Mistake> Mistakes(const VecX& got) const {
    VecX swapped = Of(scene.Kept());
    swapped.tail<2>().reverseInPlace();
    std::vector<std::shared_ptr<Vertex>> at_positions;  // ids that happen to be positions
    for (const auto& factor : scene.factors) {
      for (const int position : factor.drop_set) {
        for (const auto& v : scene.free) {
          if (v->Id() == position) at_positions.push_back(v);
        }
      }
    }
    std::vector<std::shared_ptr<Vertex>> first;  // those that are numbered as dropped, whichever they are
    for (size_t k = 0; k < scene.free.size(); ++k) {
      if (got[k] < got[got.size() - 2]) first.push_back(scene.free[k]);
    }
    std::vector<Mistake> mistakes = CountingMistakes(), off_by_one = OffByOneMistakes();
    const std::vector<Mistake> mistaken_blocks{
        {"6b", "6.parameters_size_for_local_dimension", Of(scene.Dropped(), &GlobalSize, &GlobalSize)},
        {"6b", "6.parameters_size_for_local_dimension", Of(scene.Dropped(), &GlobalSize, &LocalSize)},
        {"6b", "6.parameters_size_for_local_dimension", Of(scene.Dropped(), &LocalSize, &GlobalSize)},
        {"6b", "6.blocks_for_rows", Of(scene.Dropped(), &One)},
        {"6b", "6.kept_first", swapped},
        {"6b", "6.kept_first_m_n_exchanged", Of(scene.Kept())},
        {"6a", "6.no_block_dropped", Of({})},
        {"6a", "6.position_for_id", Of(at_positions)},
        {"6a", "6.every_block_dropped", Of(scene.free)},
        {"6a", "6.other_blocks_dropped", Of(first)}};
    for (const auto& more : {mistaken_blocks, off_by_one}) mistakes.insert(mistakes.end(), more.begin(), more.end());
    return mistakes;
  }
  Names RowNames() const {
    Names names;
    for (const auto& v : scene.free) names.push_back({"6.first_row", {{"vertex", Word(v->Name())}}});
    names.push_back(Word("m_"));
    names.push_back(Word("n_"));
    return names;
  }
};

TEST(Stage6, NumbersTheDroppedBlocksFirst) {
  FactorScene scene;
  for (const int times : {1, 2}) {  // the second time finds the numbers of the first
    const Evaluated evaluated(&scene, times);
    const Layout layout{scene};
    const auto& blocks = evaluated.blocks;
    if (blocks.size() != scene.free.size()) Fail({"6", "6.number_of_blocks"});
    VecX rows(layout.Of({}).size());
    int k = 0;
    for (const Block& block : blocks) rows[k++] = block.idx;
    rows.tail<2>() << evaluated.m, evaluated.n;
    Require(
        "6", "6.first_rows_blocks", layout.Of(scene.Dropped()), rows, layout.RowNames(),
        [&] { return layout.Mistakes(rows); }, 1e-12, "6b");
    std::vector<int> right, got;
    for (const auto& vertex : scene.Kept()) right.push_back(vertex->Id());
    for (const double id : evaluated.keep) got.push_back(Whole(id));
    if (got != right) {
      std::vector<int> first_rows;
      for (const Block& block : blocks) {
        if (std::count(right.begin(), right.end(), block.id) > 0) first_rows.push_back(block.idx);
      }
      Fail({"6", "6.keep", Text("6.ids_order_rows", {{"ids", Word(Join(right))}}), Word(Join(got)),
            got.empty()                       ? "6.keep_push_back"
            : got == first_rows               ? "6.keep_holds_rows"
            : got.size() == scene.free.size() ? "6.keep_holds_dropped_blocks_ids"
            : got.size() < right.size()       ? "6.keep_holds_other_ids"
            : std::is_permutation(got.begin(), got.end(), right.begin(), right.end()) ? "6.keep_in_another_order"
                                                                                      : "6.keep_holds_ids_twice",
            "6b"});
    }
  }
}

// ---- 6c ConstructA ------------------------------------------------------------------------------------------------

void CheckA(FactorScene::Kind kind, const Text& what) {
  FactorScene scene(kind);
  const Answer got = Ask("ConstructA", scene);
  right::Loop loop{scene.Edges(), static_cast<int>(scene.Right().b.size()), 1.0};
  loop.row_of = [&](const Edge& edge, size_t k) { return scene.RowOf(*edge.Vertices()[k]); };
  const right::AssembledSystem right(loop);
  const Names names = scene.RowNames();
  Require({"6", {"scene.b_of", {{"what", what}}}, "6c", "b_", names}, right.b, got["b"]);
  Require({"6", {"6.A_of", {{"what", what}}}, "6c", "A_", names}, right.H, got["A"]);
}

TEST(Stage6, AOfOneResidual) { CheckA(FactorScene::kOneEdge, "6.one_residual_between_two_poses"); }
TEST(Stage6, AOfManyResiduals) { CheckA(FactorScene::kNoLoss, "6.seven_residuals_without_loss"); }
TEST(Stage6, AOfRobustResiduals) { CheckA(FactorScene::kRobust, "6.seven_residuals"); }

}  // namespace
}  // namespace ch5::homework
