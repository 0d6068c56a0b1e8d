#pragma once
/// SuiteSparse's CHOLMOD as a reduced solver, for comparison with our own sparse Cholesky. Not part of the library:
/// the target ch5_cholmod exists where CHOLMOD is found, and nothing else needs it.
///
///   solver.SetReducedSolver(ch5::MakeCholmodSolver());

#include <memory>

#include "ch5_backend/linear/reduced_solver.h"

namespace ch5 {

/// Orders blocks, not numbers, by approximate minimum degree (a whole pose is eliminated at once, which is also many
/// times faster to analyze), and factors supernodes. Davis et al., "Algorithm 887: CHOLMOD", 2008.
std::unique_ptr<ReducedSolver> MakeCholmodSolver();

}  // namespace ch5
