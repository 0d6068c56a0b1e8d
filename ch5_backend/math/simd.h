#pragma once
/// Four or eight doubles at a time, and functions in two or three versions: for any processor, for those with AVX2 and
/// FMA, and for those with AVX-512.
///
/// A kernel is an inline function marked CH5_INLINE; CH5_WITH_AVX2 marks the copy that may use the wider registers:
///   CH5_INLINE void AddBody(…) { … }
///   void Add(…) { AddBody(…); }
///   CH5_WITH_AVX2 void AddAvx2(…) { AddBody(…); }
/// and HasAvx2() chooses once, at run time; likewise with AVX-512. They differ by rounding (FMA), so results are the same
/// to the bit on one machine, not between machines.

#include <cstddef>
#include <type_traits>

#define CH5_UNROLL _Pragma("GCC unroll 16")  // without it, -O2 keeps the registers of a block in memory

#if defined(CH5_PLAIN_KERNELS)  // for sanitizers, which would need minutes for one file: the bodies exist once
#define CH5_INLINE inline
#define CH5_FLATTEN
#else
#define CH5_INLINE inline __attribute__((always_inline))
#define CH5_FLATTEN __attribute__((flatten))  // inlines everything called within: small matrices need it
#endif

#if defined(__x86_64__) && !defined(CH5_PLAIN_KERNELS)
#define CH5_WITH_AVX2 __attribute__((target("avx2,fma")))
#define CH5_WITH_AVX512 __attribute__((target("avx512f,avx512dq,avx512vl,avx2,fma")))
#else
#define CH5_WITH_AVX2
#define CH5_WITH_AVX512
#endif

namespace ch5 {

/// Which registers kernels use.
enum class SimdLevel { kPortable, kAvx2, kAvx512 };

/// The widest registers that kernels may use: the processor's, or narrower ones if the environment variable CH5_SIMD
/// says so (portable, avx2 or avx512).
/// @throws std::invalid_argument if CH5_SIMD is another word, or more than the processor has
SimdLevel GetSimdLevel();

/// Whether GetSimdLevel allows them. Other processors have none, and get no copies for them.
#if defined(__x86_64__)
inline bool HasAvx2() { return GetSimdLevel() >= SimdLevel::kAvx2; }
inline bool HasAvx512() { return GetSimdLevel() >= SimdLevel::kAvx512; }
#else
constexpr bool HasAvx2() { return false; }
constexpr bool HasAvx512() { return false; }
#endif

constexpr int kLanes = 4;

/// Two, four or eight doubles in registers; compilers split them where registers are shorter. Any 64-bit processor has two.
typedef double NarrowLanes __attribute__((vector_size(16)));
typedef double Lanes __attribute__((vector_size(32)));
typedef double WideLanes __attribute__((vector_size(64)));
/// The same anywhere in memory. Only these are read or written through a pointer into an array of numbers: a compiler may
/// take a Lanes* for aligned to 32 bytes. (To GCC and Clang a vector may alias its elements; with may_alias said besides,
/// GCC 12 keeps such sums in memory, which costs a third of the time of schur_group.h.)
typedef double NarrowLanesInMemory __attribute__((vector_size(16), aligned(8)));
typedef double LanesInMemory __attribute__((vector_size(32), aligned(8)));
typedef double WideLanesInMemory __attribute__((vector_size(64), aligned(8)));

/// Any number of them, likewise, for code that also takes rows that are left over one by one.
template <int N>
struct Register {
  typedef double Type __attribute__((vector_size(8 * N), aligned(8), may_alias));
};

/// Two, four or eight numbers in memory, at any address.
CH5_INLINE NarrowLanesInMemory* AsNarrow(double* x) { return reinterpret_cast<NarrowLanesInMemory*>(x); }
CH5_INLINE const NarrowLanesInMemory* AsNarrow(const double* x) {
  return reinterpret_cast<const NarrowLanesInMemory*>(x);
}
CH5_INLINE LanesInMemory* AsLanes(double* x) { return reinterpret_cast<LanesInMemory*>(x); }
CH5_INLINE const LanesInMemory* AsLanes(const double* x) { return reinterpret_cast<const LanesInMemory*>(x); }
CH5_INLINE WideLanesInMemory* AsWide(double* x) { return reinterpret_cast<WideLanesInMemory*>(x); }
CH5_INLINE const WideLanesInMemory* AsWide(const double* x) { return reinterpret_cast<const WideLanesInMemory*>(x); }

/// The longest that is not longer than a register: GCC 12 takes longer ones apart through memory, which costs several
/// times as much.
template <SimdLevel kSimd>
using FittingLanes = std::conditional_t<kSimd == SimdLevel::kAvx512, WideLanes,
                                        std::conditional_t<kSimd == SimdLevel::kAvx2, Lanes, NarrowLanes>>;
CH5_INLINE void Load(const double* x, NarrowLanes* v) { *v = *AsNarrow(x); }
CH5_INLINE void Load(const double* x, Lanes* v) { *v = *AsLanes(x); }
CH5_INLINE void Load(const double* x, WideLanes* v) { *v = *AsWide(x); }
CH5_INLINE void Store(const NarrowLanes& v, double* x) { *AsNarrow(x) = v; }
CH5_INLINE void Store(const Lanes& v, double* x) { *AsLanes(x) = v; }
CH5_INLINE void Store(const WideLanes& v, double* x) { *AsWide(x) = v; }

/// A pack: eight items side by side, item k in lane k of WideLanes.
constexpr int kPack = 8;

/// Lane k of v[i] = from[k][i].
template <int N>
CH5_INLINE void GatherLanes(const double* const* from, NarrowLanes* v) {
  CH5_UNROLL
  for (int i = 0; i < N; ++i) v[i] = NarrowLanes{from[0][i], from[1][i]};
}
template <int N>
CH5_INLINE void GatherLanes(const double* const* from, Lanes* v) {
  CH5_UNROLL
  for (int i = 0; i < N; ++i) v[i] = Lanes{from[0][i], from[1][i], from[2][i], from[3][i]};
}
template <int N>
CH5_INLINE void GatherLanes(const double* const* from, WideLanes* v) {
  CH5_UNROLL
  for (int i = 0; i < N; ++i) {
    v[i] = WideLanes{from[0][i], from[1][i], from[2][i], from[3][i], from[4][i], from[5][i], from[6][i], from[7][i]};
  }
}

/// out = numbers I… of a and b, counted on from a's to b's.
template <int... I>
CH5_INLINE void Shuffle(const Lanes& a, const Lanes& b, Lanes* out) {
#if defined(__clang__) || __GNUC__ >= 12
  *out = __builtin_shufflevector(a, b, I...);
#else
  typedef long long Indices __attribute__((vector_size(32)));
  *out = __builtin_shuffle(a, b, Indices{I...});
#endif
}

/// Prefetches numbers one page ahead of these: hardware prefetching ends at a page.
template <int Size>
CH5_INLINE void PrefetchPageAhead(const double* x) {
  constexpr int kLine = 8, kPage = 512;
  CH5_UNROLL
  for (int i = 0; i < Size; i += kLine) __builtin_prefetch(x + kPage + i);
}

/// `size` rounded up to whole Lanes.
constexpr int Padded(int size) { return (size + kLanes - 1) / kLanes * kLanes; }

}  // namespace ch5
