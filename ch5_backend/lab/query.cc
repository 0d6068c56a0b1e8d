#include "ch5_backend/lab/query.h"

#include <algorithm>
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

bool IsWhole(double value) { return value == std::floor(value); }

template <typename T>
std::string Range(T low, T high) {
  std::ostringstream words;
  words << low << " to " << high;
  return words.str();
}

}  // namespace

std::string QueryFault::Sentence() const {
  if (kind == "setting") return "'" + setting + "' is not a setting of this panel";
  const std::string wanted = kind == "one of" ? kind : kind == "list" ? "a list of" : "a " + kind + " from";
  return setting + " must be " + wanted + " " + limits + ", got '" + value + "'";
}

Query::Query(const std::string& text) {
  for (const std::string& part : Split(text, '&')) {
    const size_t equals = std::min(part.find('='), part.size());
    entries_[part.substr(0, equals)].value = part.substr(std::min(equals + 1, part.size()));
  }
}

const std::string* Query::Find(const std::string& name) {
  const auto found = entries_.find(name);
  if (found == entries_.end()) return nullptr;
  found->second.is_read = true;
  return &found->second.value;
}

void Query::Refuse(const std::string& name, const std::string& kind, const std::string& limits) {
  if (!fault_) fault_ = QueryFault{name, entries_[name].value, kind, limits};
}

double Query::Number(const std::string& name, double usual, double low, double high) {
  const std::string* text = Find(name);
  if (!text) return usual;
  const double value = ToNumber(*text);
  if (value >= low && value <= high) return value;
  Refuse(name, "number", Range(low, high));
  return usual;
}

int Query::Whole(const std::string& name, int usual, int low, int high) {
  const std::string* text = Find(name);
  if (!text) return usual;
  const double value = ToNumber(*text);
  if (value >= low && value <= high && IsWhole(value)) return static_cast<int>(value);
  Refuse(name, "whole number", Range(low, high));
  return usual;
}

int Query::Word(const std::string& name, std::initializer_list<const char*> words) {
  const std::string* text = Find(name);
  if (!text) return 0;
  std::string wanted;
  int position = 0;
  for (const char* word : words) {
    if (*text == word) return position;
    wanted += std::string(position++ ? ", " : "") + word;
  }
  Refuse(name, "one of", wanted);
  return 0;
}

std::vector<int> Query::Numbers(const std::string& name, int low, int high) {
  std::vector<int> numbers;
  const std::string* text = Find(name);
  if (!text) return numbers;
  for (const std::string& word : Split(*text, ',')) {
    const double value = ToNumber(word);
    if (!(value >= low && value <= high && IsWhole(value))) {
      Refuse(name, "list", "whole numbers from " + Range(low, high) + ", separated by commas");
      return {};
    }
    numbers.push_back(static_cast<int>(value));
  }
  return numbers;
}

std::vector<Query::Item> Query::Items(const std::string& name, size_t reals) {
  std::vector<Item> items;
  const std::string* text = Find(name);
  if (!text) return items;
  for (const std::string& words : Split(*text, ',')) {
    const std::vector<std::string> parts = Split(words, ':');
    const double number = parts.empty() ? -1.0 : ToNumber(parts[0]);
    bool is_good = parts.size() == reals + 1 && number >= 0.0 && number <= 999.0 && IsWhole(number);
    Item item{is_good ? static_cast<int>(number) : 0, {}};
    for (size_t i = 1; i < parts.size(); ++i) {
      item.reals.push_back(ToNumber(parts[i]));
      is_good = is_good && std::abs(item.reals.back()) <= 20.0;
    }
    if (!is_good) {
      Refuse(name, "list", reals == 2 ? "NUMBER:DX:DY" : "LANDMARK:FRAME");
      return {};
    }
    items.push_back(item);
  }
  return items;
}

bool Query::IsGood() {
  for (const auto& [name, entry] : entries_) {
    if (!entry.is_read) Refuse(name, "setting", "");
  }
  return !fault_;
}

}  // namespace ch5::lab
