#pragma once
/// For tests of what a graph refuses.

#include <gtest/gtest.h>

#include <string>

#include "ch5_backend/graph/graph.h"

namespace ch5::test {

/// Fails unless `action` throws a GraphError whose text holds `words`.
template <typename Action>
void ExpectGraphError(const Action& action, const std::string& words) {
  try {
    action();
    FAIL() << "no error; expected: " << words;
  } catch (const GraphError& error) {
    EXPECT_NE(std::string(error.what()).find(words), std::string::npos) << error.what();
  }
}

}  // namespace ch5::test
