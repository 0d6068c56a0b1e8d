#pragma once
/// Which copy of a kernel runs: one for each kind of processor, and one for each pair of block sizes worth code of its
/// own. All choices of the project are made here.
///
/// A kernel is a struct with its signature and one body:
///
///   template <int P, int L>     // sizes of a block; Eigen::Dynamic: read at run time; UpTo(n): likewise, but at most n
///   struct Scale {
///     using Signature = void(const double* block, double* out);
///     template <SimdLevel kSimd>
///     static CH5_INLINE void Run(const double* block, double* out) { … }
///   };
///   Dispatch<Scale>(sizes)(block, out);
///
/// The body is compiled for any processor, for those with AVX2 and for those with AVX-512 (simd.h). The copies differ by
/// rounding (FMA), so results are the same to the bit on one machine, not between machines.

#include "ch5_backend/math/eigen_types.h"
#include "ch5_backend/math/simd.h"

namespace ch5 {

/// Stands for sizes from n − 3 to n, which take as many registers; n is a multiple of kLanes.
constexpr int UpTo(int n) { return -n; }
#ifdef __EMSCRIPTEN__  // a page has nobody's own cameras, and should be small
constexpr bool kByRegisters = false;
#else
constexpr bool kByRegisters = true;
#endif

/// Which sizes a kernel is wanted for: P×L.
struct BlockSizes {
  int rows = Eigen::Dynamic, columns = Eigen::Dynamic;

  /// Whether there is code for just these.
  constexpr bool AreExact() const {
    return (rows == 6 && (columns == 1 || columns == 3)) || (rows == 9 && columns == 3);
  }
  /// Whether there is code for as many registers: points and poses, or cameras, of anyone's own.
  constexpr bool FitRegisters() const {
    return kByRegisters && !AreExact() && columns == 3 && rows > kLanes && rows <= 4 * kLanes;
  }
  constexpr bool AreFixed() const { return AreExact() || FitRegisters(); }
  /// Sizes with the same code for a kernel to which those of the poses do not matter.
  constexpr BlockSizes OfLandmarks() const { return FitRegisters() ? BlockSizes{9, 3} : *this; }
};

template <typename Kernel, typename Signature>
struct KernelCopies;

template <typename Kernel, typename Result, typename... Arguments>
struct KernelCopies<Kernel, Result(Arguments...)> {
  using Function = Result (*)(Arguments...);

  static Result Portable(Arguments... arguments) { return Kernel::template Run<SimdLevel::kPortable>(arguments...); }
  CH5_WITH_AVX2 static Result Avx2(Arguments... arguments) {
    return Kernel::template Run<SimdLevel::kAvx2>(arguments...);
  }
  CH5_WITH_AVX512 static Result Avx512(Arguments... arguments) {
    return Kernel::template Run<SimdLevel::kAvx512>(arguments...);
  }
  static Function ForThisProcessor() { return HasAvx512() ? Avx512 : HasAvx2() ? Avx2 : Portable; }
};

/// The copy for this processor of a kernel without sizes.
template <typename Kernel>
auto Dispatch() {
  return KernelCopies<Kernel, typename Kernel::Signature>::ForThisProcessor();
}

/// The copy for these sizes and this processor; any sizes are served, other than the exact ones by Eigen::Dynamic.
template <template <int P, int L> class Kernel>
auto Dispatch(const BlockSizes& sizes) {
  if (sizes.rows == 6 && sizes.columns == 1) return Dispatch<Kernel<6, 1>>();
  if (sizes.rows == 6 && sizes.columns == 3) return Dispatch<Kernel<6, 3>>();
  if (sizes.rows == 9 && sizes.columns == 3) return Dispatch<Kernel<9, 3>>();
  return Dispatch<Kernel<Eigen::Dynamic, Eigen::Dynamic>>();
}

/// The same for a kernel that also has code by the number of registers.
template <template <int P, int L> class Kernel>
auto DispatchByRegisters(const BlockSizes& sizes) {
  if constexpr (kByRegisters) {
    if (sizes.FitRegisters() && sizes.rows <= 8) return Dispatch<Kernel<UpTo(8), 3>>();
    if (sizes.FitRegisters() && sizes.rows <= 12) return Dispatch<Kernel<UpTo(12), 3>>();
    if (sizes.FitRegisters()) return Dispatch<Kernel<UpTo(16), 3>>();
  }
  return Dispatch<Kernel>(sizes);
}

namespace kernels {

/// A size that is a constant where it is known at compile time.
template <int N>
CH5_INLINE constexpr int Pick(int size) {
  return N < 0 ? size : N;
}
/// The largest size that N stands for, unless it is Eigen::Dynamic.
template <int N>
constexpr int kMost = N < Eigen::Dynamic ? -N : N;

}  // namespace kernels

}  // namespace ch5
