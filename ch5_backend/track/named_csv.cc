#include "ch5_backend/track/named_csv.h"

#include <algorithm>
#include <cctype>
#include <limits>

namespace ch5 {
namespace {

// "#w_RS_S_x [rad s^-1]" → "w_x".
std::string PlainName(std::string_view cell) {
  cell = Trim(cell.substr(0, cell.find('[')));
  if (!cell.empty() && cell.front() == '#') cell = Trim(cell.substr(1));
  std::string name;
  while (!cell.empty()) {
    const std::string_view part = cell.substr(0, cell.find('_'));
    const bool is_frame = std::all_of(part.begin(), part.end(), [](unsigned char c) { return std::isupper(c) != 0; });
    if (!is_frame) name += (name.empty() ? "" : "_") + std::string(part);
    cell.remove_prefix(std::min(cell.size(), part.size() + 1));
  }
  return name;
}

}  // namespace

NamedCsv::NamedCsv(const std::string& path) : reader_(path) {
  const std::optional<std::string_view> header = reader_.ReadLine();
  if (!header) Fail("the file is empty");
  for (const std::string_view cell : SplitAtCommas(*header)) columns_.push_back(PlainName(cell));
  if (!Has("timestamp")) {
    Fail("the first line must name the columns and begin with \"#timestamp [ns]\", got " + TextReader::Quote(*header));
  }
}

bool NamedCsv::Has(const std::string& column) const {
  return std::find(columns_.begin(), columns_.end(), column) != columns_.end();
}

bool NamedCsv::NextRow() {
  std::optional<std::string_view> line;
  do {
    line = reader_.ReadLine();
    if (!line) return false;
  } while (Trim(*line).empty());
  cells_ = SplitAtCommas(*line);
  if (cells_.size() == columns_.size()) return true;
  Fail("a row of " + std::to_string(cells_.size()) + " columns, but the first line names " +
       std::to_string(columns_.size()) + ", got " + TextReader::Quote(*line));
}

int64_t NamedCsv::Stamp() {
  const int64_t stamp = reader_.ToInteger(Cell("timestamp"), "timestamp [ns]", 0, std::numeric_limits<int64_t>::max());
  if (stamp <= last_stamp_) {
    Fail("the timestamps must increase, got " + std::to_string(stamp) + " after " + std::to_string(last_stamp_));
  }
  return last_stamp_ = stamp;
}

std::string_view NamedCsv::Cell(const std::string& column) const {
  const auto found = std::find(columns_.begin(), columns_.end(), column);
  if (found != columns_.end()) return cells_[static_cast<size_t>(found - columns_.begin())];
  std::string names;
  for (const std::string& name : columns_) names += (names.empty() ? "" : ", ") + name;
  Fail("there is no column " + column + "; the first line names " + names);
}

double NamedCsv::Number(const std::string& column) const { return reader_.ToDouble(Cell(column), column.c_str()); }

}  // namespace ch5
