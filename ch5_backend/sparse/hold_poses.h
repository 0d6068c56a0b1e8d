#pragma once
/// Parts of vertices held where they are: taken out of the normal equations once these are assembled.  Nocedal & Wright (2006), §15.3

#include "ch5_backend/sparse/steps/linearize.h"

namespace ch5 {

/// Π = I − C⁺C of a vertex, which takes the held directions out of δ.
struct HeldPose {
  int pose;
  MatXX projection;
};

/// Π at the present states of each held vertex; one that is fixed, or without part in the structure, is held already.
/// @throws std::invalid_argument if C has another number of columns, or a landmark is to be held
std::vector<HeldPose> FindHeldPoses(const Structure& structure, const std::vector<HeldDirections>& held);

/// H ← Π H Π + (I − Π) h,  b ← Π b: what remains is a system without the held directions; h > 0 keeps it regular.
void HoldPoses(const Structure& structure, const std::vector<HeldPose>& held, Linearized* system);

}  // namespace ch5
