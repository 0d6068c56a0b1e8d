#pragma once
/// A table of EuRoC's layout: its columns are found by their names, in whatever order they stand.
///
/// Names differ among publishers in '#', in units and in frames: "#timestamp [ns]", "timestamp", "w_RS_S_x [rad s^-1]",
/// "w_x" …; here they are called "timestamp", "w_x", "b_a_z", without units and capital letters.

#include <cstdint>
#include <string>
#include <vector>

#include "ch5_backend/files/text_reader.h"
#include "ch5_backend/math/eigen_types.h"

namespace ch5 {

class NamedCsv {
 public:
  /// @throws FileError if it cannot be read, or the first line names no columns
  explicit NamedCsv(const std::string& path);

  bool Has(const std::string& column) const;
  /// Goes to the next row; false after the last. Blank lines are passed over.
  /// @throws FileError unless it has as many cells as there are columns
  bool NextRow();
  /// The row's time stamp [ns].  @throws FileError unless it is a whole number, larger than that of the row before
  int64_t Stamp();
  std::string_view Cell(const std::string& column) const;
  /// @throws FileError unless it is a finite number
  double Number(const std::string& column) const;
  /// The columns `stem`x, `stem`y and `stem`z.
  Vec3 Vector(const std::string& stem) const { return {Number(stem + "x"), Number(stem + "y"), Number(stem + "z")}; }
  [[noreturn]] void Fail(const std::string& message) const { reader_.Fail(message); }

 private:
  TextReader reader_;
  std::vector<std::string> columns_;
  std::vector<std::string_view> cells_;
  int64_t last_stamp_ = -1;
};

}  // namespace ch5
