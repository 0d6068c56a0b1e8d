#pragma once
/// Failures that teach: what was expected, what came, whose entry it is, and which typical mistake gives just this.

#include <functional>
#include <string>
#include <vector>

#include "ch5_backend/graph/ordering.h"
#include "ch5_backend/math/eigen_types.h"

namespace ch5::homework {

/// A mistake that many make. The cause is told only if the mistake's own wrong answer is what the student has.
struct Mistake {
  std::string todo;   ///< "1.1b"
  std::string cause;  ///< "the mirrored block is missing"
  std::function<MatXX()> answer;
};

/// What each row or column stands for: "VertexPose 1, δp.y".
using Names = std::vector<std::string>;

/// One comparison of a student's matrix or vector with the right one.
struct Claim {
  std::string stage;  ///< "1.1"
  std::string what;   ///< "H of one edge between two poses"
  MatXX expected;
  MatXX got;
  Names names;                    ///< of the rows, and of the columns of a square matrix; may be empty
  std::vector<Mistake> mistakes;  ///< the likelier ones first
  double tolerance = 1e-10;       ///< of the largest expected entry
  Names columns = {};             ///< of a matrix whose columns have other names than its rows
  std::string todo = {};          ///< where to look if no typical mistake explains it
  std::string variable = {};      ///< what the student's code calls it: "H_prior"
};

/// Empty if the claim holds, otherwise the story of its failure, at most 15 lines.
std::string Story(const Claim& claim);

/// A story that a rule tells, without matrices; `todo` may be empty.
std::string Story(const std::string& stage, const std::string& what, const std::string& expected,
                  const std::string& got, const std::string& cause, const std::string& todo);

/// The names of the rows of H: by type and graph id, "VertexPose 4, δp.x"; or numbered as stage 7 does, "pose 0, δp.x".
Names RowNames(const Ordering& ordering, bool numbered = false);

/// Whether it holds numbers from memory that was never written to, or that is no more (poison.h).
bool HoldsUnset(const MatXX& A);

/// As few digits as tell it from others: "100", "0.25".
std::string Number(double x);

/// Whether the matrices have one size and differ by at most `tolerance` of the largest entry of `expected`.
bool Equal(const MatXX& got, const MatXX& expected, double tolerance);

}  // namespace ch5::homework

/// Tells the story and leaves the test, if there is a story to tell.
#define ASSERT_NO_STORY(...)                                       \
  do {                                                             \
    const std::string story = ::ch5::homework::Story(__VA_ARGS__); \
    if (!story.empty()) FAIL() << story;                           \
  } while (false)
