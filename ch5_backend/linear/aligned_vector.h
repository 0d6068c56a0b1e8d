#pragma once
/// Numbers for the kernels, which load whole registers.

#include <Eigen/Core>
#include <algorithm>
#include <limits>
#include <utility>
#include <vector>

namespace ch5 {

/// Leaves a vector's new numbers unset where no value is given: memory is then first touched by the thread that fills it.
template <typename T>
struct UnsetAllocator : Eigen::aligned_allocator<T> {
  template <typename U>
  struct rebind {
    using other = UnsetAllocator<U>;
  };
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

/// Numbers that begin at a multiple of 32 bytes; `resize` leaves new ones unset.
using AlignedVector = std::vector<double, UnsetAllocator<double>>;

/// As `assign(count, 0.0)`, which asks the allocator for each number, and cannot set a register's width of them at once.
inline void SetZeros(size_t count, AlignedVector* numbers) {
  numbers->clear();
  numbers->resize(count);
  std::fill(numbers->begin(), numbers->end(), 0.0);
}

}  // namespace ch5
