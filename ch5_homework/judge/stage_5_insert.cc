/// Stage 5.1: room for a new block. These tests run first; stage_5.cc has the others.

#include <gtest/gtest.h>

#include "ch5_homework/judge/narrate.h"
#include "ch5_homework/judge/scenes.h"
#include "ch5_homework/judge/submission.h"

namespace ch5::homework {
namespace {

// H and b₀ before, and where the new block goes.
struct Insertion {
  MatXX H;
  VecX b0;
  int idx, dim;

  int Tail() const { return static_cast<int>(H.rows()) - idx; }

  /// What stands in one of the four parts: nothing, the right block of H at its place or at another, or another block.
  enum Part { kRight, kMissing, kNotMoved, kWrongSource };
  MatXX Opened(Part H_00 = kRight, Part H_01 = kRight, Part H_10 = kRight, Part H_11 = kRight) const {
    const int tail = Tail(), end = idx + dim;
    MatXX opened = MatXX::Zero(H.rows() + dim, H.rows() + dim);
    const auto copy = [&](Part part, int row, int column, int rows, int columns, int moved_row, int moved_column,
                          int other_row, int other_column) {
      if (part == kMissing) return;
      const bool fits = other_row + rows <= H.rows() && other_column + columns <= H.cols();
      const MatXX source = part == kWrongSource && fits ? H.block(other_row, other_column, rows, columns)
                                                        : H.block(row, column, rows, columns);
      if (part == kNotMoved) {
        opened.block(row, column, rows, columns) = source;
      } else {
        opened.block(moved_row, moved_column, rows, columns) = source;
      }
    };
    copy(H_00, 0, 0, idx, idx, 0, 0, 0, 0);
    copy(H_01, 0, idx, idx, tail, 0, end, idx, 0);
    copy(H_10, idx, 0, tail, idx, end, 0, 0, idx);
    copy(H_11, idx, idx, tail, tail, end, end, 0, 0);
    return opened;
  }

  std::vector<Mistake> Mistakes() const {
    const auto is = [this](Part a, Part b, Part c, Part d) { return [=] { return Opened(a, b, c, d); }; };
    const Part no = kMissing, ok = kRight;
    std::vector<Mistake> mistakes{
        {"5.1", "nothing was copied: the old H is lost", is(no, no, no, no)},
        {"5.1", "H_00 alone was copied; the three parts of the tail are missing", is(ok, no, no, no)},
        {"5.1", "nothing has made room: the new block stands behind everything, but its place is at idx",
         is(ok, kNotMoved, kNotMoved, kNotMoved)},
        {"5.1", "H_01 and H_01ᵀ are missing: the dense part and the tail no longer know each other",
         is(ok, no, no, ok)},
        {"5.1", "H_01 and H_01ᵀ are exchanged: H_01, right of the new columns, has the dense part's rows",
         is(ok, kWrongSource, kWrongSource, ok)}};
    const std::vector<std::string> of_00{"", "H_00, the dense part, is missing"},
        of_01{"", "H_01, right of the new columns, is missing",
              "H_01 has made no room: it starts at column idx instead of idx + dim",
              "H_01 holds its transpose: it is read from row 0, column idx"},
        of_10{"", "H_01ᵀ, below the new rows, is missing",
              "H_01ᵀ has made no room: it starts at row idx instead of idx + dim",
              "H_01ᵀ holds H_01: it is read from row idx, column 0"},
        of_11{"", "the tail's corner H_11 is missing",
              "the tail's corner has made no room: it starts at idx instead of idx + dim",
              "the tail's corner holds H_00: H_11 is read from row and column idx on"};
    for (size_t a = 0; a < of_00.size(); ++a) {
      for (size_t b = 0; b < of_01.size(); ++b) {
        for (size_t c = 0; c < of_10.size(); ++c) {
          for (size_t d = 0; d < of_11.size(); ++d) {
            const std::string& cause = a ? of_00[a] : (b ? of_01[b] : (c ? of_10[c] : of_11[d]));
            if (!cause.empty()) mistakes.push_back({"5.1", cause, is(Part(a), Part(b), Part(c), Part(d))});
          }
        }
      }
    }
    MatXX known = Opened();
    known.block(idx, idx, dim, dim).setIdentity();
    mistakes.push_back(
        {"5.1", "the new block holds an identity, which nobody has measured: it is zero", [known] { return known; }});
    return mistakes;
  }

  VecX OpenedB() const {
    VecX b = VecX::Zero(b0.size() + dim);
    b.head(idx) = b0.head(idx);
    b.tail(Tail()) = b0.tail(Tail());
    return b;
  }

