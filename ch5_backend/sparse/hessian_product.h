#pragma once
/// H as a whole: products with it, its diagonal, and all of it for small problems.

#include "ch5_backend/sparse/steps/linearize.h"

namespace ch5 {

/// H v; v and the result have all rows, poses first.
VecX MultiplyHessian(const Structure& structure, const Linearized& system, const VecX& v, ThreadPool* pool);

/// diag(H), as many numbers as H has rows.
VecX HessianDiagonal(const Structure& structure, const Linearized& system);

/// H with all its zeros.
MatXX DenseHessian(const Structure& structure, const Linearized& system);

}  // namespace ch5
