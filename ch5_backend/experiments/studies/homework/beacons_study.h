#pragma once
/// Stage 8 at work: a body flies a circle, an IMU guesses its path, points and three beacons correct it.

#include <filesystem>

namespace ch5 {

/// convergence.csv: cost and λ of each trial;  path.csv: the keyframes' positions, true, guessed and estimated.
void RunBeacons(const std::filesystem::path& csv);

}  // namespace ch5
