#pragma once
/// A line of progress on standard error, if that is a terminal; silence otherwise.

#include <unistd.h>

#include <cstdio>
#include <string>

namespace ch5 {

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
  /// Makes room for other words.
  void Clear() const {
    if (terminal_) std::fputs("\r\033[K", stderr);
  }

 private:
  bool terminal_;
};

}  // namespace ch5
