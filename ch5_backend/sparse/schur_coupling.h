#pragma once
/// What the eliminated landmarks do to the poses,  W = E C⁻¹ Eᵀ,  as an operator: S = B − W is applied, never formed.
///
///   B  H_pp + λD        E  H_pm, a block for each slot (landmark, pose that sees it)        C  H_mm + λD
///
///   for each landmark l:   w = C_l⁻¹ Σ_p E_plᵀ x_p,   y_p += E_pl w   while its blocks E_pl are still in the cache
///
/// A product costs two small products a slot, where S costs one block for each pair of poses of each landmark. It is
/// bound by memory, which E fills: a copy in float made a solve of 969 cameras 1.4 times as fast, and took half as much
/// memory again as E itself.
/// Landmarks are cut into pieces by their number alone; each piece has sums of its own, added in order: the result is
/// the same to the bit for any number of threads.

#include "ch5_backend/math/parallel.h"
#include "ch5_backend/sparse/block_passes.h"

namespace ch5 {

class SchurCoupling {
 public:
  /// @param pose_dim, landmark_dim  9/3, 6/3 and 6/1 have code of their own; any others, also mixed, share one
  SchurCoupling(int pose_dim, int landmark_dim);
  /// Takes the memory for a new structure.
  void Prepare(const BlockSystem& system);
  /// y = W x, with the present E and C⁻¹ of the system.
  void Multiply(const BlockSystem& system, const double* x, double* y, ThreadPool* pool);

  /// The landmarks [begin, end): sums += E C⁻¹ Eᵀ x.
  struct Task {
    const BlockSystem* system;
    const int* padded_offset;  ///< of a pose in sums
    int begin, end;
    const double* x;
    double* sums;
  };
  using Run = void (*)(const Task&);

 private:
  void CutPieces(const BlockStructure& structure);

  Run run_;
  std::vector<int> piece_begin_, padded_offset_;
  AlignedVector sums_;  // of each piece
};

}  // namespace ch5
