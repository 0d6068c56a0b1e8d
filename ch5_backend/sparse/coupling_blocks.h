#pragma once
/// The blocks of H_pm, in double or in single precision; where each begins is said in block_structure.h.

#include <type_traits>

#include "ch5_backend/linear/block_matrix.h"

namespace ch5 {

struct CouplingBlocks {
  AlignedVector doubles;
  std::vector<float, Eigen::aligned_allocator<float>> floats;
  bool single_precision = false;

  /// Takes zeroed memory for `size` numbers.
  void Take(int size);
  /// A rows×columns block.
  MatXX Block(int begin, int rows, int columns) const;
};
template <typename Scalar>
CH5_INLINE Scalar* BlocksOf(CouplingBlocks* H_pm) {
  if constexpr (std::is_same_v<Scalar, float>) return H_pm->floats.data();
  if constexpr (std::is_same_v<Scalar, double>) return H_pm->doubles.data();
}
template <typename Scalar>
CH5_INLINE const Scalar* BlocksOf(const CouplingBlocks& H_pm) {
  if constexpr (std::is_same_v<Scalar, float>) return H_pm.floats.data();
  if constexpr (std::is_same_v<Scalar, double>) return H_pm.doubles.data();
}

}  // namespace ch5
