/// Stage 5.1: room for a new block. These tests run first; stage_5.cc has the others.

#include <gtest/gtest.h>

#include "ch5_homework/judge/diagnosis.h"
#include "ch5_homework/judge/oracle.h"
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

  std::vector<Mistake> InH() const {
    const auto is = [this](Part a, Part b, Part c, Part d) { return Opened(a, b, c, d); };
    const Part no = kMissing, ok = kRight;
    std::vector<Mistake> mistakes{{"5.1", "5.nothing_copied", is(no, no, no, no)},
                                  {"5.1", "5.H_00_alone_copied", is(ok, no, no, no)},
                                  {"5.1", "5.nothing_made_room", is(ok, kNotMoved, kNotMoved, kNotMoved)},
                                  {"5.1", "5.H_01_H_01T_missing", is(ok, no, no, ok)},
                                  {"5.1", "5.H_01_H_01T_exchanged", is(ok, kWrongSource, kWrongSource, ok)}};
    const std::vector<Text> of_00{{}, "5.H_00_dense_part_missing"},
        of_01{{}, "5.H_01_right_new_columns_missing", "5.H_01_made_no_room", "5.H_01_holds_transpose"},
        of_10{{}, "5.H_01T_below_new_rows_missing", "5.H_01T_made_no_room", "5.H_01T_holds_H_01"},
        of_11{{}, "5.tails_corner_H_11_missing", "5.tails_corner_made_no_room", "5.tails_corner_holds_H_00"};
    for (size_t a = 0; a < of_00.size(); ++a) {
      for (size_t b = 0; b < of_01.size(); ++b) {
        for (size_t c = 0; c < of_10.size(); ++c) {
          for (size_t d = 0; d < of_11.size(); ++d) {
            const Text& cause = a ? of_00[a] : (b ? of_01[b] : (c ? of_10[c] : of_11[d]));
            if (!cause.empty()) mistakes.push_back({"5.1", cause, is(Part(a), Part(b), Part(c), Part(d))});
          }
        }
      }
    }
    MatXX late = MatXX::Zero(H.rows() + dim, H.cols() + dim), known = Opened();
    const auto moved = [this](Eigen::Index row) { return row <= idx ? row : row + dim; };
    for (Eigen::Index i = 0; i < H.rows(); ++i) {
      for (Eigen::Index j = 0; j < H.cols(); ++j) late(moved(i), moved(j)) = H(i, j);
    }
    mistakes.push_back({"5.1", "5.row_idx_made_no_room", late});
    known.block(idx, idx, dim, dim).setIdentity();
    mistakes.push_back({"5.1", "5.new_block_holds_identity", known});
    return mistakes;
  }

  VecX OpenedB() const {
    VecX b = VecX::Zero(b0.size() + dim);
    b.head(idx) = b0.head(idx);
    b.tail(Tail()) = b0.tail(Tail());
    return b;
  }

  std::vector<Mistake> InB() const {
    const auto changed = [this](int at, const VecX& part) {
      VecX b = VecX::Zero(b0.size() + dim);
      b.head(idx) = b0.head(idx);
      b.segment(at, part.size()) = part;
      return b;
    };
    VecX without_beginning = OpenedB();
    without_beginning.head(idx).setZero();
    return {{"5.1", "5.b0_not_copied", VecX::Zero(OpenedB().size())},
            {"5.1", "5.tail_b0_missing", changed(0, b0.head(idx))},
            {"5.1", "5.beginning_b0_missing", without_beginning},
            {"5.1", "5.b0_made_no_room", changed(idx, b0.tail(Tail()))},
            {"5.1", "5.b0s_tail_holds_beginning", Tail() <= idx ? changed(idx + dim, b0.head(Tail())) : OpenedB()}};
  }
};

int Rows(const std::vector<std::shared_ptr<Vertex>>& vertices) {
  int rows = 0;
  for (const auto& vertex : vertices) rows += vertex->LocalDimension();
  return rows;
}

Text After(const char* what, const Text& scene) { return {"5.after_insert", {{"what", Word(what)}, {"scene", scene}}}; }

void CheckOpened(const Insertion& c, const MarginalizationError& term, const Names& names, const Text& scene) {
  Require(
      "5", After("H", scene), c.Opened(), term.H(), names, [&] { return c.InH(); }, 1e-10, "5.1", "H");
  Require(
      "5", After("b0", scene), c.OpenedB(), term.b0(), names, [&] { return c.InB(); }, 1e-10, "5.1", "b0");
}

/// A term over poses and landmarks with random numbers, and one more vertex to come.
void CheckInsertion(const std::vector<std::shared_ptr<Vertex>>& dense,
                    const std::vector<std::shared_ptr<Vertex>>& landmarks, const std::shared_ptr<Vertex>& coming,
                    const Text& scene) {
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
  const auto term = Chosen().make_marginalization_error();
  const auto [H, J, b0, e0, term_dense_size] = MembersOf(*term);
  H = c.H;
  b0 = c.b0;
  term_dense_size = dense_size;
  const int row = term->InsertBlock(c.dim, is_landmark);

  CheckOpened(c, *term, RowNames(after), scene);
  if (term_dense_size != dense_size) {
    Fail({"5", After("dense_size_", scene), Text("5.as_before", {{"size", Word(dense_size)}}), Word(term_dense_size),
          "5.dense_size_grows_twice", "5.1"});
  }
  if (row != c.idx) Fail({"5", "5.returns_first_row"});
}

std::shared_ptr<Vertex> Pose() { return std::make_shared<VertexPose>(); }
std::shared_ptr<Vertex> Point() { return std::make_shared<VertexPointXYZ>(Vec3(1, 2, 5)); }
std::shared_ptr<Vertex> Depth() { return std::make_shared<VertexInverseDepth>(0.2); }
std::shared_ptr<Vertex> SpeedBias() { return std::make_shared<VertexSpeedBias>(); }

TEST(Stage5, InsertsAPoseBetweenPartsOfOneSize) {  // first: here no assertion betrays an exchange
  CheckInsertion({Pose()}, {Point(), Point()}, Pose(), "5.pose_comes");
}
TEST(Stage5, InsertsASpeedAndBias) {
  CheckInsertion({Pose(), Pose()}, {Depth(), Point()}, SpeedBias(), "5.speed_bias_comes");
}
TEST(Stage5, AppendsALandmark) {
  CheckInsertion({Pose(), SpeedBias()}, {Point(), Depth()}, Point(), "5.landmark_comes");
}
TEST(Stage5, InsertsTheFirstBlocks) {
  CheckInsertion({}, {}, Pose(), "5.pose_comes_nothing");
  CheckInsertion({}, {Depth(), Depth()}, Pose(), "5.pose_comes_only_two_landmarks");
}

}  // namespace
}  // namespace ch5::homework
