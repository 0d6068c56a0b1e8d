#pragma once
/// How judge and worker talk: frames over two descriptors.
///
///   frame     "ch5!", then the payload's length (4 bytes, little-endian), then the payload
///   question  a check's name, and the values that it is given
///   reply     whether the check has returned, the words of its exception, and the values that it has answered with
///   greeting  the worker's first frame, before any of the student's code has run
///
/// A reader trusts nothing: whatever does not fit is a WireError. Any double is a number, NaN too.

#include <cstdint>
#include <optional>
#include <string>
#include <utility>

#include "ch5_homework/judge/values.h"

namespace ch5::homework {

constexpr size_t kMaxFrame = size_t{64} << 20;  ///< bytes of a payload
constexpr int kMaxRows = 4096;                  ///< rows or columns of a matrix
constexpr size_t kMaxValues = 1000;             ///< of an answer
constexpr char kGreeting[] = "hello";

class Writer {
 public:
  void Int(int64_t value);
  void String(const std::string& text);
  void Matrix(const MatXX& A);
  void All(const Values& values);
  const std::string& Bytes() const { return bytes_; }

 private:
  std::string bytes_;
};

class Reader {
 public:
  explicit Reader(std::string bytes) : bytes_(std::move(bytes)) {}

  int64_t Int();
  bool Bool();
  std::string String();
  MatXX Matrix();
  /// @throws WireError also if two have one name
  void All(Values* values);
  /// @throws WireError unless all has been read
  void End() const;

 private:
  const char* Take(size_t size);
  /// How many items follow, each of which takes a byte at least.
  size_t Count();
  size_t Left() const { return bytes_.size() - at_; }

  std::string bytes_;
  size_t at_ = 0;
};

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
