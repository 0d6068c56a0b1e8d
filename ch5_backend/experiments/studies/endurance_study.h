#pragma once
/// Ten thousand images: does an estimator's memory stay constant, and its error in proportion to the path's length?

#include <cstdint>
#include <string>
#include <vector>

#include "ch5_backend/experiments/studies/odometry.h"
#include "ch5_backend/files/tables/csv.h"

namespace ch5 {

struct EnduranceOptions {
  int frames = 10000;     ///< images, 10 a second
  int sample_every = 50;  ///< images per row
  uint64_t seed = 1;      ///< of the room's landmarks
};

/// One policy after `frame` images.
struct EnduranceRow {
  std::string policy;
  int frame = 0;
  double t = 0.0;
  double distance = 0.0;  ///< length of the path so far [m]
  double error =
      0.0;  ///< of the position, aligned with the truth over the first minute; NaN before, and without an estimate [m]
  double resident_mb = 0.0;   ///< memory of the process; NaN where unknown
  double milliseconds = 0.0;  ///< per image, mean since the previous row
  /// On the processor, of the images so far whose window is full, the tenth after a start and later, to 1 %; NaN of none
  /// [ms].
  double p50 = 0.0, p99 = 0.0, p999 = 0.0;
  double max = 0.0;  ///< of all images so far, those of a start included [ms]
  int restarts = 0;
};

/// Both policies, one after the other, on a hand-held camera in a room. The recording is made before the first row.
/// @throws std::runtime_error if an estimate is not finite, naming policy and time
std::vector<EnduranceRow> RunEnduranceStudy(const EnduranceOptions& options, const StudyProgress& progress = nullptr);

CsvTable EnduranceTable(const std::vector<EnduranceRow>& rows);

}  // namespace ch5
