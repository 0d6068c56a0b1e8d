#pragma once
/// How judge and worker talk: frames of numbers over two descriptors.
///
///   frame    "ch5!", then the payload's length (4 bytes, little-endian), then the payload
///   request  the function's name, then its arguments
///   reply    whether it returned; then its results, or the words of its exception
///   greeting the worker's first frame, before any of the student's code has run
///
/// A reader trusts nothing: whatever does not fit is a WireError. Any double is a number, NaN too.

#include <cstdint>
#include <optional>
#include <string>
#include <tuple>
#include <type_traits>
#include <utility>
#include <vector>

#include "ch5_homework/judge/values.h"

namespace ch5::homework {

constexpr size_t kMaxFrame = size_t{64} << 20;  ///< bytes of a payload
constexpr int kMaxRows = 4096;                  ///< rows or columns of a matrix
constexpr size_t kMaxValues = 1000;             ///< of an answer
constexpr char kGreeting[] = "hello";

class Writer {
 public:
  void Int(int64_t value);
  void Double(double value);
  void String(const std::string& text);
  void Matrix(const MatXX& A);
  const std::string& Bytes() const { return bytes_; }

 private:
  std::string bytes_;
};

class Reader {
 public:
  explicit Reader(std::string bytes) : bytes_(std::move(bytes)) {}

  int64_t Int();
  double Double();
  std::string String();
  MatXX Matrix();
  /// How many items follow, each of which takes a byte at least.
  size_t Count();
  /// @throws WireError unless all has been read
  void End() const;

 private:
  const char* Take(size_t size);
  size_t Left() const { return bytes_.size() - at_; }

  std::string bytes_;
  size_t at_ = 0;
};

// ---- numbers, words, matrices, lists ---------------------------------------------------------------------------------

template <typename T>
constexpr bool kIsWhole = std::is_integral_v<T> || std::is_enum_v<T>;

template <typename T, std::enable_if_t<kIsWhole<T>, int> = 0>
Writer& operator<<(Writer& out, T value) {
  out.Int(static_cast<int64_t>(value));
  return out;
}
inline Writer& operator<<(Writer& out, double value) {
  out.Double(value);
  return out;
}
inline Writer& operator<<(Writer& out, const std::string& text) {
  out.String(text);
  return out;
}
template <typename D>
Writer& operator<<(Writer& out, const Eigen::MatrixBase<D>& A) {
  out.Matrix(A);
  return out;
}
inline Writer& operator<<(Writer& out, const Qd& q) { return out << q.coeffs(); }
template <typename T>
Writer& operator<<(Writer& out, const std::vector<T>& items) {
  out << items.size();
  for (const T& item : items) out << item;
  return out;
}
template <typename A, typename B>
Writer& operator<<(Writer& out, const std::pair<A, B>& two) {
  return out << two.first << two.second;
}

template <typename T, std::enable_if_t<kIsWhole<T>, int> = 0>
Reader& operator>>(Reader& in, T& value) {
  const int64_t number = in.Int();
  value = static_cast<T>(number);
  if (static_cast<int64_t>(value) != number) throw WireError("the number " + std::to_string(number) + " is too large");
  return in;
}
inline Reader& operator>>(Reader& in, double& value) {
  value = in.Double();
  return in;
}
inline Reader& operator>>(Reader& in, std::string& text) {
  text = in.String();
  return in;
}
template <int R, int C, int O, int MR, int MC>
Reader& operator>>(Reader& in, Eigen::Matrix<double, R, C, O, MR, MC>& A) {
  const MatXX read = in.Matrix();
  if ((R != Eigen::Dynamic && read.rows() != R) || (C != Eigen::Dynamic && read.cols() != C)) {
    throw WireError("a matrix of " + std::to_string(read.rows()) + "×" + std::to_string(read.cols()) +
                    " came for one of " + std::to_string(R) + "×" + std::to_string(C));
  }
  A = read;
  return in;
}
inline Reader& operator>>(Reader& in, Qd& q) { return in >> q.coeffs(); }
template <typename T>
Reader& operator>>(Reader& in, std::vector<T>& items) {
  items.clear();
  for (size_t n = in.Count(); n > 0; --n) {
    items.emplace_back();
    in >> items.back();
  }
  return in;
}
template <typename A, typename B>
Reader& operator>>(Reader& in, std::pair<A, B>& two) {
  return in >> two.first >> two.second;
}

template <typename... T>
Writer& operator<<(Writer& out, const std::tuple<T&...>& members) {
  std::apply([&](const auto&... member) { ((out << member), ...); }, members);
  return out;
}
template <typename... T>
Reader& operator>>(Reader& in, const std::tuple<T&...>& members) {
  std::apply([&](auto&... member) { ((in >> member), ...); }, members);
  return in;
}

/// What has a function Fields(x, Wire()), which ties its members, travels as these do.
struct Wire {};
template <typename T>
auto operator<<(Writer& out, const T& x) -> decltype(Fields(const_cast<T&>(x), Wire()), out) {
  return out << Fields(const_cast<T&>(x), Wire());
}
template <typename T>
auto operator>>(Reader& in, T& x) -> decltype(Fields(x, Wire()), in) {
  return in >> Fields(x, Wire());
}

Writer& operator<<(Writer& out, const Values& values);
/// @throws WireError if two have one name
Reader& operator>>(Reader& in, Values& values);

/// Everything one after the other.
template <typename... A>
Writer Pack(const A&... values) {
  Writer out;
  ((out << values), ...);
  return out;
}
// ---- frames ----------------------------------------------------------------------------------------------------------

/// @throws WireError if the payload is too long
std::string Framed(const std::string& payload);
/// Takes the payload of the first frame off the bytes that have come; nothing while it is incomplete.
/// @throws WireError if no frame begins there, or it is too long
std::optional<std::string> TakeFrame(std::string* bytes);

/// Waits for a frame. @return false at the end of the file;  @throws WireError
bool ReadFrame(int descriptor, std::string* payload);
/// @return false if nobody reads any more
bool WriteFrame(int descriptor, const std::string& payload);

}  // namespace ch5::homework
