#pragma once
/// A table of numbers between commas, semicolons or tabs, strictly checked: every error names the file, the line and the value.
/// Its columns are found by the names in the first line, in any order.
///
/// Publishers' names differ in '#', in units and in frames: "#timestamp [ns]", "timestamp", "w_RS_S_x [rad s^-1]",
/// "w_x" …; here they are called "timestamp", "w_x", "b_a_z", without units and capital letters.

#include <cstdint>
#include <set>
#include <string>
#include <vector>

#include "ch5_backend/files/text_reader.h"
#include "ch5_backend/math/eigen_types.h"

namespace ch5 {

/// Empty if ‖q‖ = 1 within 1e-3, else what is wrong. Six printed digits give 1e-5; a larger error means another column.
std::string WhyNotUnit(const Qd& q);

/// Where the stamps jump, and go on from there: a clock that is set, or a recorder that pauses.
struct ClockJump {
  int line;       ///< the first behind it
  double before;  ///< from the table's first stamp to the last one before it [s]
  double by;      ///< [s], negative if the clock is set back
};

class CsvReader {
 public:
  /// @throws FileError if it cannot be read, or the first line names no columns, no timestamp [ns], or one column twice
  explicit CsvReader(const std::string& path);

  bool Has(const std::string& column) const;
  /// Goes to the next row; false after the last. Blank lines are passed over.
  /// @throws FileError unless it has as many cells as there are columns
  bool NextRow();
  /// Whether the row is the file's last line, which has no end: it may be cut in its last number.
  bool EndsInRow() const { return reader_.EndsInLine(); }
  /// Jumps by a minute and more, or back by a second and more, between runs of rows none of which is short.
  std::vector<ClockJump> ClockJumps() const;
  /// From each of these lines on, stamps are taken for so many nanoseconds less, and those of the lines before too.
  void TakeBack(std::vector<std::pair<int, int64_t>> jumps);
  /// The unit that the stamps are in, if there are about `rate` of them a second: nanoseconds, microseconds, milliseconds or
  /// seconds; empty if it is none of these. Rows of one stamp are one.
  std::string UnitOfStamps(double rate) const;
  /// The row's time stamp [ns].  @throws FileError unless it is a whole number, in order with those of the other rows
  int64_t Stamp(bool may_repeat = false);
  std::string_view Cell(const std::string& column) const;
  /// In meters, seconds and radians: of a column whose name ends in a unit such as [deg/s], [g] or [mm] it is converted.
  /// @throws FileError unless it is a finite number, or a whole one in [low, high]
  double Number(const std::string& column) const;
  int64_t Integer(const std::string& column, int64_t low, int64_t high) const;
  /// The columns `stem`x, `stem`y and `stem`z.
  Vec3 Vector(const std::string& stem) const { return {Number(stem + "x"), Number(stem + "y"), Number(stem + "z")}; }
  /// The columns q_w, q_x, q_y and q_z, normalized.  @throws FileError unless of length 1
  Qd Rotation() const;
  const std::string& Path() const { return reader_.Path(); }
  int Line() const { return reader_.Line(); }
  /// "file:line: message"
  [[noreturn]] void Fail(const std::string& message) const { reader_.Fail(message); }

 private:
  int64_t TakenBackAt(int line) const;

  TextReader reader_;
  char separator_ = ',';
  std::vector<std::string> columns_;
  std::vector<double> factors_;  // of their units
  std::vector<std::string_view> cells_;
  std::vector<LineStamp> stamps_;
  std::set<int> jumps_;                              // lines whose stamps are out of order
  std::vector<std::pair<int, int64_t>> taken_back_;  // see TakeBack
  int64_t last_stamp_ = -1;
};

}  // namespace ch5
