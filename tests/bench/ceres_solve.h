#pragma once
/// What the peers have in common: options in, trace out.

#include <ceres/ceres.h>

#include "tests/bench/ceres_peer.h"

namespace ch5::peer {

/// Runs Ceres with its best settings for `options`.
PeerResult SolveWithCeres(const PeerOptions& options, std::shared_ptr<ceres::ParameterBlockOrdering> ordering,
                          ceres::Problem* problem);

}  // namespace ch5::peer
