#pragma once
/// Comma-separated numbers, strictly checked: every error names the file, the line and the value.

#include <string>
#include <vector>

#include "ch5_backend/files/text_reader.h"

namespace ch5 {

class CsvReader {
 public:
  /// Opens `path`, whose first line must begin with `columns.front()` and have as many columns.
  /// @param columns  their names with units, for the check and for messages
  /// @param optional  the name of a further column that may follow; empty: none
  /// @throws FileError
  CsvReader(const std::string& path, std::vector<std::string> columns, const std::string& optional = "");

  /// Whether the optional column, behind the others, is there.
  bool HasOptional() const { return has_optional_; }

  /// Goes to the next row; false after the last. Lines that are blank are passed over.
  /// @throws FileError if the row has too few or too many cells, or no end: then its last number may be cut
  bool NextRow();

  /// @throws FileError unless the cell is a finite number, or a whole one in [low, high]
  double Double(size_t column) const;
  int64_t Integer(size_t column, int64_t low, int64_t high) const;

  /// "file:line: message"
  [[noreturn]] void Fail(const std::string& message) const { reader_.Fail(message); }

 private:
  TextReader reader_;
  std::vector<std::string> columns_;
  std::vector<std::string_view> cells_;
  bool has_optional_ = false;
};

}  // namespace ch5
