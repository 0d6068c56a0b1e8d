#pragma once
/// Where the stage tests' random numbers come from: fixed ones, so that a student sees the same failure again; others of
/// the same kind with --seed=S, so that they cannot be known in advance.

#include <cstdint>
#include <optional>
#include <string>

namespace ch5::homework {

/// S, which the judge sends to its workers with each scene.
std::optional<uint64_t>& DrawnSeed();

/// The seed of a test's Random: `n` itself, or `n` mixed with S.
uint64_t Seed(uint64_t n);

/// A size of a scene: `usual`, or with a seed one from `usual` to `most`.  @param n  as Seed's
int Vary(int usual, int most, uint64_t n);

/// Whether this is the option "--seed=S", S a number from 0 to 2⁶⁴ − 1; then it is taken.
bool TakeSeed(const std::string& option);

}  // namespace ch5::homework
