#include "ch5_backend/files/csv_reader.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <limits>
#include <map>
#include <set>

#include "ch5_backend/math/median.h"

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

// Some programs write semicolons, because numbers contain a comma, or tabs.
char SeparatorOf(std::string_view header) {
  const size_t first = header.find_first_of(",;\t");
  return first == std::string_view::npos ? ',' : header[first];
}

// "[deg s^-1]" → "deg"; empty if the cell names no unit.
std::string_view UnitOf(std::string_view cell) {
  const size_t begin = cell.find('[');
  if (begin == std::string_view::npos) return {};
  cell.remove_prefix(begin + 1);
  return cell.substr(0, cell.find_first_of(" /^]"));
}

// Of meters, seconds and radians; 1 for a unit that is one of them or not known.
double FactorOf(std::string_view unit) {
  constexpr double kDegree = M_PI / 180.0, kG = 9.80665;
  const std::map<std::string_view, double> others = {{"deg", kDegree}, {"°", kDegree},   {"dps", kDegree},
                                                     {"mm", 1e-3},     {"cm", 1e-2},     {"km", 1e3},
                                                     {"g", kG},        {"mg", 1e-3 * kG}};
  const auto found = others.find(unit);
  return found == others.end() ? 1.0 : found->second;
}

}  // namespace

std::string WhyNotUnit(const Qd& q) {
  if (std::abs(q.norm() - 1.0) < 1e-3) return "";
  return "the quaternion must be of length 1, got " + std::to_string(q.norm());
}

CsvReader::CsvReader(const std::string& path) : reader_(path) {
  const std::optional<std::string_view> header = reader_.ReadLine();
  if (!header) Fail("the file is empty");
  bool is_in_ns = false;
  double factor = 1.0;
  std::string last_stem;
  std::set<std::string> names;
  std::string twice;
  separator_ = SeparatorOf(*header);
  for (const std::string_view cell : SplitAt(separator_, *header)) {
    columns_.push_back(PlainName(cell));
    if (!columns_.back().empty() && !names.insert(columns_.back()).second) twice = columns_.back();
    const std::string_view unit = UnitOf(cell);
    if (columns_.back() == "timestamp") is_in_ns = unit.empty() || unit == "ns";
    // "w_x [deg/s],w_y,w_z": a unit stands for the axes that follow, too.
    const std::string stem = columns_.back().substr(0, columns_.back().rfind('_'));
    if (!unit.empty() || stem != last_stem) factor = FactorOf(unit);
    last_stem = stem;
    factors_.push_back(factor);
  }
  if (!is_in_ns) {
    Fail("the first line must name the columns and begin with \"#timestamp [ns]\", got " + TextReader::Quote(*header));
  }
  if (!twice.empty()) Fail("two columns are called " + twice + " (without units and frames)");
  const auto column = std::find(columns_.begin(), columns_.end(), "timestamp") - columns_.begin();
  stamps_ = reader_.Stamps([&](std::string_view line) {
    for (auto k = column; k > 0; --k) line.remove_prefix(std::min(line.size(), line.find(separator_) + 1));
    return line.substr(0, line.find(separator_));
  });
  jumps_ = LinesOutOfOrder(stamps_);
}

std::vector<ClockJump> CsvReader::ClockJumps() const {
  constexpr double kPause = 60e9, kBack = -1e9;  // [ns]
  constexpr size_t kShare = 100;                 // a run is no shorter than one of so many rows
  const auto is_jump = [](double step) { return step > kPause || step < kBack; };
  std::vector<ClockJump> jumps;
  const LineStamp* last = nullptr;  // of the last run that is not short
  for (size_t first = 0, end = 0; first < stamps_.size(); first = end) {
    for (end = first + 1; end < stamps_.size() && !is_jump(stamps_[end].stamp - stamps_[end - 1].stamp);) ++end;
    if (end - first < std::max<size_t>(2, stamps_.size() / kShare)) continue;
    const double by = last ? stamps_[first].stamp - last->stamp : 0.0;
    if (is_jump(by)) jumps.push_back({stamps_[first].line, 1e-9 * (last->stamp - stamps_[0].stamp), 1e-9 * by});
    last = &stamps_[end - 1];
  }
  return jumps;
}