  std::vector<Mistake> MistakesInB() const {
    const auto changed = [this](int at, const VecX& part) {
      VecX b = VecX::Zero(b0.size() + dim);
      b.head(idx) = b0.head(idx);
      b.segment(at, part.size()) = part;
      return b;
    };
    return {{"5.1", "b0 was not copied", [this] { return VecX::Zero(OpenedB().size()); }},
            {"5.1", "the tail of b0 is missing", [=] { return changed(0, b0.head(idx)); }},
            {"5.1", "the beginning of b0 is missing",
             [this] {
               VecX b = OpenedB();
               b.head(idx).setZero();
               return b;
             }},
            {"5.1", "b0 has made no room: its tail starts at idx instead of idx + dim",
             [=] { return changed(idx, b0.tail(Tail())); }},
            {"5.1", "b0's tail holds its beginning: it is read from entry idx on",
             [=] { return Tail() <= idx ? changed(idx + dim, b0.head(Tail())) : OpenedB(); }}};
  }
};

int Rows(const std::vector<std::shared_ptr<Vertex>>& vertices) {
  int rows = 0;
  for (const auto& vertex : vertices) rows += vertex->LocalDimension();
  return rows;
}

void CheckOpened(const Insertion& c, const OkvisTerm::Members& inside, const Names& names, const std::string& scene) {
  ASSERT_NO_STORY(
      {"5", "H after InsertBlock: " + scene, c.Opened(), *inside.H, names, c.Mistakes(), 1e-10, {}, "5.1", "H"});
  ASSERT_NO_STORY(
      {"5", "b0 after InsertBlock: " + scene, c.OpenedB(), *inside.b0, names, c.MistakesInB(), 1e-10, {}, "5.1", "b0"});
}

/// A term over poses and landmarks with random numbers, and one more vertex to come.
void CheckInsertion(const std::vector<std::shared_ptr<Vertex>>& dense,
                    const std::vector<std::shared_ptr<Vertex>>& landmarks, const std::shared_ptr<Vertex>& coming,
                    const std::string& scene) {
  Graph graph;
  for (const auto* vertices : {&dense, &landmarks}) {
    for (const auto& vertex : *vertices) graph.AddVertex(vertex);
  }
  graph.AddVertex(coming);
  const bool is_landmark = coming->GetRole() == Role::kLandmark;
  Ordering after;  // only for the names of rows
  after.poses = dense;
  after.landmarks = landmarks;
  (is_landmark ? after.landmarks : after.poses).push_back(coming);

  Random random(Seed(31));
  const int dense_size = Rows(dense), size = dense_size + Rows(landmarks);
  const Insertion c{RandomPositiveDefinite(size, &random), RandomMatrix(size, 1, &random),
                    is_landmark ? size : dense_size, coming->LocalDimension()};
  const auto term = Chosen().make_okvis_term();
  const OkvisTerm::Members inside = term->Inside();
  *inside.H = c.H;
  *inside.b0 = c.b0;
  *inside.dense_size = dense_size;
  const int row = term->InsertBlock(c.dim, is_landmark);

  CheckOpened(c, inside, RowNames(after), scene);
  if (::testing::Test::HasFatalFailure()) return;
  if (*inside.dense_size != dense_size) {
    FAIL() << Story("5", "dense_size_ after InsertBlock: " + scene, std::to_string(dense_size) + ", as before",
                    std::to_string(*inside.dense_size),
                    "dense_size_ grows twice: who calls InsertBlock counts the new rows, InsertBlock only makes room",
                    "5.1");
  }
  ASSERT_EQ(row, c.idx) << "Stage 5: InsertBlock returns the first row of the new block; that line was right";
}

std::shared_ptr<Vertex> Pose() { return std::make_shared<VertexPose>(); }
std::shared_ptr<Vertex> Point() { return std::make_shared<VertexPointXYZ>(Vec3(1, 2, 5)); }
std::shared_ptr<Vertex> Depth() { return std::make_shared<VertexInverseDepth>(0.2); }
std::shared_ptr<Vertex> SpeedBias() { return std::make_shared<VertexSpeedBias>(); }

TEST(Stage5, InsertsAPoseBetweenPartsOfOneSize) {  // first: here no assertion betrays an exchange
  CheckInsertion({Pose()}, {Point(), Point()}, Pose(), "a pose comes, 6 rows of a pose and 6 of two points are there");
}
TEST(Stage5, InsertsASpeedAndBias) {
  CheckInsertion({Pose(), Pose()}, {Depth(), Point()}, SpeedBias(),
                 "a speed and bias comes, two poses and two landmarks are there");
}
TEST(Stage5, AppendsALandmark) {
  CheckInsertion({Pose(), SpeedBias()}, {Point(), Depth()}, Point(), "a landmark comes, to the end");
}
TEST(Stage5, InsertsTheFirstBlocks) {
  CheckInsertion({}, {}, Pose(), "a pose comes, nothing is there");
  if (HasFatalFailure()) return;
  CheckInsertion({}, {Depth(), Depth()}, Pose(), "a pose comes, only two landmarks are there");
}

}  // namespace
}  // namespace ch5::homework
