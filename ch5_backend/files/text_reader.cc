#include "ch5_backend/files/text_reader.h"

#include <sys/stat.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <memory>

namespace ch5 {
namespace {

struct FileCloser {
  void operator()(std::FILE* file) const { std::fclose(file); }
};

// Of a file that has an end.
std::string ReadAll(const std::string& path) {
  const auto fail = [&](const std::string& why) { throw FileError(path + ": cannot be read: " + why); };
  struct stat status;
  if (stat(path.c_str(), &status) != 0) fail(std::strerror(errno));
  if (S_ISDIR(status.st_mode)) fail("it is a directory");
  if (!S_ISREG(status.st_mode)) fail("it is not a regular file");
  const std::unique_ptr<std::FILE, FileCloser> file(std::fopen(path.c_str(), "rbe"));
  if (!file) fail(std::strerror(errno));
  std::string text;
  size_t used = 0;
  while (!std::feof(file.get())) {
    text.resize(std::max(static_cast<size_t>(status.st_size), used) + 65536);  // room for one more byte shows the end
    used += std::fread(text.data() + used, 1, text.size() - used, file.get());
    if (std::ferror(file.get())) fail(std::strerror(errno));
  }
  text.resize(used);
  return text;
}

bool IsSpace(char c) { return c == ' ' || (c >= '\t' && c <= '\r'); }

// One leading '+', which from_chars does not take.
std::string_view WithoutPlus(std::string_view token) {
  const bool has_plus = token.size() > 1 && token[0] == '+' && token[1] != '-';
  return token.substr(has_plus ? 1 : 0);
}

}  // namespace

std::string_view Trim(std::string_view text) {
  const size_t begin = text.find_first_not_of(" \t");
  if (begin == std::string_view::npos) return {};
  return text.substr(begin, text.find_last_not_of(" \t") - begin + 1);
}

std::vector<std::string_view> SplitAt(char separator, std::string_view text) {
  std::vector<std::string_view> pieces;
  for (size_t end; (end = text.find(separator)) != std::string_view::npos; text.remove_prefix(end + 1)) {
    pieces.push_back(Trim(text.substr(0, end)));
  }
  pieces.push_back(Trim(text));
  return pieces;
}

std::vector<std::string_view> Words(std::string_view text) {
  constexpr char kSpaces[] = " \t\r\v\f";
  std::vector<std::string_view> words;
  for (size_t begin; (begin = text.find_first_not_of(kSpaces)) != std::string_view::npos;) {
    const size_t end = std::min(text.find_first_of(kSpaces, begin), text.size());
    words.push_back(text.substr(begin, end - begin));
    text.remove_prefix(end);
  }
  return words;
}

TextReader::TextReader(const std::string& path) : path_(path), text_(ReadAll(path)) {
  if (text_.find('\n') == std::string::npos) std::replace(text_.begin(), text_.end(), '\r', '\n');  // as of old Macs
  next_ = text_.data();
  end_ = next_ + text_.size();
  if (text_.compare(0, 3, "\xef\xbb\xbf") == 0) next_ += 3;  // a byte order mark, as spreadsheets write
  const bool is_bzip2 = text_.size() > 9 && text_.compare(0, 3, "BZh") == 0 && text_.compare(4, 6, "1AY&SY") == 0;
  const auto begins = [&](std::string_view start) { return text_.compare(0, start.size(), start) == 0; };
  constexpr std::string_view kOthers[] = {"\x1f\x8b", "PK\x03\x04", "\xfd\x37zXZ", "\x28\xb5\x2f\xfd"};
  if (is_bzip2 || std::any_of(std::begin(kOthers), std::end(kOthers), begins)) {
    Fail("the file is compressed; unpack it first (bunzip2, gunzip, unzip, unxz or unzstd)");
  }
  if (begins("version https://git-lfs")) Fail("a pointer of Git LFS, not the file itself; git lfs pull fetches that");
  if (begins("<!DOCTYPE") || begins("<!doctype") || begins("<html")) Fail("a web page, not the file itself");
  if (text_.compare(0, 2, "\xff\xfe") == 0 || text_.compare(0, 2, "\xfe\xff") == 0) {
    Fail("the file is in UTF-16; save it as UTF-8");
  }
}

std::string_view TextReader::NextToken(const char* what, const char* kind) {
  for (; next_ != end_ && IsSpace(*next_); ++next_) line_ += *next_ == '\n';
  if (next_ == end_) Fail(std::string(what) + ": the file ends where " + kind + " is expected");
  const char* begin = next_;
  while (next_ != end_ && !IsSpace(*next_)) ++next_;
  return {begin, static_cast<size_t>(next_ - begin)};
}

int64_t TextReader::ToInteger(std::string_view token, const char* what, int64_t low, int64_t high) const {
  const std::string_view digits = WithoutPlus(token);
  int64_t value = 0;
  const auto [stop, error] = std::from_chars(digits.data(), digits.data() + digits.size(), value);
  const bool is_whole = stop == digits.data() + digits.size() && error != std::errc::invalid_argument;
  if (!is_whole) Fail(std::string(what) + ": not a whole number, got " + Quote(token));
  if (error == std::errc::result_out_of_range || value < low || value > high) {
    Fail(std::string(what) + ": must lie in [" + std::to_string(low) + ", " + std::to_string(high) + "], got " +
         Quote(token));
  }
  return value;
}

std::string TextReader::ParseDouble(std::string_view token, double* value) {
  const std::string_view digits = WithoutPlus(token);
  const auto [stop, error] = std::from_chars(digits.data(), digits.data() + digits.size(), *value);
  if (stop != digits.data() + digits.size() || error == std::errc::invalid_argument) {
    return "not a number, got " + Quote(token);
  }
  // Out of range is too large or too small for a double, and from_chars does not say which: strtod does.
  if (error == std::errc::result_out_of_range) *value = std::strtod(std::string(digits).c_str(), nullptr);
  if (!std::isfinite(*value) && error == std::errc()) return "not finite, got " + Quote(token);
  if (std::abs(*value) > kLargest) return "absurdly large (beyond 1e15), got " + Quote(token);
  return "";
}

double TextReader::ToDouble(std::string_view token, const char* what) const {
  double value = 0.0;
  if (const std::string why = ParseDouble(token, &value); !why.empty()) Fail(std::string(what) + ": " + why);
  return value;
}

// By patience sorting from the end: heads[k] is where the best sequence of k + 1 stamps begins.
std::vector<bool> OutOfOrder(const std::vector<double>& stamps) {
  std::vector<size_t> heads, next(stamps.size());
  for (size_t i = stamps.size(); i-- > 0;) {
    const auto place =
        std::partition_point(heads.begin(), heads.end(), [&](size_t k) { return stamps[k] >= stamps[i]; });
    if (place != heads.begin()) next[i] = *(place - 1);
    place == heads.end() ? heads.push_back(i) : void(*place = i);
  }
  std::vector<bool> is_out(stamps.size(), true);
  size_t i = heads.empty() ? 0 : heads.back();
  for (size_t length = heads.size(); length > 0; --length, i = next[i]) is_out[i] = false;
  return is_out;
}

std::set<int> LinesOutOfOrder(const std::vector<LineStamp>& stamps) {
  std::vector<double> all;
  for (const LineStamp& line : stamps) all.push_back(line.stamp);
  const std::vector<bool> is_out = OutOfOrder(all);
  std::set<int> out;
  for (size_t k = 0; k < stamps.size(); ++k)
    if (is_out[k]) out.insert(stamps[k].line);
  return out;
}

std::optional<std::string_view> TextReader::ReadLine() {
  if (in_line_ && next_ != end_) {  // over the end of the line before
    ++next_;
    ++line_;
  }
  if (next_ == end_) return std::nullopt;
  in_line_ = true;
  const char* begin = next_;
  while (next_ != end_ && *next_ != '\n') ++next_;
  const bool has_return = next_ != begin && next_[-1] == '\r';
  return std::string_view(begin, static_cast<size_t>(next_ - begin) - (has_return ? 1 : 0));
}

void TextReader::ExpectWord(const char* word) {
  const std::string_view token = ReadWord(word);
  if (token != word) Fail("expected " + Quote(word) + ", got " + Quote(token));
}

void TextReader::ExpectEnd() {
  for (; next_ != end_ && IsSpace(*next_); ++next_) line_ += *next_ == '\n';
  if (next_ == end_) return;
  record_ = nullptr;
  Fail("text after the end of the data, got " + Quote(ReadWord("")));
}

std::string TextReader::Quote(std::string_view token) {
  constexpr size_t kLongest = 32;
  std::string quoted = "\"";
  for (const char c : token.substr(0, kLongest)) {
    if (c >= ' ' && c <= '~') {
      quoted += c;
    } else {
      constexpr char kHex[] = "0123456789abcdef";
      const auto byte = static_cast<unsigned char>(c);
      quoted += {'\\', 'x', kHex[byte >> 4], kHex[byte & 15]};
    }
  }
  return quoted + (token.size() > kLongest ? "…\"" : "\"");
}

std::string TextReader::UnendedLine() const {
  if (text_.empty() || IsSpace(text_.back())) return "";
  const auto line = 1 + std::count(text_.begin(), text_.end(), '\n');
  const std::string_view last = std::string_view(text_).substr(text_.find_last_of(" ,;\t\n") + 1);
  return path_ + ":" + std::to_string(line) +
         ": the file ends without a line's end; if it is cut, so may be its last number, " + Quote(last);
}

void TextReader::Fail(const std::string& message) const {
  const std::string record = record_ ? std::string(record_) + " " + std::to_string(index_) + ", " : "";
  FailAt(line_, record + message);
}

void TextReader::FailAt(int line, const std::string& message) const {
  throw FileError(path_ + ":" + std::to_string(line) + ": " + message);
}

}  // namespace ch5
