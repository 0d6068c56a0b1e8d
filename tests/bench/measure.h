#pragma once
/// One problem of `./course bench`, solved by one side in a process of its own, so that its peak of memory is honest.

#include <string>

#include "ch5_backend/files/bal.h"
#include "ch5_backend/files/window_dump.h"
#include "tests/bench/ceres_peer.h"

namespace ch5::bench {

/// One of the three is filled. The course's scenes are windows without an IMU.
struct Problem {
  enum class Kind { kBal, kWindow, kPoseGraph } kind = Kind::kBal;
  BalProblem bal;
  WindowDump window;
  std::string pose_graph;     ///< its file, which both sides read anew
  peer::PeerOptions options;  ///< with which both sides solve it
};

/// @param name  a BAL file, a window dump, a .g2o file, or "scene:FRAMESxPOINTS"
/// @throws FileError, std::invalid_argument
Problem ReadProblem(const std::string& name);

/// The side that this program was linked with: its setup is made before the clock starts, as an estimator has it.
peer::PeerResult Solve(const Problem& problem);

}  // namespace ch5::bench
