#pragma once
/// Tables of numbers as comma-separated files.

#include <filesystem>
#include <string>
#include <string_view>
#include <type_traits>

#include "ch5_backend/files/tables/text_writer.h"

namespace ch5 {

/// A table in memory; rows have as many cells as the header. Numbers are written with the fewest digits that read
/// back to the same bits; NaN leaves its cell empty: there is no such number.
class CsvTable {
 public:
  /// @param header  the columns' names, comma-separated, units included: "time_s,height_m"
  explicit CsvTable(std::string_view header);

  /// Appends a row of numbers and words.
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

  template <typename Cell>
  void Append(const Cell& cell) {
    if constexpr (std::is_integral_v<Cell>) {
      ch5::AppendNumber(static_cast<int64_t>(cell), ',', &text_);
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
