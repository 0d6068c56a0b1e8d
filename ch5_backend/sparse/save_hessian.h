#pragma once
/// H as a text file that Octave and MATLAB load, g2o's saveHessian.

#include <ostream>
#include <string>

#include "ch5_backend/sparse/sparse_solver.h"

namespace ch5 {

/// Writes the H of the last MakeHessian, poses first, landmarks last, both triangles, as Octave's sparse matrix:
///
///   # name: H
///   # type: sparse matrix
///   # nnz: 3            then rows and columns likewise
///   1 1 4.5             row, column (from 1), value; column by column
///
/// Zeros within the blocks are left out; numbers read back to the same bits. Check the stream for failures.
void SaveHessian(const SparseSolver& solver, const std::string& name, std::ostream* out);

}  // namespace ch5
