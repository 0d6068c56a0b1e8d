#include "ch5_backend/lab/query.h"

#include <cmath>
#include <cstdlib>
#include <sstream>

namespace ch5::lab {
namespace {

std::vector<std::string> Split(const std::string& text, char separator) {
  std::vector<std::string> parts;
  std::istringstream stream(text);
  for (std::string part; std::getline(stream, part, separator);) parts.push_back(part);
  return parts;
}

// The whole word as a number, or NaN.
double ToNumber(const std::string& word) {
  char* end = nullptr;
  const double value = std::strtod(word.c_str(), &end);
  return !word.empty() && *end == '\0' ? value : std::nan("");
}

template <typename T>
std::string Range(const char* what, T low, T high) {
  std::ostringstream words;
  words << what << " from " << low << " to " << high;
  return words.str();
}

}  // namespace

Query::Query(const std::string& text) {
  for (const std::string& part : Split(text, '&')) {
    const size_t equals = part.find('=');
    if (equals == std::string::npos) {
      Refuse(part, "", "NAME=VALUE");
    } else {
      entries_[part.substr(0, equals)].value = part.substr(equals + 1);
    }
  }
}

const std::string* Query::Find(const std::string& name) {
  const auto found = entries_.find(name);
  if (found == entries_.end()) return nullptr;
  found->second.is_read = true;
  return &found->second.value;
}

void Query::Refuse(const std::string& name, const std::string& value, const std::string& wanted) {
  if (fault_.empty()) fault_ = name + " must be " + wanted + ", got '" + value + "'";
}

double Query::Number(const std::string& name, double usual, double low, double high) {
  const std::string* text = Find(name);
  if (!text) return usual;
  const double value = ToNumber(*text);
  if (value >= low && value <= high) return value;
  Refuse(name, *text, Range("a number", low, high));
  return usual;
}

int Query::Whole(const std::string& name, int usual, int low, int high) {
  const std::string* text = Find(name);
  if (!text) return usual;
  const double value = ToNumber(*text);
  if (value >= low && value <= high && value == std::floor(value)) return static_cast<int>(value);
  Refuse(name, *text, Range("a whole number", low, high));
  return usual;
}

int Query::Word(const std::string& name, std::initializer_list<const char*> words) {
  const std::string* text = Find(name);
  if (!text) return 0;
  std::string wanted = "one of";
  int position = 0;
  for (const char* word : words) {
    if (*text == word) return position;
    wanted += std::string(position++ ? ", " : " ") + word;
  }
  Refuse(name, *text, wanted);
  return 0;
}

std::vector<int> Query::Numbers(const std::string& name, int low, int high) {
  std::vector<int> numbers;
  const std::string* text = Find(name);
  if (!text) return numbers;
  for (const std::string& word : Split(*text, ',')) {
    const double value = ToNumber(word);
    if (!(value >= low && value <= high && value == std::floor(value))) {
      Refuse(name, *text, Range("whole numbers", low, high) + ", separated by commas");
      return {};
    }
    numbers.push_back(static_cast<int>(value));
  }
  return numbers;
}

bool Query::IsGood() {
  for (const auto& [name, entry] : entries_) {
    if (fault_.empty() && !entry.is_read) fault_ = "'" + name + "' is not a setting of this panel";
  }
  return fault_.empty();
}

}  // namespace ch5::lab
