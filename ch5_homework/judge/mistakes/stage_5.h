#pragma once
/// What typical mistakes in OKVIS's InsertBlock (5.1) give.

#include <string>
#include <vector>

#include "ch5_homework/judge/diagnosis.h"

namespace ch5::homework::stage_5 {

/// H and b₀ before, and where the new block goes.
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
                                  {"5.1", "5.H_as_before", H},
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

}  // namespace ch5::homework::stage_5
