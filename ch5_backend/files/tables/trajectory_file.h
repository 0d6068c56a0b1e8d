#pragma once
/// Trajectories as the usual evaluation tools read them (evo, the TUM RGB-D tools, rpg_trajectory_evaluation).

#include <string>

#include "ch5_backend/types/recording.h"

namespace ch5 {

/// TUM: `t x y z qx qy qz qw` a line, t in seconds with all nine decimals, T_W_B.
/// @param origin_ns  the recorder's clock at t = 0, so that stamps are the recording's own
std::string FormatTum(const std::vector<StampedState>& states, int64_t origin_ns);

/// EuRoC's state_groundtruth: `stamp [ns], p, q (w x y z), v, b_g, b_a`, 17 columns under a header.
std::string FormatEuroc(const std::vector<StampedState>& states, int64_t origin_ns);

}  // namespace ch5
