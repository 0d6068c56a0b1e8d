#pragma once
/// A text file as a stream of numbers, read with suspicion: every error names the file, the line and the value.

#include <stdexcept>
#include <string>
#include <string_view>

namespace ch5 {

/// A file that cannot be read or understood. what() reads "file:line: what is wrong, got value".
class FileError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

class TextReader {
 public:
  /// Reads the whole file (a regular file or a pipe) into memory.
  /// @throws FileError if it cannot be opened or read
  explicit TextReader(const std::string& path);

  /// Names what is read next, such as ("observation", 12), for messages. `name` must outlive the reader.
  void BeginRecord(const char* name, int index) {
    record_ = name;
    index_ = index;
  }

  /// The next number, `what` in words.
  /// @throws FileError at the end of the file, or unless it is a whole number in [low, high]
  int ReadInt(const char* what, int low, int high);
  /// @throws FileError at the end of the file, or unless it is a finite number with |x| ≤ kLargest
  double ReadDouble(const char* what);
  /// @throws FileError if anything but white space follows
  void ExpectEnd();

  /// "file:line: record: message", the line being that of the last number.
  [[noreturn]] void Fail(const std::string& message) const;

  size_t BytesLeft() const { return static_cast<size_t>(end_ - next_); }
  /// Line of the last number, from 1.
  int Line() const { return line_; }

  /// Nothing that is measured or estimated here is larger; squares and products of such numbers stay finite.
  static constexpr double kLargest = 1e15;

 private:
  std::string_view NextToken(const char* what);

  std::string path_;
  std::string text_;
  const char* next_ = nullptr;
  const char* end_ = nullptr;
  int line_ = 1;
  const char* record_ = nullptr;
  int index_ = 0;
};

}  // namespace ch5
