#pragma once
/// A small YAML file as values by their paths, such as "camera.intrinsics.fx": the recordings' calibration.yaml, a sensor.yaml
/// of EuRoC's layout (`%YAML:1.0`), or one of Kalibr's.
///
/// Sections by indentation, `key: value`, `key: {a: 1, b: 2}`, lists in brackets or with dashes, over several lines too,
/// comments. Every error names the file, the line and the value.

#include <map>
#include <string>
#include <vector>

#include "ch5_backend/files/text_reader.h"

namespace ch5 {

class YamlFile {
 public:
  /// @param section  where keys are looked for before they are outside of all sections
  /// @throws FileError if it cannot be read, a line is not one of the above, or a key is given twice
  explicit YamlFile(const std::string& path, const std::string& section = "");

  bool Has(const std::string& key) const { return Find(key) != nullptr; }
  /// The text after `key`, without quotes.  @throws FileError if there is none
  const std::string& Word(const std::string& key) const { return Get(key).text; }
  /// @throws FileError unless they are so many finite numbers, or up to `most`
  std::vector<double> Numbers(const std::string& key, size_t count, size_t most = 0) const;
  /// @throws FileError unless it is one number in [low, high], or above 0
  double Number(const std::string& key, double low, double high) const;
  double Positive(const std::string& key) const;

  /// The text after a key.
  struct Value {
    std::string text;               ///< without quotes
    int line;                       ///< of the key
    mutable bool is_asked = false;  ///< by one of the functions above
  };
  /// All of them, to find keys that were never read.
  const std::map<std::string, Value>& Values() const { return values_; }
  /// "file:line: key: message", the key being one that is there
  [[noreturn]] void Fail(const std::string& key, const std::string& message) const;

 private:
  const Value* Find(const std::string& key) const;
  const Value& Get(const std::string& key) const;
  [[noreturn]] void Fail(int line, const std::string& message) const;
  void Add(const std::string& key, const std::string& text, int line);

  std::string path_, section_;
  std::map<std::string, Value> values_;
};

}  // namespace ch5
