#include "ch5_backend/files/window_dump.h"

#include <gtest/gtest.h>

#include "ch5_backend/files/tables/text_writer.h"
#include "tests/data_folder.h"
#include "tests/files/made_up_window.h"
#include "tests/temporary_folder.h"

namespace ch5 {
namespace {

namespace fs = std::filesystem;

// Two frames, an IMU interval, a landmark, a prior on a speed: small enough to be checked by eye.
constexpr char kGood[] = R"(VIOWIN 1
G 0 0 9.81
NOISE 0.08 0.004 4e-05 2e-06
SQRTINFO 306
LOSS huber 1.5
EXT 0.1 0.2 0.3 0.5 -0.5 0.5 -0.5 1
FRAMES 2
F 0 1.5 1 2 3 0 0 0 1 4 5 6 7 8 9 10 11 12
T 0 1 2 3 0 0 0 1 4 5 6 7 8 9 10 11 12
F 1 1.6 1 2 4 0 0 1 0 4 5 6 7 8 9 10 11 12
T 1 1 2 5 0 0 0 1 4 5 6 7 8 9 10 11 12
IMUS 1
I 0 1 2 0.1 0.2 0.3 0.4 0.5 0.6
0 1 2 3 4 5 6
0.1 7 8 9 10 11 12
LANDMARKS 1
L 17 1 1 0.25 0.5 -0.1 -0.2
0 0.3 0.4
PRIOR 1 1
B S 1 9 1 2 3 4 5 6 7 8 9
R 0.5
J 1 2 3 4 5 6 7 8 9
FIXED 1 0
END
)";

class WindowDumpFile : public testing::Test {
 protected:
  WindowDump Read(const std::string& text) {
    WriteFileAtomically(path_, text);
    return ReadWindowDump(path_);
  }

  // The error after replacing `what` by `by` in the good file, without the file's name.
  std::string Spoilt(const std::string& what, const std::string& by) {
    std::string text = kGood;
    const size_t at = text.find(what);
    EXPECT_NE(at, std::string::npos) << what;
    return Message(text.replace(at, what.size(), by));
  }
  std::string Message(const std::string& text) {
    const std::string said = test::Refusal<FileError>([&] { Read(text); });
    return said.substr(std::min(said.size(), path_.string().size()));
  }

