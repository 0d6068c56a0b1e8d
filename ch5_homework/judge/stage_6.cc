/// Stage 6, TODOs 6a to 6c: VINS-Mono's MarginalizationInfo up to A and b. Its functions are called in their order, on
/// numbers without structure that could hide a mistake; the first failure ends the check. stage_6_prior.cc goes on.

#include <gtest/gtest.h>

#include "ch5_homework/judge/mistakes/stage_6.h"
#include "ch5_homework/judge/submission.h"

namespace ch5::homework {
namespace {

using namespace stage_6;

// ---- 6a, 6b PreMarginalize ----------------------------------------------------------------------------------------

TEST(Stage6, RemembersTheFreeBlocks) {
  const FactorScene scene;
  const auto term = scene.Fill();
  term->PreMarginalize();
  std::string right, got;
  const auto blocks = term->Blocks();
  for (const auto& vertex : scene.free) right += (right.empty() ? "" : ", ") + NameOf(*vertex);
  for (const auto& [id, block] : blocks) got += (got.empty() ? "" : ", ") + NameOf(*block.vertex);
  if (got != right) {
    FAIL() << Story("6", "the blocks after PreMarginalize, in order of id", right, got.empty() ? "none" : got,
                    blocks.empty()                        ? "no vertex was remembered"
                    : blocks.count(scene.fixed->Id()) > 0 ? "a fixed vertex has no columns in A"
                    : blocks.size() < scene.free.size()   ? "not every free vertex of every residual is there"
                                                          : "a block stands under the id of another vertex",
                    "6a");
  }
  for (const auto& [id, block] : blocks) {
    const VecX x = block.vertex->Parameters();
    ASSERT_EQ(block.vertex->Id(), id);
    if (Equal(block.x0, x, 0.0)) continue;
    FAIL() << Story("6", "the remembered state of " + NameOf(*block.vertex),
                    std::to_string(x.size()) + " numbers, its Parameters()",
                    block.x0.size() == x.size() ? "other numbers" : std::to_string(block.x0.size()) + " numbers",
                    "the state at which A is made is vertex->Parameters()", "6a");
  }
}

TEST(Stage6, EvaluatesEachResidual) {
  const FactorScene scene;
  const auto term = scene.Fill();
  term->PreMarginalize();
  for (const auto& factor : scene.factors) {
    if (scene.IsFresh(*factor.edge)) continue;
    FAIL() << Story("6", "the residual of " + factor.edge->TypeInfo() + " after PreMarginalize",
                    "r and J at the present states", "those of an older state, or only one of the two",
                    "edge->Linearize() makes both", "6a");
  }
}

// The first rows of the blocks in order of id, then m and n.
struct Layout {
  const FactorScene& scene;

