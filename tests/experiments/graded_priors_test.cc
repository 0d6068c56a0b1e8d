/// The estimators' marginalization against the classes of the homework: the same flight.
#include <gtest/gtest.h>

#include "ch5_backend/experiments/studies/homework/graded_priors.h"
#include "ch5_backend/experiments/studies/odometry_study.h"

namespace ch5 {
namespace {

Recording FirstSeconds(double seconds) {
  Recording recording = SimulatedOdometryRecording();
  const double end = recording.images.front().t + seconds;
  auto& frames = recording.images;
  frames.erase(std::remove_if(frames.begin(), frames.end(), [&](const Image& image) { return image.t > end; }),
               frames.end());
  return recording;
}

OdometryRun Fly(const Recording& recording, size_t policy, Marginalizer marginalizer) {
  EstimatorOptions options{recording.calibration};
  options.marginalizer = std::move(marginalizer);
  return RunOdometry(recording, options, std::move(AllPolicies()[policy]));
}

// Both priors have the same H and b up to rounding and to what each takes for zero; a window's solve, which ends at a
// thousandth of its cost, may then stop an iteration earlier.
void ExpectSameFlight(const OdometryRun& own, const OdometryRun& graded) {
  ASSERT_GT(own.states.size(), 80u);
  ASSERT_EQ(own.states.size(), graded.states.size());
  for (size_t i = 0; i < own.states.size(); ++i) {
    EXPECT_LT((own.states[i].T_W_B.p - graded.states[i].T_W_B.p).norm(), 1e-4) << "image " << i;
  }
}

TEST(GradedPriors, VinsFliesTheSameByMarginalizationInfo) {
  const Recording recording = FirstSeconds(10.0);
  ExpectSameFlight(Fly(recording, 0, nullptr), Fly(recording, 0, PriorByMarginalizationInfo));
}

TEST(GradedPriors, OkvisFliesTheSameByMarginalizationError) {
  const Recording recording = FirstSeconds(10.0);
  ExpectSameFlight(Fly(recording, 1, nullptr), Fly(recording, 1, PriorByMarginalizationError));
}

}  // namespace
}  // namespace ch5
