#pragma once
/// What the operating system says of this process' memory.

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

}  // namespace ch5::bench
