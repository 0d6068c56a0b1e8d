#pragma once
/// Where a student's code runs, memory holds NaN before it is written to and after it is given back (unset_memory.cc): what
/// is read too early or too late fails in every run, not at random, and the two kinds of NaN tell which it was. The compiler
/// fills the stack, with another pattern (-ftrivial-auto-var-init=pattern, judge/CMakeLists.txt).

#include <cstdint>
#include <cstring>

namespace ch5::homework {

constexpr uint64_t kFresh = 0x7FF800000000F5E5, kFreed = 0x7FF800000000F4EE;  // NaN; arithmetic keeps their low bits
constexpr uint64_t kFreshOfClang = 0x7FFFFFFFFFFFFFFF,
                   kFreshOfGcc = 0x7EFEFEFEFEFEFEFE;  // the latter is no NaN, but huge

inline bool HasBits(double x, uint64_t bits) {
  uint64_t own;
  std::memcpy(&own, &x, sizeof own);
  return (own & 0x7FFFFFFFFFFFFFFF) == bits;
}
/// Comes from memory that was never written to.
inline bool IsFresh(double x) { return HasBits(x, kFresh) || HasBits(x, kFreshOfClang) || HasBits(x, kFreshOfGcc); }
/// Comes from memory that had been given back.
inline bool IsFreed(double x) { return HasBits(x, kFreed); }

}  // namespace ch5::homework