  VecX Of(const std::vector<std::shared_ptr<Vertex>>& first, bool global = false) const {
    const auto goes = [&](const auto& v) { return std::find(first.begin(), first.end(), v) != first.end(); };
    const auto size = [&](const auto& v) { return global ? v->Parameters().size() : v->LocalDimension(); };
    VecX rows = VecX::Zero(static_cast<Eigen::Index>(scene.free.size()) + 2);
    double m = 0, n = 0;
    for (const auto& v : scene.free) m += goes(v) ? static_cast<double>(size(v)) : 0.0;
    double at_dropped = 0;
    for (size_t k = 0; k < scene.free.size(); ++k) {
      const auto& v = scene.free[k];
      double* at = goes(v) ? &at_dropped : &n;
      rows[k] = goes(v) ? *at : m + *at;
      *at += static_cast<double>(size(v));
    }
    rows.tail<2>() << m, n;
    return rows;
  }
  static std::function<MatXX()> Is(const VecX& x) {
    return [x] { return x; };
  }
  std::vector<Mistake> CountingMistakes() const {
    const VecX right = Of(scene.Dropped());
    VecX alike = right, alone = right, counted = right, all_again = right, late = right, from_zero = right;
    const auto dropped = scene.Dropped();
    double row = 0.0, number = 0.0, m = right[right.size() - 2];
    for (size_t k = 0; k < scene.free.size(); ++k) {
      const bool drops = std::find(dropped.begin(), dropped.end(), scene.free[k]) != dropped.end();
      const int size = scene.free[k]->LocalDimension();
      alike[k] = row;
      all_again[k] = m + row;
      counted[k] = number++;
      if (!drops) alone[k] = m;
      if (!drops) from_zero[k] -= m;
      late[k] += size;
      row += size;
    }
    all_again[right.size() - 1] = row;
    return {{"6b", "one loop numbers dropped and kept blocks alike: first all the dropped ones, then the others",
             Is(alike)},
            {"6b", "the second loop numbers the dropped blocks again: it is for the others", Is(all_again)},
            {"6b", "every kept block begins at m_: it is m_ + n_, and n_ grows with each", Is(alone)},
            {"6b", "a block is counted as one row: it has LocalDimension() rows", Is(counted)},
            {"6b", "no rows were given", Is(VecX::Zero(right.size()))},
            {"6b", "idx is set after the count has moved on; a block begins where the last one ended", Is(late)},
            {"6b", "the kept blocks begin at row 0; the dropped ones stand there: m_ + n_", Is(from_zero)}};
  }
  std::vector<Mistake> Mistakes() const {
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
    std::vector<Mistake> mistakes = CountingMistakes();
    const std::vector<Mistake> mistaken_blocks{
        {"6b", "Parameters().size() counts 7 for a pose; a row of A belongs to an increment: LocalDimension()",
         Is(Of(scene.Dropped(), true))},
        {"6b", "the kept blocks stand first; it is the dropped ones that do", Is(swapped)},
        {"6b", "the kept blocks stand first, and m_ and n_ are exchanged", Is(Of(scene.Kept()))},
        {"6a", "no block is dropped: the ids were not noted", Is(Of({}))},
        {"6a", "a position in drop_set was taken for an id: it is vertices[position]->Id()", Is(Of(at_positions))},
        {"6a", "every block is dropped, not only those in drop_set", Is(Of(scene.free))}};
    mistakes.insert(mistakes.end(), mistaken_blocks.begin(), mistaken_blocks.end());
    return mistakes;
  }
  Names RowNames() const {
    Names names;
    for (const auto& v : scene.free) names.push_back("the first row of " + NameOf(*v));
    names.push_back("m_");
    names.push_back("n_");
    return names;
  }
};

TEST(Stage6, NumbersTheDroppedBlocksFirst) {
  const FactorScene scene;
  const auto term = scene.Fill();
  for (int again = 0; again < 2; ++again) {  // the second time finds the numbers of the first
    term->PreMarginalize();
    const Layout layout{scene};
    const auto blocks = term->Blocks();
    ASSERT_EQ(blocks.size(), scene.free.size()) << "Stage 6: the number of blocks after PreMarginalize";
    VecX rows(layout.Of({}).size());
    int k = 0;
    for (const auto& [id, block] : blocks) rows[k++] = block.idx;
    rows.tail<2>() << *term->Inside().m, *term->Inside().n;
    ASSERT_NO_STORY({"6",
                     "the first rows of the blocks, and m_ and n_, after PreMarginalize",
                     layout.Of(scene.Dropped()),
                     rows,
                     layout.RowNames(),
                     layout.Mistakes(),
                     1e-12,
                     {},
                     "6b"});
    std::vector<int> right;
    for (const auto& vertex : scene.Kept()) right.push_back(vertex->Id());
    const std::vector<int>& got = *term->Inside().keep;
    if (got != right) {
      FAIL() << Story("6", "keep_ after PreMarginalize",
                      std::to_string(right.size()) + " ids, in the order of their rows",
                      std::to_string(got.size()) + " ids",
                      got.empty()                       ? "keep_.push_back(id) is missing"
                      : got.size() == scene.free.size() ? "keep_ holds the dropped blocks' ids too"
                      : got.size() < right.size()       ? "keep_ holds the dropped blocks' ids, or not all kept ones"
                                                        : "keep_ holds each kept block's id, once",
                      "6b");
    }
  }
}

// ---- 6c ConstructA ------------------------------------------------------------------------------------------------

void CheckA(const FactorScene& scene, const std::string& what) {
  const auto term = scene.Fill();
  term->PreMarginalize();
  term->ConstructA();
  const VinsTerm::Members got = term->Inside();
  const Names names = scene.RowNames();
  ASSERT_NO_STORY({"6", "b of " + what, scene.VectorB({}), *got.b, names, MistakesInB(scene), 1e-10, {}, "6c", "b_"});
  ASSERT_NO_STORY({"6", "A of " + what, scene.MatrixA({}), *got.A, names, MistakesInA(scene), 1e-10, {}, "6c", "A_"});
}

TEST(Stage6, AOfOneResidual) { CheckA(FactorScene(FactorScene::kOneEdge), "one residual between two poses"); }
TEST(Stage6, AOfManyResiduals) {
  CheckA(FactorScene(FactorScene::kNoLoss), "seven residuals without a loss, one vertex fixed");
}
TEST(Stage6, AOfRobustResiduals) { CheckA(FactorScene(), "seven residuals, three of them with a Cauchy loss"); }

}  // namespace
}  // namespace ch5::homework
