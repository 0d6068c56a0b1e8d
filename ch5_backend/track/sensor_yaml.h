#pragma once
/// A `sensor.yaml` of EuRoC's layout: `%YAML:1.0`, `key: value` with one level of sections, lists that may go over several
/// lines, comments behind values. Keys that nobody asks for are passed over: publishers add their own.

#include <map>
#include <string>
#include <vector>

#include "ch5_backend/math/so3.h"

namespace ch5 {

class SensorYaml {
 public:
  /// @throws FileError if it cannot be read, or a line is none of the above
  explicit SensorYaml(const std::string& path);

  bool Has(const std::string& key) const { return values_.count(key) > 0; }
  /// The text behind `key`, such as "resolution" or "T_BS.data".  @throws FileError if there is none
  std::string Word(const std::string& key) const;
  /// @throws FileError unless they are so many finite numbers
  std::vector<double> Numbers(const std::string& key, size_t count) const;
  double Positive(const std::string& key) const;
  /// T_BS, which maps sensor coordinates into the body's, as 16 numbers row by row.
  /// @throws FileError unless RᵀR = I and det R = 1 within 1e-3, and the last row is 0 0 0 1
  Transform T_B_S() const;
  [[noreturn]] void Fail(const std::string& key, const std::string& message) const;

 private:
  struct Value {
    std::string text;
    int line;
  };
  std::string path_;
  std::map<std::string, Value> values_;
};

}  // namespace ch5
