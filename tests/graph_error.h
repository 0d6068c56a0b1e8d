#pragma once
/// For tests of what is refused.

#include <gtest/gtest.h>

#include <string>

#include "ch5_backend/graph/graph.h"

namespace ch5::test {

/// Fails unless `action` throws an Error whose text holds `words`.
template <typename Error, typename Action>
void ExpectError(const Action& action, const std::string& words) {
  try {
    action();
    FAIL() << "no error; expected: " << words;
  } catch (const Error& error) {
    EXPECT_NE(std::string(error.what()).find(words), std::string::npos) << error.what();
  }
}

template <typename Action>
void ExpectGraphError(const Action& action, const std::string& words) {
  ExpectError<GraphError>(action, words);
}

}  // namespace ch5::test
