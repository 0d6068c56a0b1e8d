/// Stage 5.1: room for a new block. These tests run first; stage_5.cc has the others.

#include <gtest/gtest.h>

#include "tests/homework/narrate.h"
#include "tests/homework/scenes.h"
#include "tests/homework/submission.h"

namespace ch5::homework {
namespace {

// H and b₀ before, and where the new block goes.
struct Insertion {
  MatXX H;
  VecX b0;
  int idx, dim;

  int Tail() const { return static_cast<int>(H.rows()) - idx; }

  /// The four parts around the new rows; each may be left out, and the tail may start elsewhere.
  MatXX Opened(bool right = true, bool below = true, bool corner = true, int corner_at = -1) const {
    const int tail = Tail(), end = idx + dim;
    MatXX opened = MatXX::Zero(H.rows() + dim, H.rows() + dim);
    opened.topLeftCorner(idx, idx) = H.topLeftCorner(idx, idx);
    if (right) opened.block(0, end, idx, tail) = H.block(0, idx, idx, tail);
    if (below) opened.block(end, 0, tail, idx) = H.block(idx, 0, tail, idx);
    const int at = corner_at < 0 ? end : corner_at;
    if (corner) opened.block(at, at, tail, tail) = H.block(idx, idx, tail, tail);
    return opened;
  }

  std::vector<Mistake> Mistakes() const {
    std::vector<Mistake> mistakes{
        {"5.1", "nothing was copied: the old H is lost",
         [this] { return MatXX::Zero(Opened().rows(), Opened().cols()); }},
        {"5.1", "H_00 alone was copied; the three parts of the tail are missing", [this] { return Opened(0, 0, 0); }},
        {"5.1", "the tail's corner H_11 is missing", [this] { return Opened(1, 1, 0); }},
        {"5.1", "H_01, right of the new columns, is missing", [this] { return Opened(0, 1, 1); }},
        {"5.1", "H_01ᵀ, below the new rows, is missing", [this] { return Opened(1, 0, 1); }},
        {"5.1", "H_01 and H_01ᵀ are missing: the dense part and the tail no longer know each other",
         [this] { return Opened(0, 0, 1); }},
        {"5.1", "the tail's corner has made no room: it starts at idx instead of idx + dim",
         [this] { return Opened(1, 1, 1, idx); }},
        {"5.1", "nothing has made room: the new block stands behind everything, but its place is at idx", [this] {
           MatXX appended = MatXX::Zero(H.rows() + dim, H.rows() + dim);
           appended.topLeftCorner(H.rows(), H.rows()) = H;
           return appended;
         }}};
    if (Tail() == idx) {  // here an exchange goes unseen by Eigen
      mistakes.push_back(
          {"5.1", "H_01 and H_01ᵀ are exchanged: H_01, right of the new columns, has the dense part's rows", [this] {
             MatXX A = Opened();
             A.block(0, idx + dim, idx, idx) = H.block(idx, 0, idx, idx);
             A.block(idx + dim, 0, idx, idx) = H.block(0, idx, idx, idx);
             return A;
           }});
      mistakes.push_back({"5.1", "the tail's corner holds H_00: H_11 is read from row and column idx on", [this] {
                            MatXX A = Opened();
                            A.block(idx + dim, idx + dim, idx, idx) = H.topLeftCorner(idx, idx);
                            return A;
                          }});
    }
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

/// A term over poses and landmarks with random numbers, and one more vertex to come.
void CheckInsertion(const std::vector<std::shared_ptr<Vertex>>& dense,
                    const std::vector<std::shared_ptr<Vertex>>& landmarks, const std::shared_ptr<Vertex>& coming,
                    const std::string& scene) {
  Graph graph;
  Ordering before, after;  // only for the names of rows
  for (const auto& vertex : dense) before.poses.push_back(vertex);
  for (const auto& vertex : landmarks) before.landmarks.push_back(vertex);
  after = before;
  const bool is_landmark = coming->GetRole() == Role::kLandmark;
  (is_landmark ? after.landmarks : after.poses).push_back(coming);
  for (const auto* vertices : {&after.poses, &after.landmarks}) {
    for (const auto& vertex : *vertices) graph.AddVertex(vertex);
  }

  Random random(Seed(31));
  int dense_size = 0;
  for (const auto& vertex : dense) dense_size += vertex->LocalDimension();
  const int size = static_cast<int>(RowNames(before).size());
  const Insertion c{RandomPositiveDefinite(size, &random), RandomMatrix(size, 1, &random),
                    is_landmark ? size : dense_size, coming->LocalDimension()};
  const auto term = Chosen().make_okvis_term();
  const OkvisTerm::Members inside = term->Inside();
  *inside.H = c.H;
  *inside.b0 = c.b0;
  *inside.dense_size = dense_size;
  const int row = term->InsertBlock(c.dim, is_landmark);

  ASSERT_NO_STORY({"5", "H after InsertBlock: " + scene, c.Opened(), *inside.H, RowNames(after), c.Mistakes()});
  ASSERT_NO_STORY({"5", "b0 after InsertBlock: " + scene, c.OpenedB(), *inside.b0, RowNames(after), c.MistakesInB()});
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
