#include "ch5_backend/files/yaml_numbers.h"

#include <algorithm>
#include <sstream>
#include <vector>

namespace ch5 {
namespace {

// A '#' begins a comment at the start of the line or after a space.
std::string_view WithoutComment(std::string_view line) {
  for (size_t i = 0; i < line.size(); ++i) {
    if (line[i] == '#' && (i == 0 || line[i - 1] == ' ' || line[i - 1] == '\t')) return line.substr(0, i);
  }
  return line;
}

// Of the estimator's section, or of a camera that is not one of the two: camera2, cam1, ….
bool IsWord(const std::string& key) {
  if (key.rfind("camera1.", 0) == 0) return false;
  const size_t digit = key.rfind("camera", 0) == 0 ? 6 : 3;
  return key.rfind("estimator.", 0) == 0 || (key.rfind("cam", 0) == 0 && key[digit] >= '1' && key[digit] <= '9');
}

struct KeyAndValue {
  std::string key;
  std::string_view value;
};

KeyAndValue SplitAtColon(const TextReader& reader, std::string_view text) {
  const size_t colon = text.find(':');
  const std::string_view key = Trim(text.substr(0, colon));
  const bool separates = colon != std::string_view::npos && (colon + 1 == text.size() || text[colon + 1] == ' ');
  if (!separates || key.empty() || key.find_first_of(" \t-[]{}.\"'") != std::string_view::npos) {
    reader.Fail("expected \"key: value\", got " + TextReader::Quote(text));
  }
  return {std::string(key), Trim(text.substr(colon + 1))};
}

}  // namespace

YamlNumbers::YamlNumbers(const std::string& path) : path_(path) {
  struct Section {
    size_t indent;  // of its key
    std::string prefix;
  };
  std::vector<Section> sections;
  TextReader reader(path);
  while (const std::optional<std::string_view> line = reader.ReadLine()) {
    const std::string_view text = WithoutComment(*line);
    const size_t indent = text.find_first_not_of(' ');
    if (Trim(text).empty() || text.front() == '%' || Trim(text) == "---")
      continue;  // or %YAML:1.0, which OpenCV writes
    if (text[indent] == '\t') reader.Fail("a tab indents the line; YAML takes spaces alone");
    while (!sections.empty() && indent <= sections.back().indent) sections.pop_back();
    const auto [name, value] = SplitAtColon(reader, Trim(text));
    const std::string key = (sections.empty() ? "" : sections.back().prefix) + name;
    if (value.empty()) {
      sections.push_back({indent, key + "."});
    } else {
      ReadValue(reader, key, value);
    }
  }
}

void YamlNumbers::ReadValue(const TextReader& reader, const std::string& key, std::string_view value) {
  const std::string_view inner = value.size() >= 2 ? value.substr(1, value.size() - 2) : "";
  if (value.front() == '[' && value.back() == ']') {
    int i = 0;
    for (const std::string_view part : SplitAtCommas(inner)) {
      Add(reader, key + "[" + std::to_string(i++) + "]", part);
    }
  } else if (value.front() == '{' && value.back() == '}') {
    for (const std::string_view part : SplitAtCommas(inner)) {
      const auto [name, number] = SplitAtColon(reader, part);
      Add(reader, key + "." + name, number);
    }
  } else {
    Add(reader, key, value);
  }
}

void YamlNumbers::Add(const TextReader& reader, const std::string& key, std::string_view number) {
  const bool is_quoted =
      number.size() >= 2 && (number.front() == '"' || number.front() == '\'') && number.back() == number.front();
  if (is_quoted) number = number.substr(1, number.size() - 2);
  if (IsWord(key)) {
    const auto same = [&](const Word& word) { return word.key == key; };
    const auto before = std::find_if(words_.begin(), words_.end(), same);
    if (before != words_.end()) reader.Fail(key + ": given in line " + std::to_string(before->line) + " already");
    return words_.push_back({key, std::string(number), reader.Line()});
  }
  const Number entry{reader.ToDouble(number, key.c_str()), reader.Line()};
  const auto [existing, is_new] = numbers_.emplace(key, entry);
  if (!is_new) reader.Fail(key + ": given in line " + std::to_string(existing->second.line) + " already");
}

double YamlNumbers::Take(const std::string& key, double low, double high) {
  const auto found = numbers_.find(key);
  if (found == numbers_.end()) throw FileError(path_ + ": " + key + " is missing");
  const auto [value, line] = found->second;
  if (!(value >= low && value <= high)) {
    std::ostringstream message;
    message << key << ": must lie in [" << low << ", " << high << "], got " << value;
    Fail(line, message.str());
  }
  numbers_.erase(found);
  return value;
}

bool YamlNumbers::HasSection(const std::string& name) const {
  const std::string prefix = name + ".";
  const auto first = numbers_.lower_bound(prefix);
  return first != numbers_.end() && first->first.rfind(prefix, 0) == 0;
}

void YamlNumbers::ExpectAllTaken() const {
  if (numbers_.empty()) return;
  const auto& [key, number] = *numbers_.begin();
  Fail(number.line, key + ": nothing of this name is known here");
}

void YamlNumbers::Fail(int line, const std::string& message) const {
  throw FileError(path_ + ":" + std::to_string(line) + ": " + message);
}

}  // namespace ch5
