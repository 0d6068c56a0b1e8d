#pragma once
/// A text file as a stream of numbers, or of lines, strictly checked: every error names the file, the line and
/// the value.

#include <cstdint>
#include <limits>
#include <optional>
#include <set>
#include <stdexcept>
#include <string>
#include <string_view>
#include <tuple>
#include <vector>

namespace ch5 {

/// `text` without spaces and tabs at its ends.
std::string_view Trim(std::string_view text);
/// The pieces of `text` between its separators, trimmed; at least one.
std::vector<std::string_view> SplitAt(char separator, std::string_view text);
/// The pieces of `text` between white space; perhaps none.
std::vector<std::string_view> Words(std::string_view text);

/// A file that cannot be read or understood. what() reads "file:line: what is wrong, got value".
class FileError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// The lines of a file that a reader has left out, so that a few damaged ones do not cost the whole.
struct LeftOut {
  std::string file;
  int count = 0;
  std::string first;  ///< "file:line: what is wrong, got value"
};

/// Calls `read`, which reads one line's item and returns false at the end, until then. What throws is left out and added to
/// `left_out`. More than one in `share` is not damage but a file that is not understood.
/// @param left_out  null: the first error is thrown
/// @throws FileError the first error, if so
template <typename Read>
void ReadEach(const std::string& file, std::vector<LeftOut>* left_out, const Read& read, int share = 20) {
  LeftOut here{file, 0, {}};
  int taken = 0;
  for (bool more = true; more;) {
    try {
      more = read();
      ++taken;
    } catch (const FileError& error) {
      if (!left_out) throw;
      if (here.count++ == 0) here.first = error.what();
    }
  }
  if (share * here.count > taken) throw FileError(here.first);
  if (here.count > 0) left_out->push_back(here);
}

/// The same of a truth, of which only more than a half is too much: motion capture that has lost sight writes no numbers.
template <typename Read>
void ReadPoses(const std::string& file, std::vector<LeftOut>* left_out, const Read& read) {
  ReadEach(file, left_out, read, 2);
}

/// Which of these, in the order of a file, are not in the longest sequence that never decreases: a stamp that jumps ahead is
/// wrong itself, not all those after it. Of two that are as long, the one whose missing stamps come later.
std::vector<bool> OutOfOrder(const std::vector<double>& stamps);

/// A stamp, in any unit, and the line that it is from.
struct LineStamp {
  int line;
  double stamp;
};
/// The lines of those that are OutOfOrder.
std::set<int> LinesOutOfOrder(const std::vector<LineStamp>& stamps);

class TextReader {
 public:
  /// Reads the whole file into memory.
  /// @throws FileError if it cannot be opened or read, or is no regular file: a pipe without a writer would
  ///         never end
  explicit TextReader(const std::string& path);

  /// Names what is read next, such as ("observation", 12), for messages. `name` must outlive the reader.
  void BeginRecord(const char* name, int index) {
    record_ = name;
    index_ = index;
  }
  /// What is read next belongs to no record.
  void EndRecord() { record_ = nullptr; }

  /// The next number, `what` in words.
  /// @throws FileError at the end of the file, or unless it is a whole number in [low, high]
  int ReadInt(const char* what, int low, int high) {
    return static_cast<int>(ToInteger(NextToken(what, "a number"), what, low, high));
  }
  /// @throws FileError at the end of the file, or unless it is a finite number with |x| ≤ kLargest
  double ReadDouble(const char* what) { return ToDouble(NextToken(what, "a number"), what); }
  /// The next word, `what` in words.  @throws FileError at the end of the file
  std::string_view ReadWord(const char* what) { return NextToken(what, "a word"); }
  /// @throws FileError unless the next word is `word`
  void ExpectWord(const char* word);
  /// @throws FileError if anything but white space follows
  void ExpectEnd();

  /// The next line without its end (LF or CR LF); nullopt at the end of the file. For files that are read by lines only.
  std::optional<std::string_view> ReadLine();

  /// The stamps of the lines that are left, as they stand there; these are read again afterwards.
  /// @param stamp_of  a line's stamp; a line without one is passed over
  template <typename StampOf>
  std::vector<LineStamp> Stamps(const StampOf& stamp_of) {
    const auto here = std::tuple(next_, line_, in_line_);
    std::vector<LineStamp> stamps;
    while (const auto line = ReadLine()) {
      double stamp = std::numeric_limits<double>::quiet_NaN();
      ParseDouble(Trim(stamp_of(*line)), &stamp);
      if (stamp == stamp) stamps.push_back({line_, stamp});
    }
    std::tie(next_, line_, in_line_) = here;
    return stamps;
  }

  /// Whether the line read last is cut off: the file ends in it, without a line's end.
  bool EndsInLine() const { return in_line_ && next_ == end_; }

  /// Of a file that does not end in a line's end: "file:line: …" with its last word, which may be half a number. Else empty.
  std::string UnendedLine() const;

  /// A piece of the current line as a number; the same errors as ReadInt and ReadDouble.
  int64_t ToInteger(std::string_view token, const char* what, int64_t low, int64_t high) const;
  double ToDouble(std::string_view token, const char* what) const;
  /// The same without a line: what is wrong with `token` as a number, or empty and `value` is set.
  static std::string ParseDouble(std::string_view token, double* value);

  /// "file:line: record: message", the line being that of the last number.
  [[noreturn]] void Fail(const std::string& message) const;
  /// "file:line: message" of another line.
  [[noreturn]] void FailAt(int line, const std::string& message) const;
  /// A piece of the text as messages show it: short, printable, in quotes.
  static std::string Quote(std::string_view token);

  size_t BytesLeft() const { return static_cast<size_t>(end_ - next_); }
  const std::string& Path() const { return path_; }
  /// Line of the last number, or the line read last, from 1.
  int Line() const { return line_; }

  /// Nothing that is measured or estimated here is larger; squares and products of such numbers stay finite.
  static constexpr double kLargest = 1e15;

 private:
  std::string_view NextToken(const char* what, const char* kind);

  std::string path_;
  std::string text_;
  const char* next_ = nullptr;
  const char* end_ = nullptr;
  int line_ = 1;
  bool in_line_ = false;  // ReadLine stopped before a line's end
  const char* record_ = nullptr;
  int index_ = 0;
};

}  // namespace ch5
