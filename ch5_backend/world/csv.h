#pragma once
/// Tables of numbers as comma-separated files.

#include <filesystem>
#include <stdexcept>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

namespace ch5 {

/// A file that cannot be written; the message names it and says why.
class WriteError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// Writes `text` to `path`, whole or not at all: into `path`.partial first, which then takes the name.
/// @throws WriteError, after which an older file of that name is untouched and the partial one is gone
void WriteFileAtomically(const std::filesystem::path& path, std::string_view text);

/// A table in memory; rows have as many cells as the header. Numbers are written with the fewest digits that read
/// back to the same bits; `nan` and `inf` stand for themselves.
class CsvTable {
 public:
  /// @param header  the columns' names, comma-separated, units included: "time_s,height_m"
  explicit CsvTable(std::string_view header);

  /// Appends a row of numbers and words (without commas).
  template <typename... Cells>
  void Row(const Cells&... cells) {
    CheckWidth(sizeof...(Cells));
    (Append(cells), ...);
    text_.back() = '\n';
  }

  const std::string& Text() const { return text_; }
  /// @throws WriteError
  void Write(const std::filesystem::path& path) const { WriteFileAtomically(path, text_); }

 private:
  void CheckWidth(size_t cells) const;
  void AppendWord(std::string_view word);
  void AppendNumber(double number);
  void AppendNumber(long long number);

  template <typename Cell>
  void Append(const Cell& cell) {
    if constexpr (std::is_integral_v<Cell>) {
      AppendNumber(static_cast<long long>(cell));
    } else if constexpr (std::is_arithmetic_v<Cell>) {
      AppendNumber(static_cast<double>(cell));
    } else {
      AppendWord(cell);
    }
  }

  size_t columns_;
  std::string text_;
};

}  // namespace ch5
