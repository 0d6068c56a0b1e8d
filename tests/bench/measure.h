#pragma once
/// One problem of `./course bench`, solved by one side in a process of its own, so that its peak of memory is honest.

#include <functional>
#include <string>

#include "ch5_backend/experiments/studies/window_graph.h"
#include "ch5_backend/files/bal.h"
#include "ch5_backend/files/window_dump.h"
#include "tests/bench/ceres_peer.h"

namespace ch5::bench {

/// One of the three is filled. The course's scenes are windows without an IMU.
struct Problem {
  enum class Kind { kBal, kWindow, kPoseGraph } kind = Kind::kBal;
  /// Of a window, the prior that its oldest frame leaves; of a window or a pose graph, Σ of each free pose.
  enum class Task { kSolve, kMarginalize, kCovariance } task = Task::kSolve;
  BalProblem bal;
  WindowDump window;
  std::string pose_graph;     ///< its file, which both sides read anew
  peer::PeerOptions options;  ///< with which both sides solve it
  bool plain_ldlt = false;    ///< the peer that marginalizes, instead of VINS-Mono's way
};

/// @param name  a BAL file, a window dump, a .g2o file, "scene:FRAMESxPOINTS", "city:CAMERAS[:SEED]" or "first:CAMERAS:BALFILE", the
///              part that these cameras see, behind a task's word if that is not to solve it: "marginalize:" or "covariance:"
/// @throws FileError
/// @throws std::invalid_argument
Problem ReadProblem(const std::string& name);

/// Changes what both sides are told: words between commas, such as "lm,ray,radius=3e5". measure.cc's usage lists them.
/// @throws std::invalid_argument for another word
void TakeWay(const std::string& words, peer::PeerOptions* options);

/// The side that this program was linked with: its setup is made before the clock starts, as an estimator has it.
peer::PeerResult Solve(const Problem& problem);

/// A task that is no solve, timed.
/// @param wall  see Stopwatch;  @param work  returns what both sides must agree on, in place of a final cost: the trace of the prior's JᵀJ, or of all Σ
peer::PeerResult Timed(bool wall, const std::function<double()>& work);

}  // namespace ch5::bench
