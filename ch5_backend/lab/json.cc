#include "ch5_backend/lab/json.h"

#include <cmath>
#include <cstdio>

namespace ch5::lab {
namespace {

void Append(double value, std::string* text) {
  if (value == 0.0) {  // most of a Hessian
    *text += '0';
  } else if (!std::isfinite(value)) {
    *text += "null";
  } else {
    char digits[32];
    *text += std::string_view(digits, std::snprintf(digits, sizeof(digits), "%.17g", value));
  }
}

template <typename Numbers>
std::string List(const Numbers& numbers) {
  std::string text = "[";
  for (int i = 0; i < numbers.rows(); ++i) {
    for (int j = 0; j < numbers.cols(); ++j) {
      if (text.size() > 1) text += ',';
      Append(numbers(i, j), &text);
    }
  }
  return text + "]";
}

}  // namespace

std::string ToJson(double value) {
  std::string text;
  Append(value, &text);
  return text;
}

std::string ToJson(bool value) { return value ? "true" : "false"; }

std::string ToJson(const char* text) { return ToJson(std::string(text)); }

std::string ToJson(const std::string& text) {
  std::string quoted = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') quoted += '\\';
    if (static_cast<unsigned char>(c) >= ' ') quoted += c;
  }
  return quoted + "\"";
}

std::string ToJson(const VecX& v) { return List(v); }

std::string ToJson(const MatXX& M) {
  return "{\"rows\":" + std::to_string(M.rows()) + ",\"cols\":" + std::to_string(M.cols()) + ",\"values\":" + List(M) +
         "}";
}

std::string ToJson(const Transform& T) {
  return "{\"p\":" + List(T.p) + ",\"R\":" + List(T.q.toRotationMatrix()) + "}";
}

std::string ToJson(const Json& object) { return object.Text(); }

}  // namespace ch5::lab
