#include "ch5_backend/files/yaml_file.h"

#include <algorithm>
#include <sstream>

namespace ch5 {
namespace {

// A '#' begins a comment at the start of the line or after a space, but not in quotes. These begin where a word may: the
// apostrophe of "camera's" is none.
std::string_view WithoutComment(std::string_view line) {
  char last = ' ';
  for (size_t i = 0; i < line.size(); last = line[i++]) {
    const bool is_after_space = last == ' ' || last == '\t';
    if (line[i] == '#' && is_after_space) return line.substr(0, i);
    const bool is_quote = (line[i] == '"' || line[i] == '\'') && (is_after_space || last == '[' || last == '{');
    const size_t end = is_quote ? line.find(line[i], i + 1) : std::string_view::npos;
    if (end != std::string_view::npos) i = end;
  }
  return line;
}

std::string WithoutQuotes(std::string_view text) {
  const bool is_quoted =
      text.size() >= 2 && (text.front() == '"' || text.front() == '\'') && text.back() == text.front();
  return std::string(is_quoted ? text.substr(1, text.size() - 2) : text);
}

bool IsItem(std::string_view text) { return text == "-" || text.substr(0, 2) == "- "; }

// How many more brackets `text` opens than it closes.
int Depth(std::string_view text) {
  int depth = 0;
  for (const char c : text) depth += (c == '[' || c == '{' ? 1 : 0) - (c == ']' || c == '}' ? 1 : 0);
  return depth;
}

// Behind YAML's tags and anchors: of OpenCV's "T_BS: !!opencv-matrix" nothing, so that it is a section.
std::string_view WithoutTags(std::string_view text) {
  while (!text.empty() && (text.front() == '!' || text.front() == '&')) {
    text = Trim(text.substr(std::min(text.find_first_of(" \t"), text.size())));
  }
  return text;
}

// The parts of a map in braces between its own commas, not those of lists in it; none behind a last comma.
std::vector<std::string_view> PartsOfMap(std::string_view map) {
  const std::string_view inside = map.substr(1, map.size() - 2);
  std::vector<std::string_view> parts;
  size_t begin = 0;
  int depth = 0;
  for (size_t i = 0; i < inside.size(); ++i) {
    depth += Depth(inside.substr(i, 1));
    if (inside[i] != ',' || depth > 0) continue;
    parts.push_back(Trim(inside.substr(begin, i - begin)));
    begin = i + 1;
  }
  const std::string_view last = Trim(inside.substr(begin));
  if (!last.empty()) parts.push_back(last);
  return parts;
}

// A line's key and the text after it, which may continue on the next lines.
struct Entry {
  std::string key, text;
  int line;
  size_t indent = 0;     // of the key
  int depth = 0;         // brackets that are still open
  bool is_list = false;  // with dashes

