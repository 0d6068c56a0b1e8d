#pragma once
/// The numbers of a small YAML file, by their paths: sections by indentation, `key: 1.5`, `key: [1, 2]` and
/// `key: {a: 1, b: 2}` on one line, comments. Anything else is an error: a calibration must not be read in part.

#include <map>
#include <string>
#include <vector>

#include "ch5_backend/files/text_reader.h"

namespace ch5 {

class YamlNumbers {
 public:
  /// @throws FileError
  explicit YamlNumbers(const std::string& path);

  /// Takes the number at a path such as "camera.intrinsics.fx" or "camera.resolution[1]".
  /// @throws FileError if there is none, or it lies outside [low, high]
  double Take(const std::string& key, double low, double high);
  /// Whether any number stands under a section that is not indented.
  bool HasSection(const std::string& name) const;
  /// What stands under `estimator:` and under further cameras (camera2, cam1, …), in the order of the file: words, which
  /// need not be numbers, for others to judge.
  struct Word {
    std::string key, word;
    int line;
  };
  const std::vector<Word>& Words() const { return words_; }
  /// @throws FileError naming a number that was not taken: a misspelled key
  void ExpectAllTaken() const;

 private:
  struct Number {
    double value;
    int line;
  };
  [[noreturn]] void Fail(int line, const std::string& message) const;
  void ReadValue(const TextReader& reader, const std::string& key, std::string_view value);
  void Add(const TextReader& reader, const std::string& key, std::string_view number);

  std::string path_;
  std::map<std::string, Number> numbers_;
  std::vector<Word> words_;
};

}  // namespace ch5
