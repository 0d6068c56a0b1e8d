#pragma once

#include "ch5_backend/experiments/studies/odometry_study.h"

namespace ch5 {

/// With blanks between them.
inline std::string Names(const RecordingWarnings& warnings) {
  std::string names;
  for (const RecordingWarning& warning : warnings) names += (names.empty() ? "" : " ") + warning.name;
  return names;
}

}  // namespace ch5
