#include <gtest/gtest.h>

#include <cmath>

#include "ch5_backend/experiments/studies/endurance_study.h"

namespace ch5 {
namespace {

// The program's memory is measured, so nothing else may run in it. An estimator that kept a hundred bytes of every
// image's thirty tracks would grow by 27 MB over nine thousand images.
void ExpectToEndure(int frames, int early, double most_megabytes, uint64_t seed) {
  EnduranceOptions options;
  options.frames = frames;
  options.seed = seed;
  const auto rows = RunEnduranceStudy(options);
  for (const char* policy : {"vins", "okvis"}) {
    const EnduranceRow* then = nullptr;
    const EnduranceRow* last = nullptr;
    double largest = 0.0;
    for (const EnduranceRow& row : rows) {
      if (row.policy != policy) continue;
      if (row.frame == early) then = &row;
      last = &row;
      largest = std::max(largest, row.error);
      EXPECT_EQ(std::isnan(row.error), row.t < 60.0)
          << policy << ": no error before it is aligned, at " << row.t << " s";
    }
    ASSERT_TRUE(then && last) << policy;
    EXPECT_GE(last->frame, frames - options.sample_every) << policy;
    EXPECT_EQ(last->restarts, 0) << policy;
    EXPECT_LT(last->resident_mb - then->resident_mb, most_megabytes) << policy;
    EXPECT_GT(last->distance, 50.0);
    EXPECT_LT(largest, 0.02 * last->distance) << policy << ": it drifts by more than 2 % of the way";
  }
}

// In this room VINS's window, whose gauge is free, started anew after 127 s while its prior took rounding for knowledge.
TEST(Endurance, FifteenHundredImages) { ExpectToEndure(1500, 500, 4.0, 4); }
TEST(LongEndurance, TenThousandImages) { ExpectToEndure(10000, 1000, 4.0, 1); }

}  // namespace
}  // namespace ch5
