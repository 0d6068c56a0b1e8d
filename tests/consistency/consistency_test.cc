#include <gtest/gtest.h>

#include "ch5_backend/apps/studies/consistency_study.h"

namespace ch5 {
namespace {

// Tables of the χ² distribution: dof 10 and 100, at 2.5 % and 97.5 %; the approximation is good to 1 % at 10.
TEST(Consistency, BandIsThatOfTheTables) {
  EXPECT_NEAR(ChiSquaredBand(1, 10).low, 0.3247, 5e-3);
  EXPECT_NEAR(ChiSquaredBand(1, 10).high, 2.0483, 5e-3);
  EXPECT_NEAR(10.0 * ChiSquaredBand(10, 10).low, 74.222, 1e-2);
  EXPECT_NEAR(10.0 * ChiSquaredBand(10, 10).high, 129.561, 1e-2);
}

class ConsistencyOfPolicies : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    ConsistencyOptions options;
    options.runs = 16;
    options.seconds = 10.0;
    rows_ = RunConsistencyStudy(options);
  }
  static double Mean(const std::string& policy, double ConsistencyRow::*value) {
    double sum = 0.0;
    int count = 0;
    for (const ConsistencyRow& row : rows_) {
      if (row.policy != policy) continue;
      sum += row.*value;
      ++count;
    }
    return sum / count;
  }
  static std::vector<ConsistencyRow> rows_;
};
std::vector<ConsistencyRow> ConsistencyOfPolicies::rows_;

// The mean over all times has few independent samples: a tenth of them, say, which leaves ± 20 % around 6.
TEST_F(ConsistencyOfPolicies, FullFirstEstimatesAreNotOverconfident) {
  EXPECT_LT(Mean("full", &ConsistencyRow::nees_pose), 7.2);
  EXPECT_GT(Mean("full", &ConsistencyRow::nees_pose), 4.0);
  EXPECT_LT(Mean("full", &ConsistencyRow::position_rmse), 0.3);
}

// VN10: what is used twice counts twice.
TEST_F(ConsistencyOfPolicies, ObservationsUsedTwiceAreOverconfident) {
  EXPECT_GT(Mean("vins", &ConsistencyRow::nees_pose), Mean("full", &ConsistencyRow::nees_pose) + 0.5);
  EXPECT_GT(Mean("vins", &ConsistencyRow::yaw_information), Mean("full", &ConsistencyRow::yaw_information));
}

// Nothing measures yaw: what is claimed of it never exceeds what the start was given (its speed tells a little).
TEST_F(ConsistencyOfPolicies, FullFirstEstimatesGainNoYaw) {
  double first = 0.0;
  for (const ConsistencyRow& row : rows_) {
    if (row.policy != "full") continue;
    if (first == 0.0) first = row.yaw_information;
    EXPECT_LT(row.yaw_information, 1.01 * first) << "t = " << row.t;
  }
}

TEST(Consistency, DoesNotDependOnTheNumberOfThreads) {
  ConsistencyOptions options;
  options.runs = 3;
  options.seconds = 3.0;
  options.threads = 1;
  const auto one = RunConsistencyStudy(options);
  options.threads = 2;
  const auto two = RunConsistencyStudy(options);
  ASSERT_EQ(one.size(), two.size());
  for (size_t k = 0; k < one.size(); ++k) {
    EXPECT_EQ(one[k].nees_pose, two[k].nees_pose);
    EXPECT_EQ(one[k].yaw_information, two[k].yaw_information);
  }
}

}  // namespace
}  // namespace ch5
