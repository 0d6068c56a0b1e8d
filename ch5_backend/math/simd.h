#pragma once
/// Four or eight doubles at a time, and functions that exist twice or thrice: for any processor, for those with AVX2 and
/// FMA, and for those with AVX-512.
///
/// A kernel is an inline function marked CH5_INLINE; CH5_WITH_AVX2 marks the copy that may use the wider registers:
///   CH5_INLINE void AddBody(…) { … }
///   void Add(…) { AddBody(…); }
///   CH5_WITH_AVX2 void AddAvx2(…) { AddBody(…); }
/// and HasAvx2() chooses once, at run time; likewise with AVX-512. They differ by rounding (FMA), so results are the same
/// to the bit on one machine, not between machines.

#include <cstddef>

#define CH5_INLINE inline __attribute__((always_inline))
#define CH5_FLATTEN __attribute__((flatten))  // everything called within is put in place: small matrices want it
#define CH5_UNROLL _Pragma("GCC unroll 16")   // without it, -O2 keeps the registers of a block in memory

#if defined(__x86_64__)
#define CH5_WITH_AVX2 __attribute__((target("avx2,fma")))
#define CH5_WITH_AVX512 __attribute__((target("avx512f,avx512dq,avx512vl,avx2,fma")))
#else
#define CH5_WITH_AVX2
#define CH5_WITH_AVX512
#endif

namespace ch5 {

enum class SimdLevel { kPortable, kAvx2, kAvx512 };

/// The widest registers that kernels may use: the processor's, or narrower ones if the environment variable CH5_SIMD
/// says so (portable, avx2 or avx512).
/// @throws std::invalid_argument if CH5_SIMD is another word, or more than the processor has
SimdLevel GetSimdLevel();

inline bool HasAvx2() { return GetSimdLevel() >= SimdLevel::kAvx2; }
inline bool HasAvx512() { return GetSimdLevel() >= SimdLevel::kAvx512; }

constexpr int kLanes = 4;

/// Four doubles anywhere in memory; compilers split it where registers are shorter.
typedef double Lanes __attribute__((vector_size(32), aligned(8), may_alias));
/// Eight of them.
typedef double WideLanes __attribute__((vector_size(64), aligned(8), may_alias));

/// `size` rounded up to whole Lanes.
constexpr int Padded(int size) { return (size + kLanes - 1) / kLanes * kLanes; }

}  // namespace ch5
