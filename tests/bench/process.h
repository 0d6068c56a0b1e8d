#pragma once
/// What the operating system says of this process: its memory, its time, and the BLAS that it calls.

#include <dlfcn.h>
#include <time.h>

#include <cstdlib>
#include <fstream>
#include <string>

namespace ch5::bench {

/// A line of /proc/self/status in bytes, "VmRSS:" what is held now, "VmHWM:" the most so far; 0 where there is no such file.
inline double MemoryBytes(const std::string& key) {
  std::ifstream status("/proc/self/status");
  for (std::string line; std::getline(status, line);) {
    if (line.rfind(key, 0) == 0) return 1024.0 * std::atof(line.c_str() + key.size());
  }
  return 0.0;
}

/// Seconds since it was made: of the processor's time, which other programs disturb less than the clock's, or of the
/// clock's (`wall`), which count with more than one thread.
class Stopwatch {
 public:
  explicit Stopwatch(bool wall) : clock_(wall ? CLOCK_MONOTONIC : CLOCK_PROCESS_CPUTIME_ID), start_(Now()) {}
  double Seconds() const { return Now() - start_; }

 private:
  double Now() const {
    timespec time;
    clock_gettime(clock_, &time);
    return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
  }
  clockid_t clock_;
  double start_;
};

/// The file from which every library of this process takes dgemm_, as the dynamic linker has bound it; "" if none has it.
inline std::string BlasFile() {
  Dl_info found{};
  void* dgemm = dlsym(RTLD_DEFAULT, "dgemm_");
  return dgemm && dladdr(dgemm, &found) ? found.dli_fname : "";
}

}  // namespace ch5::bench
