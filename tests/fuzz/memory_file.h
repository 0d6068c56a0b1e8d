#pragma once
/// What the fuzz targets share: a file in memory for the readers, which take paths, and claims that end the program.

#include <sys/mman.h>
#include <unistd.h>

#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <string_view>

namespace ch5::fuzz {

/// Ends the program, which libFuzzer reports with the input at fault.
inline void Require(bool holds, const char* claim) {
  if (holds) return;
  std::fprintf(stderr, "does not hold: %s\n", claim);
  std::abort();
}

/// A regular file without a disk. Linux only, as libFuzzer is used here.
class MemoryFile {
 public:
  MemoryFile() : file_(memfd_create("fuzz", 0)), path_("/proc/self/fd/" + std::to_string(file_)) {
    Require(file_ >= 0, "a file in memory can be made");
  }
  MemoryFile(const MemoryFile&) = delete;
  MemoryFile& operator=(const MemoryFile&) = delete;
  ~MemoryFile() { close(file_); }

  const std::string& Path() const { return path_; }
  void Set(std::string_view text) const {
    const bool is_written =
        ftruncate(file_, 0) == 0 && pwrite(file_, text.data(), text.size(), 0) == static_cast<ssize_t>(text.size());
    Require(is_written, "a file in memory can be written");
  }

 private:
  int file_;
  std::string path_;
};

inline std::string_view Text(const uint8_t* data, size_t size) { return {reinterpret_cast<const char*>(data), size}; }

}  // namespace ch5::fuzz
