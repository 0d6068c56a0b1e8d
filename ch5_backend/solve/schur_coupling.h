#pragma once
/// What the eliminated landmarks do to the poses,  W = E C⁻¹ Eᵀ,  as an operator: S = B − W is applied, never formed.
///
///   B  H_pp + λD        E  H_pm, a block for each slot (landmark, pose that sees it)        C  H_mm + λD
///
///   for each landmark l:   w = C_l⁻¹ Σ_p E_plᵀ x_p,   y_p += E_pl w   while its blocks E_pl are still in the cache
///
/// A product costs two small products a slot, where S costs one block for each pair of poses of each landmark. The
/// blocks are copied once per Hessian into an order and a precision that suit this loop, which is bound by memory.
/// Landmarks are cut into pieces by their number alone; each piece has sums of its own, added in order: the result is
/// the same to the bit for any number of threads.

#include <memory>

#include "ch5_backend/math/parallel.h"
#include "ch5_backend/solve/block_passes.h"

namespace ch5 {

class SchurCoupling {
 public:
  virtual ~SchurCoupling() = default;
  /// Takes the memory for a new structure.
  virtual void Prepare(const BlockSystem& system) = 0;
  /// Takes over the blocks E of a new Hessian.
  virtual void Load(const BlockSystem& system, ThreadPool* pool) = 0;
  /// y = W x, with the present C⁻¹ of the system.
  virtual void Multiply(const BlockSystem& system, const double* x, double* y, ThreadPool* pool) = 0;
};

/// @param pose_dim, landmark_dim  9/3, 6/3 and 6/1 have code of their own; any others, also mixed, share one
/// @param single_precision  E and the products in float: half the memory and twice the speed for a relative error of
///                          about 1e-6 in W x; where the sizes have no code of their own it is ignored
std::unique_ptr<SchurCoupling> MakeSchurCoupling(int pose_dim, int landmark_dim, bool single_precision);

}  // namespace ch5
