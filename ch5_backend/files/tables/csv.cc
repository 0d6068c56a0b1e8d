#include "ch5_backend/files/tables/csv.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace ch5 {

CsvTable::CsvTable(std::string_view header)
    : columns_(1 + static_cast<size_t>(std::count(header.begin(), header.end(), ','))), text_(header) {
  text_ += '\n';
}

void CsvTable::CheckWidth(size_t cells) const {
  if (cells == columns_) return;
  throw std::invalid_argument("CsvTable: a row of " + std::to_string(cells) + " cells under a header of " +
                              std::to_string(columns_));
}

void CsvTable::AppendWord(std::string_view word) {
  const bool is_quoted = word.find_first_of(",\n\"") != std::string_view::npos;
  if (is_quoted) text_ += '"';
  for (const char letter : word) text_.append(letter == '"' ? 2 : 1, letter);
  text_ += is_quoted ? "\"," : ",";
}

void CsvTable::AppendNumber(double number) {
  if (std::isnan(number)) return AppendWord("");
  ch5::AppendNumber(number, ',', &text_);
}

}  // namespace ch5
