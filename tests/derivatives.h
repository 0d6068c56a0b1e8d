#pragma once
/// The one oracle of all Jacobians: central differences through the vertices' own ⊞.

#include <gtest/gtest.h>

#include <string>

#include "ch5_backend/graph/check_jacobians.h"

namespace ch5 {

inline void ExpectJacobiansAreDerivatives(Edge* edge, const std::string& where = "a state") {
  const JacobianCheck check = CheckJacobians(edge);
  EXPECT_TRUE(check) << "at " << where << ", " << check.message;
}

}  // namespace ch5
