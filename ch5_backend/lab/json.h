#pragma once
/// What the lab answers: one JSON object, whose numbers are read back to the bit.

#include <string>
#include <vector>

#include "ch5_backend/math/eigen_types.h"
#include "ch5_backend/types/measurements.h"

namespace ch5::lab {

class Json;

/// Infinity and NaN, which JSON does not have, become null.
std::string ToJson(double value);
std::string ToJson(bool value);
std::string ToJson(const std::string& text);
std::string ToJson(const char* text);
std::string ToJson(const VecX& v);
/// {"rows": …, "cols": …, "values": […]}, row by row.
std::string ToJson(const MatXX& M);
/// {"p": [x, y, z], "R": nine numbers, row by row}.
std::string ToJson(const Transform& T);
std::string ToJson(const Json& object);
inline std::string ToJson(int value) { return std::to_string(value); }
inline std::string ToJson(const Vec3& v) { return ToJson(VecX(v)); }

template <typename T>
std::string ToJson(const std::vector<T>& items) {
  std::string text;
  for (const auto& item : items) text += (text.empty() ? "[" : ",") + ToJson(item);
  return text.empty() ? "[]" : text + "]";
}

class Json {
 public:
  template <typename T>
  Json& Add(const char* name, const T& value) {
    text_ += (text_.empty() ? "" : ",") + ToJson(name) + ":" + ToJson(value);
    return *this;
  }
  std::string Text() const { return "{" + text_ + "}"; }

 private:
  std::string text_;
};

/// A variable of a matrix: its kind ("pose", "landmark", …), number, first row and number of rows.
inline Json VariableJson(const std::string& kind, int number, int row, int rows) {
  return Json().Add("kind", kind).Add("number", number).Add("row", row).Add("rows", rows);
}

}  // namespace ch5::lab
