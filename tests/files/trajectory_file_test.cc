#include "ch5_backend/files/tables/trajectory_file.h"

#include <gtest/gtest.h>

namespace ch5 {
namespace {

// 90° about z at 1.5 s: by hand.
TEST(TrajectoryFile, TumAndEurocRowsAreInTheirToolsOrder) {
  const StampedState state{1.5, {Qd(0.5, 0.5, -0.5, 0.5), {1, 2, 3}}, {4, 5, 6}, {7, 8, 9}, {10, 11, 12}};
  EXPECT_EQ(FormatTum({state}, 1403715273262143232), "1403715274.762143232 1 2 3 0.5 -0.5 0.5 0.5\n");
  EXPECT_EQ(FormatTum({state}, 0), "1.500000000 1 2 3 0.5 -0.5 0.5 0.5\n");
  EXPECT_EQ(FormatTum({state}, -1500000001), "-0.000000001 1 2 3 0.5 -0.5 0.5 0.5\n");
  const std::string euroc = FormatEuroc({state}, 1403715273262143232);
  EXPECT_EQ(euroc.substr(euroc.find('\n') + 1), "1403715274762143232,1,2,3,0.5,0.5,-0.5,0.5,4,5,6,10,11,12,7,8,9\n");
}

}  // namespace
}  // namespace ch5
