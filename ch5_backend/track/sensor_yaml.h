#pragma once
/// What a YAML file says of a sensor: a `sensor.yaml` of EuRoC's layout (`%YAML:1.0`), or one of Kalibr's, which has a section for
/// each sensor and some keys of other names. `key: value` with one level of sections; lists over several lines, in brackets
/// or with dashes; comments behind values. Keys that nobody asks for are passed over: publishers add their own.

#include <map>
#include <string>
#include <vector>

#include "ch5_backend/math/so3.h"

namespace ch5 {

class SensorYaml {
 public:
  /// @param section  where keys are looked for before they are outside of all sections
  /// @throws FileError if it cannot be read, or a line is none of the above
  explicit SensorYaml(const std::string& path, const std::string& section = "");

  bool Has(const std::string& key) const { return Find(key) != values_.end(); }
  /// EuRoC's name of a key, unless only Kalibr's is there.
  std::string Name(const std::string& euroc, const std::string& kalibr) const;
  /// The text behind `key`, such as "resolution" or "T_BS.data".  @throws FileError if there is none
  std::string Word(const std::string& key) const;
  /// @throws FileError unless they are so many finite numbers
  std::vector<double> Numbers(const std::string& key, size_t count) const;
  double Positive(const std::string& key) const;
  /// T_BS, which maps sensor coordinates into the body's, as 16 numbers row by row; or Kalibr's T_cam_imu, its inverse.
  /// @throws FileError unless RᵀR = I and det R = 1 within 1e-3, and the last row is 0 0 0 1
  Transform T_B_S() const;
  [[noreturn]] void Fail(const std::string& key, const std::string& message) const;

 private:
  struct Value {
    std::string text;
    int line;
  };
  std::map<std::string, Value>::const_iterator Find(const std::string& key) const;
  Transform RigidTransform(const std::string& key) const;

  std::string path_, section_;
  std::map<std::string, Value> values_;
};

}  // namespace ch5
