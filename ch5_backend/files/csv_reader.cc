#include "ch5_backend/files/csv_reader.h"

namespace ch5 {
CsvReader::CsvReader(const std::string& path, std::vector<std::string> columns, const std::string& optional)
    : reader_(path), columns_(std::move(columns)) {
  const std::optional<std::string_view> header = reader_.ReadLine();
  if (!header) Fail("the file is empty");
  cells_ = SplitAtCommas(*header);
  if (cells_.front() != columns_.front()) {
    Fail("the first line must name the columns and begin with \"" + columns_.front() + "\", got " +
         TextReader::Quote(*header));
  }
  has_optional_ = !optional.empty() && cells_.size() == columns_.size() + 1 && Trim(cells_.back()) == optional;
  if (has_optional_) columns_.push_back(optional);
  if (cells_.size() != columns_.size()) {
    Fail("the first line names " + std::to_string(cells_.size()) + " columns, must be " +
         std::to_string(columns_.size()) +
         (optional.empty() || cells_.size() <= columns_.size() ? "" : ", or a last one more, " + optional));
  }
}

bool CsvReader::NextRow() {
  std::optional<std::string_view> line;
  do {
    line = reader_.ReadLine();
    if (!line) return false;
  } while (Trim(*line).empty());
  cells_ = SplitAtCommas(*line);
  if (reader_.EndsInLine()) Fail("the file ends in the middle of a line; is it cut? got " + TextReader::Quote(*line));
  if (cells_.size() == columns_.size()) return true;
  Fail("a row of " + std::to_string(cells_.size()) + " columns, must be " + std::to_string(columns_.size()) + ", got " +
       TextReader::Quote(*line));
}

double CsvReader::Double(size_t column) const { return reader_.ToDouble(cells_[column], columns_[column].c_str()); }

int64_t CsvReader::Integer(size_t column, int64_t low, int64_t high) const {
  return reader_.ToInteger(cells_[column], columns_[column].c_str(), low, high);
}

}  // namespace ch5