void CsvReader::TakeBack(std::vector<std::pair<int, int64_t>> jumps) {
  taken_back_ = std::move(jumps);
  for (LineStamp& stamp : stamps_) stamp.stamp -= static_cast<double>(TakenBackAt(stamp.line));
  jumps_ = LinesOutOfOrder(stamps_);
}

int64_t CsvReader::TakenBackAt(int line) const {
  int64_t sum = 0;
  for (const auto& [first, ns] : taken_back_) sum += line >= first ? ns : 0;
  return sum;
}

std::string CsvReader::UnitOfStamps(double rate) const {
  constexpr double kNear = 2.0;
  std::vector<double> steps;
  for (size_t k = 1; k < stamps_.size(); ++k)
    if (const double step = stamps_[k].stamp - stamps_[k - 1].stamp; step > 0.0) steps.push_back(step);
  if (steps.empty()) return "";
  const double seconds = 1.0 / (rate * Median(steps));  // what a step by one stands for
  for (const auto& [unit, name] :
       {std::pair(1e-9, "nanoseconds"), {1e-6, "microseconds"}, {1e-3, "milliseconds"}, {1.0, "seconds"}})
    if (std::max(seconds / unit, unit / seconds) < kNear) return name;
  return "";
}

bool CsvReader::Has(const std::string& column) const {
  return std::find(columns_.begin(), columns_.end(), column) != columns_.end();
}

bool CsvReader::NextRow() {
  std::optional<std::string_view> line;
  do {
    line = reader_.ReadLine();
    if (!line) return false;
  } while (Trim(*line).empty());
  cells_ = SplitAt(separator_, *line);
  if (cells_.size() == columns_.size() + 1 && cells_.back().empty()) cells_.pop_back();  // behind a last comma
  if (cells_.size() == columns_.size()) return true;
  Fail("a row of " + std::to_string(cells_.size()) + " columns, but the first line names " +
       std::to_string(columns_.size()) + ", got " + TextReader::Quote(*line));
}

int64_t CsvReader::Stamp(bool may_repeat) {
  const int64_t stamp = reader_.ToInteger(Cell("timestamp"), "timestamp [ns]", 0, std::numeric_limits<int64_t>::max()) -
                        TakenBackAt(reader_.Line());
  const bool is_repeated = stamp == last_stamp_ && !may_repeat;
  if (stamp > last_stamp_ && jumps_.count(reader_.Line()) > 0) {
    Fail("the timestamp jumps ahead of those in the rows below, got " + std::to_string(stamp));
  }
  if (stamp < last_stamp_ || is_repeated) {
    Fail(std::string("the timestamp ") + (is_repeated ? "is repeated" : "goes backwards") + ", got " +
         std::to_string(stamp) + " after " + std::to_string(last_stamp_));
  }
  return last_stamp_ = stamp;
}

std::string_view CsvReader::Cell(const std::string& column) const {
  const auto found = std::find(columns_.begin(), columns_.end(), column);
  if (found != columns_.end()) return cells_[static_cast<size_t>(found - columns_.begin())];
  std::string names;
  for (const std::string& name : columns_) names += (names.empty() ? "" : ", ") + name;
  reader_.FailAt(1, "there is no column " + column + "; the first line names " + names);
}

double CsvReader::Number(const std::string& column) const {
  const std::string_view cell = Cell(column);
  const auto k = std::find(columns_.begin(), columns_.end(), column) - columns_.begin();
  return factors_[static_cast<size_t>(k)] * reader_.ToDouble(cell, column.c_str());
}

int64_t CsvReader::Integer(const std::string& column, int64_t low, int64_t high) const {
  return reader_.ToInteger(Cell(column), column.c_str(), low, high);
}

Qd CsvReader::Rotation() const {
  const Qd q(Number("q_w"), Number("q_x"), Number("q_y"), Number("q_z"));
  if (const std::string why = WhyNotUnit(q); !why.empty()) Fail(why);
  return q.normalized();
}

}  // namespace ch5