  test::TemporaryFolder folder_;
  fs::path path_ = folder_ / "window.txt";
};

TEST_F(WindowDumpFile, EveryNumberOfModelAndFramesGoesToItsPlace) {
  const WindowDump dump = Read(kGood);
  EXPECT_EQ(dump.reaction, Vec3(0, 0, 9.81));
  EXPECT_EQ(dump.noise.accelerometer, 0.08);
  EXPECT_EQ(dump.noise.gyroscope, 0.004);
  EXPECT_EQ(dump.noise.accelerometer_walk, 4e-5);
  EXPECT_EQ(dump.noise.gyroscope_walk, 2e-6);
  EXPECT_FALSE(dump.noise.continuous);
  EXPECT_EQ(dump.sqrt_information, 306.0);
  EXPECT_EQ(dump.loss, WindowDump::Loss::kHuber);
  EXPECT_EQ(dump.loss_parameter, 1.5);
  EXPECT_EQ(dump.T_B_C.p, Vec3(0.1, 0.2, 0.3));
  EXPECT_EQ(dump.T_B_C.q.coeffs(), Eigen::Vector4d(0.5, -0.5, 0.5, -0.5));
  EXPECT_TRUE(dump.extrinsic_fixed);

  ASSERT_EQ(dump.frames.size(), 2u);
  ASSERT_EQ(dump.truth.size(), 2u);
  EXPECT_EQ(dump.frames[1].t, 1.6);
  EXPECT_EQ(dump.truth[1].t, 1.6);
  EXPECT_EQ(dump.frames[1].T_W_B.p, Vec3(1, 2, 4));
  EXPECT_EQ(dump.truth[1].T_W_B.p, Vec3(1, 2, 5));
  EXPECT_EQ(dump.frames[1].T_W_B.q.coeffs(), Eigen::Vector4d(0, 0, 1, 0));
  EXPECT_EQ(dump.frames[1].v_W, Vec3(4, 5, 6));
  EXPECT_EQ(dump.frames[1].b_a, Vec3(7, 8, 9));
  EXPECT_EQ(dump.frames[1].b_g, Vec3(10, 11, 12));
}

TEST_F(WindowDumpFile, EveryNumberOfImuLandmarksAndPriorGoesToItsPlace) {
  const WindowDump dump = Read(kGood);
  ASSERT_EQ(dump.imu.size(), 1u);
  EXPECT_TRUE(dump.imu[0].i == 0 && dump.imu[0].j == 1);
  EXPECT_EQ(dump.imu[0].b_a, Vec3(0.1, 0.2, 0.3));
  EXPECT_EQ(dump.imu[0].b_g, Vec3(0.4, 0.5, 0.6));
  ASSERT_EQ(dump.imu[0].samples.size(), 2u);
  EXPECT_EQ(dump.imu[0].samples[1].dt, 0.1);
  EXPECT_EQ(dump.imu[0].samples[1].acceleration, Vec3(7, 8, 9));
  EXPECT_EQ(dump.imu[0].samples[1].gyroscope, Vec3(10, 11, 12));

  ASSERT_EQ(dump.landmarks.size(), 1u);
  const WindowDump::Landmark& landmark = dump.landmarks[0];
  EXPECT_TRUE(landmark.id == 17 && landmark.host == 1);
  EXPECT_TRUE(landmark.inverse_depth == 0.25 && landmark.true_inverse_depth == 0.5);
  EXPECT_EQ(landmark.x_host, Vec2(-0.1, -0.2));
  ASSERT_EQ(landmark.observations.size(), 1u);
  EXPECT_EQ(landmark.observations[0].frame, 0);
  EXPECT_EQ(landmark.observations[0].x, Vec2(0.3, 0.4));

  ASSERT_EQ(dump.prior_blocks.size(), 1u);
  EXPECT_EQ(dump.prior_blocks[0].kind, WindowDump::BlockKind::kSpeedBias);
  EXPECT_EQ(dump.prior_blocks[0].frame, 1);
  EXPECT_EQ(dump.prior_blocks[0].x0, VecX::LinSpaced(9, 1, 9));
  EXPECT_EQ(dump.prior_r, VecX::Constant(1, 0.5));
  EXPECT_EQ(dump.prior_J, MatXX(VecX::LinSpaced(9, 1, 9).transpose()));
  EXPECT_EQ(dump.fixed_frames, std::vector<int>{0});
}

TEST_F(WindowDumpFile, ErrorsNameTheLineTheRecordAndTheValue) {
  for (const auto& row : Cases("files/window_dump.cases")) {
    const std::string said = Spoilt(row.at(0), row.at(1));
    EXPECT_TRUE(IsSaid(row.at(2), said)) << row[1] << said;
  }
}

// Speeds and biases are states of windows with an IMU only.
TEST_F(WindowDumpFile, APriorOnSpeedsWithoutImuIsRefused) {
  std::string text = kGood;
  const size_t begin = text.find("IMUS 1"), end = text.find("LANDMARKS");
  EXPECT_EQ(Message(text.replace(begin, end - begin, "IMUS 0\n")),
            ":17: prior block 0, kind: speed and biases need an IMU, and this window has none, got \"S\"");
}

// A file cut at any place is refused, never read as a smaller one.
TEST_F(WindowDumpFile, FilesCutShortAreRefused) {
  const std::string good = kGood;
  for (size_t length = 0; length + 2 < good.size(); length += 7) {
    EXPECT_NE(Message(good.substr(0, length)), "") << "the first " << length << " bytes";
  }
}

struct Expected {
  const char* name;
  size_t frames, imu, landmarks;
  int prior_rows;
  size_t prior_blocks;
};

TEST(RealWindowDumps, AllNineAreReadWithTheirCounts) {
  const Expected all[] = {
      {"vio_S", 11, 10, 145, 75, 12},   {"vio_M", 11, 10, 236, 75, 12},          {"vio_L", 11, 10, 429, 75, 12},
      {"vio_Md", 11, 10, 236, 156, 21}, {"real_euroc_sub2", 11, 10, 300, 15, 2}, {"real_tango_100", 11, 10, 247, 15, 2},
      {"mono_3_20", 3, 0, 20, 0, 0},    {"mono_10_500", 10, 0, 500, 0, 0},       {"mono_20_1500", 20, 0, 1500, 0, 0}};
  const fs::path folder = DataFolder() / "windows";
  CH5_NEEDS(folder);
  for (const Expected& expected : all) {
    SCOPED_TRACE(expected.name);
    const WindowDump dump = ReadWindowDump(folder / (std::string(expected.name) + ".txt"));
    EXPECT_EQ(dump.frames.size(), expected.frames);
    EXPECT_EQ(dump.imu.size(), expected.imu);
    EXPECT_EQ(dump.landmarks.size(), expected.landmarks);
    EXPECT_EQ(dump.prior_r.size(), expected.prior_rows);
    EXPECT_EQ(dump.prior_J.rows(), expected.prior_rows);
    EXPECT_EQ(dump.prior_blocks.size(), expected.prior_blocks);
    const bool is_mono = expected.imu == 0;
    EXPECT_EQ(dump.fixed_frames, is_mono ? (std::vector<int>{0, 1}) : std::vector<int>{});
    EXPECT_EQ(dump.loss, is_mono ? WindowDump::Loss::kNone : WindowDump::Loss::kCauchy);
    int columns = 0;
    for (const WindowDump::PriorBlock& block : dump.prior_blocks) columns += block.LocalDimension();
    EXPECT_EQ(dump.prior_J.cols(), columns);
  }
}

// Conventions, against the dump's own truth: where the true inverse depth puts a landmark, the other frames see it.
// @return the RMS of what they see there, per axis, in σ
double ReprojectionErrorAtTheTruth(const WindowDump& dump) {
  const Transform& T_B_C = dump.T_B_C;
  double sum = 0.0;
  int n = 0;
  for (const WindowDump::Landmark& landmark : dump.landmarks) {
    const Transform& T_W_Bi = dump.truth[landmark.host].T_W_B;
    const Vec3 p_Ci = landmark.x_host.homogeneous() / landmark.true_inverse_depth;
    const Vec3 p_W = T_W_Bi.q * (T_B_C.q * p_Ci + T_B_C.p) + T_W_Bi.p;
    for (const WindowDump::Observation& observation : landmark.observations) {
      const Transform& T_W_Bj = dump.truth[observation.frame].T_W_B;
      const Vec3 p_Bj = T_W_Bj.q.conjugate() * (p_W - T_W_Bj.p);
      const Vec3 p_Cj = T_B_C.q.conjugate() * (p_Bj - T_B_C.p);
      sum += (p_Cj.hnormalized() - observation.x).squaredNorm();
      n += 2;
    }
  }
  return dump.sqrt_information * std::sqrt(sum / n);
}

TEST(RealWindowDumps, LandmarksOfASimulatedWindowReprojectAtTheTruth) {
  const fs::path path = DataFolder() / "windows/vio_S.txt";
  CH5_NEEDS(path);
  // In the dump's own σ of 1.5 px. Both observations are noisy, hence √2, and some are outliers; measured 1.9.
  EXPECT_NEAR(ReprojectionErrorAtTheTruth(ReadWindowDump(path)), 1.9, 0.2);
}

TEST_F(WindowDumpFile, AMadeUpWindowIsReadWholeAndReprojectsAtTheTruth) {
  const test::MadeUpWindow made = test::MakeWindow();
  const WindowDump dump = Read(made.text);
  EXPECT_EQ(dump.frames.size(), 11u);
  EXPECT_EQ(dump.imu.size(), 10u);
  EXPECT_EQ(dump.landmarks.size(), 40u);
  EXPECT_EQ(dump.prior_J, 100.0 * MatXX::Identity(15, 15));
  EXPECT_EQ(dump.prior_blocks.size(), 2u);
  EXPECT_EQ(dump.loss, WindowDump::Loss::kCauchy);
  EXPECT_NEAR(ReprojectionErrorAtTheTruth(dump),
              dump.sqrt_information * std::sqrt(made.squares / (2 * made.observations)), 1e-9);
}

}  // namespace
}  // namespace ch5
