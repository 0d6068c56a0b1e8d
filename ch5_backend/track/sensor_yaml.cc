#include "ch5_backend/track/sensor_yaml.h"

#include <algorithm>
#include <charconv>
#include <cmath>

#include <Eigen/LU>

#include "ch5_backend/files/text_reader.h"
#include "ch5_backend/math/transform.h"

namespace ch5 {

SensorYaml::SensorYaml(const std::string& path, const std::string& section) : path_(path), section_(section) {
  TextReader reader(path);
  std::string above;             // the last key that is not indented
  std::string* value = nullptr;  // of the last key
  const auto is_open = [&] {     // a list whose ']' is still to come
    return value && std::count(value->begin(), value->end(), '[') > std::count(value->begin(), value->end(), ']');
  };
  while (const std::optional<std::string_view> line = reader.ReadLine()) {
    const std::string_view text = line->substr(0, line->find('#'));
    std::string_view words = Trim(text);
    if (words.empty() || words.front() == '%' || words == "---" || words == "...") continue;
    const bool is_item = words.substr(0, 2) == "- ";
    if (value && (is_open() || is_item)) {
      if (is_item && !is_open()) *value += ",";
      while (words.substr(0, 2) == "- ") words = Trim(words.substr(2));
      *value += " " + std::string(words);
      continue;
    }
    const size_t colon = words.find(':');
    if (colon == std::string_view::npos) reader.Fail("expected \"key: value\", got " + TextReader::Quote(words));
    std::string key(Trim(words.substr(0, colon)));
    const bool is_indented = text.front() == ' ' || text.front() == '\t';
    if (is_indented) key = above + "." + key;
    if (!is_indented) above = key;
    const auto [entry, is_new] = values_.emplace(key, Value{std::string(Trim(words.substr(colon + 1))), reader.Line()});
    if (!is_new) reader.Fail(key + ": given in line " + std::to_string(entry->second.line) + " already");
    value = &entry->second.text;
  }
  if (is_open()) reader.Fail("the file ends within a list, whose ] is missing");
}

std::map<std::string, SensorYaml::Value>::const_iterator SensorYaml::Find(const std::string& key) const {
  const auto found = values_.find(section_ + "." + key);
  return found != values_.end() ? found : values_.find(key);
}

std::string SensorYaml::Name(const std::string& euroc, const std::string& kalibr) const {
  return Has(euroc) || !Has(kalibr) ? euroc : kalibr;
}

std::string SensorYaml::Word(const std::string& key) const {
  const auto found = Find(key);
  if (found == values_.end() || found->second.text.empty()) {
    throw FileError(path_ + ": " + (section_.empty() ? "" : section_ + ": ") + key + " is missing");
  }
  std::string word = found->second.text;
  word.erase(std::remove_if(word.begin(), word.end(), [](char c) { return c == '"' || c == '\''; }), word.end());
  return word;
}

std::vector<double> SensorYaml::Numbers(const std::string& key, size_t count) const {
  std::string list = Word(key);
  std::replace_if(
      list.begin(), list.end(), [](char c) { return c == '[' || c == ']'; }, ' ');
  std::vector<double> numbers;
  for (const std::string_view part : SplitAtCommas(list)) {
    if (part.empty()) continue;
    double number = 0.0;
    const auto [stop, error] = std::from_chars(part.data(), part.data() + part.size(), number);
    if (error != std::errc() || stop != part.data() + part.size() || !std::isfinite(number)) {
      Fail(key, "not a finite number, got " + TextReader::Quote(part));
    }
    numbers.push_back(number);
  }
  if (numbers.size() != count) {
    Fail(key, "must be " + std::to_string(count) + " numbers, got " + std::to_string(numbers.size()));
  }
  return numbers;
}

double SensorYaml::Positive(const std::string& key) const {
  const double number = Numbers(key, 1)[0];
  if (!(number > 0.0)) Fail(key, "must be positive, got " + std::to_string(number));
  return number;
}

Transform SensorYaml::T_B_S() const {
  if (Has("T_cam_imu")) return Inverse(RigidTransform("T_cam_imu"));
  return RigidTransform(Has("T_BS.data") || !Has("T_BS") ? "T_BS.data" : "T_BS");
}

Transform SensorYaml::RigidTransform(const std::string& key) const {
  const std::vector<double> numbers = Numbers(key, 16);
  const Eigen::Matrix4d T = Eigen::Map<const Eigen::Matrix4d>(numbers.data()).transpose();
  const Mat33 R = T.topLeftCorner<3, 3>();
  constexpr double kTolerance = 1e-3;
  if ((T.row(3) - Eigen::RowVector4d(0, 0, 0, 1)).cwiseAbs().maxCoeff() > kTolerance) {
    std::string row;
    for (int i = 12; i < 16; ++i) row += " " + std::to_string(numbers[static_cast<size_t>(i)]);
    Fail(key, "the last row must be 0 0 0 1, got" + row + "; the numbers stand row by row");
  }
  const double error = (R.transpose() * R - Mat33::Identity()).cwiseAbs().maxCoeff();
  if (error > kTolerance || R.determinant() < 0.0) {
    Fail(key, "the upper left 3 × 3 part must be a rotation, but RᵀR differs from I by " + std::to_string(error) +
                  " and det R is " + std::to_string(R.determinant()));
  }
  return {Qd(R).normalized(), T.topRightCorner<3, 1>()};
}

void SensorYaml::Fail(const std::string& key, const std::string& message) const {
  throw FileError(path_ + ":" + std::to_string(Find(key)->second.line) + ": " + key + ": " + message);
}

}  // namespace ch5
