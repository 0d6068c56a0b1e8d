#pragma once
/// For tests of what is refused.

#include <gtest/gtest.h>

#include <string>

#include "ch5_backend/graph/graph.h"
#include "tests/temporary_folder.h"

namespace ch5::test {

/// Fails unless `action` throws an Error whose text holds `words`.
template <typename Error, typename Action>
void ExpectError(const Action& action, const std::string& words) {
  const std::string what = Refusal<Error>(action);
  EXPECT_NE(what.find(words), std::string::npos) << (what.empty() ? "no error" : what);
}

template <typename Action>
void ExpectGraphError(const Action& action, const std::string& words) {
  ExpectError<GraphError>(action, words);
}

}  // namespace ch5::test