  void Append(std::string_view words) {
    const bool counts = depth > 0 || (!words.empty() && (words.front() == '[' || words.front() == '{'));
    if (!text.empty()) text += depth > 0 ? " " : ", ";
    text += words;
    if (counts) depth += Depth(words);
  }
};

// @throws FileError
Entry SplitAtColon(const std::string& path, int line, std::string_view text) {
  const size_t colon = text.find(':');
  const std::string key = WithoutQuotes(Trim(text.substr(0, colon)));
  const bool separates = colon != std::string_view::npos &&
                         (colon + 1 == text.size() || text[colon + 1] == ' ' || text[colon + 1] == '\t');
  if (!separates || key.empty() || key.find_first_of(" \t[]{}.\"'") != std::string::npos) {
    throw FileError(path + ":" + std::to_string(line) + ": expected \"key: value\", got " + TextReader::Quote(text));
  }
  Entry entry{key, "", line};
  entry.Append(WithoutTags(Trim(text.substr(colon + 1))));
  return entry;
}

// All keys by their paths, also those of sections, whose text is empty.
std::vector<Entry> ReadEntries(const std::string& path) {
  struct Section {
    size_t indent;  // of its key
    std::string prefix;
  };
  std::vector<Section> sections;
  std::vector<Entry> entries;
  TextReader reader(path);
  while (const std::optional<std::string_view> line = reader.ReadLine()) {
    const std::string_view text = WithoutComment(*line);
    std::string_view words = Trim(text);
    if (words.empty() || text.front() == '%' || words == "---" || words == "...") continue;
    Entry* const last = entries.empty() ? nullptr : &entries.back();
    const bool is_open = last && last->depth > 0, has_value = last && !last->text.empty() && !last->is_list;
    if (last && (is_open || IsItem(words))) {
      if (!is_open && has_value) reader.Fail(last->key + ": it has a value already, got " + TextReader::Quote(words));
      if (!is_open) last->is_list = true;
      while (IsItem(words)) words = Trim(words.substr(1));
      last->Append(words);
      continue;
    }
    const size_t indent = text.find_first_not_of(' ');
    if (text[indent] == '\t') reader.Fail("a tab indents the line; YAML takes spaces alone");
    if (has_value && indent > last->indent) {
      reader.Fail("the line is indented further than " + last->key + ", which has a value already, got " +
                  TextReader::Quote(words));
    }
    while (!sections.empty() && indent <= sections.back().indent) sections.pop_back();
    Entry entry = SplitAtColon(path, reader.Line(), words);
    entry.indent = indent;
    if (!sections.empty()) entry.key.insert(0, sections.back().prefix);
    if (entry.text.empty()) sections.push_back({indent, entry.key + "."});
    entries.push_back(std::move(entry));
  }
  return entries;
}

}  // namespace

YamlFile::YamlFile(const std::string& path, const std::string& section) : path_(path), section_(section) {
  for (const Entry& entry : ReadEntries(path)) {
    if (entry.depth > 0)
      Fail(entry.line, entry.key + ": a bracket is not closed, got " + TextReader::Quote(entry.text));
    if (entry.depth < 0)
      Fail(entry.line, entry.key + ": a bracket is closed that none opens, got " + TextReader::Quote(entry.text));
    if (entry.text.empty()) continue;
    if (entry.is_list || entry.text.front() != '{' || entry.text.back() != '}') {
      Add(entry.key, entry.text, entry.line);
      continue;
    }
    for (const std::string_view part : PartsOfMap(entry.text)) {
      const Entry inner = SplitAtColon(path, entry.line, part);
      Add(entry.key + "." + inner.key, inner.text, entry.line);
    }
  }
}

void YamlFile::Add(const std::string& key, const std::string& text, int line) {
  const auto [existing, is_new] = values_.emplace(key, Value{WithoutQuotes(text), line});
  if (!is_new) Fail(line, key + ": given in line " + std::to_string(existing->second.line) + " already");
}

const YamlFile::Value* YamlFile::Find(const std::string& key) const {
  for (const std::string& path : {section_ + "." + key, key}) {
    if (const auto found = values_.find(path); found != values_.end()) {
      found->second.is_asked = true;
      return &found->second;
    }
  }
  return nullptr;
}

const YamlFile::Value& YamlFile::Get(const std::string& key) const {
  if (const Value* value = Find(key)) return *value;
  const auto first = values_.lower_bound(section_ + ".");
  const bool has_section = first != values_.end() && first->first.rfind(section_ + ".", 0) == 0;
  throw FileError(path_ + ": " + (has_section ? section_ + ": " : "") + key + " is missing");
}

std::vector<double> YamlFile::Numbers(const std::string& key, size_t count, size_t most) const {
  std::string list = Get(key).text;
  std::replace_if(
      list.begin(), list.end(), [](char c) { return c == '[' || c == ']'; }, ' ');
  std::vector<double> numbers;
  for (const std::string_view part : SplitAt(',', list)) {
    if (part.empty() && count > 1) continue;  // behind a last comma
    numbers.emplace_back();
    if (const std::string why = TextReader::ParseDouble(WithoutQuotes(part), &numbers.back()); !why.empty())
      Fail(key, why);
  }
  if (numbers.size() < count || numbers.size() > std::max(count, most)) {
    const std::string or_most = most > count ? " to " + std::to_string(most) : "";
    Fail(key, "must be " + std::to_string(count) + or_most + (count == 1 ? " number" : " numbers") + ", got " +
                  std::to_string(numbers.size()));
  }
  return numbers;
}

double YamlFile::Number(const std::string& key, double low, double high) const {
  const double number = Numbers(key, 1)[0];
  if (number >= low && number <= high) return number;
  std::ostringstream message;
  message << "must lie in [" << low << ", " << high << "], got " << number;
  Fail(key, message.str());
}

double YamlFile::Positive(const std::string& key) const {
  const double number = Numbers(key, 1)[0];
  if (!(number > 0.0)) Fail(key, "must be positive, got " + std::to_string(number));
  return number;
}

void YamlFile::Fail(const std::string& key, const std::string& message) const {
  Fail(Get(key).line, key + ": " + message);
}

void YamlFile::Fail(int line, const std::string& message) const {
  throw FileError(path_ + ":" + std::to_string(line) + ": " + message);
}

}  // namespace ch5
