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
      blocks.push_back({Whole(one[0]), Whole(one[2]), scene->At(one[1]), answer.Vector(Numbered("x0", k))});
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
    Fail({"6.blocks_remembered", Word(right), got.empty() ? "6.none" : Word(got),
          blocks.empty() ? "6.no_vertex_remembered"
          : misplaced    ? "6.block_under_wrong_id"
          : with_fixed   ? "6.fixed_vertex_no_columns"
                         : "6.free_vertex_missing",
          "6a"});
  }
  for (const Block& block : blocks) {
    const VecX x = block.vertex->Parameters();
    if (Equal(block.x0, x, 0.0)) continue;
    Fail({Text("6.remembered_state", {{"vertex", Word(block.vertex->Name())}}),
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
    Fail({Text("6.residual_evaluated", {{"edge", Word(scene.factors[k].edge->TypeInfo())}}), "6.r_J_present_states",
          "6.those_older_state", "6.edge_linearize", "6a"});
  }
}

right::Numbering NumberingOf(const FactorScene& scene, const std::vector<bool>& dropped) {
  VecX sizes(scene.free.size()), parameters = sizes;
  for (Eigen::Index k = 0; k < sizes.size(); ++k) {
    const Vertex& v = *scene.free[static_cast<size_t>(k)];
    sizes[k] = v.LocalDimension();
    parameters[k] = static_cast<double>(v.Parameters().size());
  }
  return {sizes, parameters, dropped};
}

// The right numbering of other blocks.
Mistakes WrongBlocks(const FactorScene& scene, const VecX& got) {
  const size_t n = scene.free.size();
  std::vector<bool> at_positions(n), first(n);  // ids that happen to be positions; the blocks numbered as dropped
  for (size_t k = 0; k < n; ++k) {
    for (const auto& factor : scene.factors) {
      const auto& positions = factor.drop_set;
      at_positions[k] = at_positions[k] || std::count(positions.begin(), positions.end(), scene.free[k]->Id()) > 0;
    }
    first[k] = got[static_cast<Eigen::Index>(k)] < got[got.size() - 2];
  }
  const auto of = [&](const std::vector<bool>& dropped) { return Value(NumberingOf(scene, dropped).rows.right); };
  return {{"6a", "6.no_block_dropped", of(std::vector<bool>(n, false))},
          {"6a", "6.position_for_id", of(at_positions)},
          {"6a", "6.every_block_dropped", of(std::vector<bool>(n, true))},
          {"6a", "6.other_blocks_dropped", of(first)}};
}

void CheckKeep(const FactorScene& scene, const Evaluated& evaluated) {
  std::vector<int> right, got;
  for (const auto& vertex : scene.Kept()) right.push_back(vertex->Id());
  for (const double id : evaluated.keep) got.push_back(Whole(id));
  if (got == right) return;
  std::vector<int> first_rows;
  for (const Block& block : evaluated.blocks) {
    if (std::count(right.begin(), right.end(), block.id) > 0) first_rows.push_back(block.idx);
  }
  Fail({"6.keep", Text("6.ids_order_rows", {{"ids", Word(Join(right))}}), Word(Join(got)),
        got.empty()                                                               ? "6.keep_push_back"
        : got == first_rows                                                       ? "6.keep_holds_rows"
        : got.size() == scene.free.size()                                         ? "6.keep_holds_dropped_blocks_ids"
        : got.size() < right.size()                                               ? "6.keep_holds_other_ids"
        : std::is_permutation(got.begin(), got.end(), right.begin(), right.end()) ? "6.keep_in_another_order"
                                                                                  : "6.keep_holds_ids_twice",
        "6b"});
}

TEST(Stage6, NumbersTheDroppedBlocksFirst) {
  FactorScene scene;
  for (const int times : {1, 2}) {  // the second time finds the numbers of the first
    const Evaluated evaluated(&scene, times);
    const auto& blocks = evaluated.blocks;
    if (blocks.size() != scene.free.size()) Fail({"6.number_of_blocks"});
    VecX rows(blocks.size() + 2);
    std::vector<bool> dropped;
    Names names;
    for (size_t k = 0; k < blocks.size(); ++k) {
      const auto& v = scene.free[k];
      const auto gone = scene.Dropped();
      rows[static_cast<Eigen::Index>(k)] = blocks[k].idx;
      dropped.push_back(std::find(gone.begin(), gone.end(), v) != gone.end());
      names.push_back({"6.first_row", {{"vertex", Word(v->Name())}}});
    }
    rows.tail<2>() << evaluated.m, evaluated.n;
    names.push_back(Word("m_"));
    names.push_back(Word("n_"));
    Require({"6.first_rows_blocks", "6b", {}, names, 1e-12, {}, WrongBlocks(scene, rows)},
            NumberingOf(scene, dropped).rows, rows);
    CheckKeep(scene, evaluated);
  }
}

// ---- 6c ConstructA ------------------------------------------------------------------------------------------------

void CheckA(FactorScene::Kind kind, const Text& what) {
  FactorScene scene(kind);
  const Answer got = Ask("ConstructA", scene);
  right::Loop loop{scene.Edges(), static_cast<int>(scene.Right().b.size()), 1.0, "A"};
  loop.row_of = [&](const Edge& edge, size_t k) { return scene.RowOf(*edge.Vertices()[k]); };
  const right::AssembledSystem right(loop);
  const Names names = scene.RowNames();
  Require({{"scene.b_of", {{"what", what}}}, "6c", "b_", names}, right.b, got["b"]);
  Require({{"6.A_of", {{"what", what}}}, "6c", "A_", names}, right.H, got["A"]);
}

TEST(Stage6, AOfOneResidual) { CheckA(FactorScene::kOneEdge, "6.one_residual_between_two_poses"); }
TEST(Stage6, AOfManyResiduals) { CheckA(FactorScene::kNoLoss, "6.seven_residuals_without_loss"); }
TEST(Stage6, AOfRobustResiduals) { CheckA(FactorScene::kRobust, "6.seven_residuals"); }

}  // namespace
}  // namespace ch5::homework
