#pragma once
/// A start for graphs whose loops are closed by landmarks, which no tree and no relaxation of transforms sees: pose after pose
/// in the order of the graph, with all that is placed solved again whenever it has grown by a little.
///
///   pose j        T_W_j = T_W_i T_i_j   from the nearest pose before it that an edge leads from
///   landmark l    where the first pose sees it
///   solve         over what is placed, after each 2 % of new poses
///
/// So a loop is closed while the drift is that of one round, and not of all. Kaess, Ranganathan, Dellaert, "iSAM:
/// Incremental smoothing and mapping", T-RO 2008, which solves after each pose.

#include <functional>

#include "ch5_backend/sparse/incremental_smoother.h"

namespace ch5 {

/// Moves the free poses that a measured transform leads to, and the free landmarks that poses see. Something must hold the gauge.
void PlaceIncrementally(Graph* graph, int threads = 1);

/// The same walk as a robot would have solved it: an Update of an IncrementalSmoother after every so many poses, and two when
/// all are placed.
/// @param every  at least 1;  @param watch  gets what each Update has done
/// @throws SingularGraphError as IncrementalSmoother::Update, where LM's damping in the function above helps
void SolveIncrementally(Graph* graph, int every, const std::function<void(const UpdateSummary&)>& watch = {},
                        const IncrementalOptions& options = {});

}  // namespace ch5
