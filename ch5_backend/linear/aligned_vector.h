#pragma once
/// Numbers for the kernels, which load whole registers.

#include <algorithm>
#include <limits>
#include <utility>
#include <vector>

#include "ch5_backend/math/array_memory.h"
#include "ch5_backend/math/eigen_types.h"

namespace ch5 {

/// Leaves a vector's new numbers unset where no value is given: memory is then first touched by the thread that fills it.
template <typename T>
struct UnsetAllocator : ArrayAllocator<T> {
  UnsetAllocator() = default;
  template <typename U>
  UnsetAllocator(const UnsetAllocator<U>&) {}  // NOLINT(google-explicit-constructor): as allocators are asked to
  template <typename U>
  void construct(U* number) {
#ifdef EIGEN_INITIALIZE_MATRICES_BY_NAN
    *number = std::numeric_limits<U>::quiet_NaN();
#else
    static_cast<void>(number);
#endif
  }
  template <typename U, typename... Args>
  void construct(U* number, Args&&... args) {
    ::new (static_cast<void*>(number)) U(std::forward<Args>(args)...);
  }
};

/// Numbers that begin at a multiple of 64 bytes; `resize` leaves new ones unset.
using AlignedVector = std::vector<double, UnsetAllocator<double>>;

/// A MatXX or a VecX that comes and goes with a window, in such memory; its numbers are unset.
struct HasAlignedVector {
  AlignedVector numbers;
};
template <typename Matrix>
class InArray : private HasAlignedVector, public Eigen::Map<Matrix> {
 public:
  explicit InArray(Eigen::Index rows, Eigen::Index columns = 1)
      : HasAlignedVector{AlignedVector(static_cast<size_t>(rows * columns))},
        Eigen::Map<Matrix>(numbers.data(), rows, columns) {}
  InArray(InArray&&) noexcept = default;
  using Eigen::Map<Matrix>::operator=;
};
using ArrayMatrix = InArray<MatXX>;
using ArrayVector = InArray<VecX>;

/// As `assign(count, 0.0)`, which asks the allocator for each number, and cannot set a register's width of them at once.
inline void SetZeros(size_t count, AlignedVector* numbers) {
  numbers->clear();
  numbers->resize(count);
  std::fill(numbers->begin(), numbers->end(), 0.0);
}

}  // namespace ch5
