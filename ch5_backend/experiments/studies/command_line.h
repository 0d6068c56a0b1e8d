#pragma once
/// The main() of every program: options that take a value, --help, each error as one line on standard error, and a line
/// of progress.

#include <unistd.h>

#include <cstdio>
#include <functional>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace ch5 {

/// The number in [low, high] that a word is, whole if T is.
/// @throws std::invalid_argument "must be a number from …"
template <typename T>  // int or double
T NumberIn(const std::string& word, T low, T high);

/// The value of the choice of this name.
/// @param choices  pairs of a name and a value
/// @throws std::invalid_argument "must be one of …"
template <typename T, size_t N>
T OneOf(const std::string& word, const std::pair<const char*, T> (&choices)[N]) {
  std::string known;
  for (const auto& [name, value] : choices) {
    if (name == word) return value;
    known.append(known.empty() ? "" : ", ").append(name);
  }
  throw std::invalid_argument("must be one of " + known + ", got '" + word + "'");
}

/// Declare what the program accepts, then call Run, which refuses everything else.
class CommandLine {
 public:
  /// @param usage  printed for --help
  CommandLine(std::string program, std::string usage);

  /// The one word that is not an option; it must be given.
  void Argument(const std::string& name, std::string* value);
  /// `option` TEXT, not empty; it must be given unless `value` holds a default.
  void Text(const std::string& option, std::string* value);
  /// `option` NUMBER in [low, high], whole if T is.
  template <typename T>  // int or double
  void Number(const std::string& option, T low, T high, T* value);
  /// `option` WORD, which `take` reads; it throws std::invalid_argument with what the word must be.
  void Option(const std::string& option, std::function<void(const std::string& word)> take);

  /// `option`, which takes no value.
  void Flag(const std::string& option, std::function<void()> set);

  /// Reads the words, then calls `run`. An exception is printed as "program: what is wrong".
  /// @return exit code: 0, or 2 after an error
  int Run(int argc, char** argv, const std::function<void()>& run);

 private:
  void Parse(int argc, char** argv);
  int Fail(const std::string& what) const;

  std::string program_, usage_, argument_name_;
  std::string* argument_ = nullptr;
  std::vector<std::pair<std::string, std::string*>> texts_;
  std::vector<std::pair<std::string, std::function<void(const std::string&)>>> options_;
  std::vector<std::pair<std::string, std::function<void()>>> flags_;
};

/// A line of progress on standard error, if that is a terminal; silence otherwise.
class Progress {
 public:
  Progress() : terminal_(isatty(STDERR_FILENO) == 1) {}
  ~Progress() { Clear(); }

  /// @param fraction  of this study, 0 … 1
  void Show(const std::string& study, double fraction) const {
    if (!terminal_) return;
    std::fprintf(stderr, "\r\033[K%s %3.0f %%", study.c_str(), 100.0 * fraction);
    std::fflush(stderr);
  }
  /// Erases the line.
  void Clear() const {
    if (terminal_) std::fputs("\r\033[K", stderr);
  }

 private:
  bool terminal_;
};

}  // namespace ch5
