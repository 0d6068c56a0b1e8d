#include "ch5_backend/files/recording_file.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <regex>
#include <sstream>

#include "ch5_backend/files/tables/text_writer.h"
#include "ch5_backend/files/yaml_file.h"
#include "ch5_backend/simulate/random.h"
#include "ch5_backend/simulate/sensors/paths.h"
#include "ch5_backend/simulate/sensors/simulation.h"
#include "tests/data_folder.h"
#include "tests/temporary_folder.h"

namespace ch5 {
namespace {

namespace fs = std::filesystem;

// A small good recording on disk, to be spoilt.
class RecordingFile : public testing::Test {
 protected:
  void SetUp() override {
    Random random(1);
    std::vector<Vec3> points(20);
    for (Vec3& point : points) point = UniformVector(&random, Vec3(4, -3, -2), Vec3(6, 3, 2));
    HandheldOptions handheld{0.5};
    handheld.position_sigma = handheld.yaw_step = handheld.tilt_sigma = 0.05;
    recording_ = SimulateRecording(Handheld(handheld), points);
    recording_.origin_ns = 1403715273262143232;
    WriteRecording(recording_, folder_);
  }

  std::string Read(const std::string& name) { return test::ReadText(folder_ / name); }
  void Write(const std::string& name, const std::string& text) { WriteFileAtomically(folder_ / name, text); }

  // Line `n` (from 1) of a file, without its end.
  std::string Line(const std::string& name, int n) {
    std::istringstream stream(Read(name));
    std::string line;
    for (int i = 0; i < n; ++i) std::getline(stream, line);
    return line;
  }
  void ReplaceLine(const std::string& name, int n, const std::string& by) {
    const std::string text = Read(name), line = Line(name, n);
    std::istringstream stream(text);
    size_t begin = 0;
    std::string skipped;
    for (int i = 1; i < n; ++i) begin += (std::getline(stream, skipped), skipped.size() + 1);
    Write(name, text.substr(0, begin) + by + text.substr(begin + line.size()));
  }
  void Replace(const std::string& name, const std::string& what, const std::string& by) {
    std::string text = Read(name);
    const size_t at = text.find(what);
    ASSERT_NE(at, std::string::npos) << what;
    Write(name, text.replace(at, what.size(), by));
  }

  // What is wrong with the folder, without the folder's name.
  std::string Message() {
    const std::string message = test::Refusal<FileError>([&] { ReadRecording(folder_); });
    const std::string prefix = folder_.string() + "/";
    return message.rfind(prefix, 0) == 0 ? message.substr(prefix.size()) : message;
  }

  test::TemporaryFolder temporary_;
  fs::path folder_ = temporary_.Path();
  Recording recording_;
};

TEST_F(RecordingFile, WhatIsWrittenIsReadBackToTheBit) {
  const Recording read = ReadRecording(folder_);
  EXPECT_EQ(read.origin_ns, recording_.origin_ns);
  ASSERT_EQ(read.imu.size(), recording_.imu.size());
  ASSERT_EQ(read.truth.size(), recording_.truth.size());
  ASSERT_EQ(read.images.size(), recording_.images.size());
  for (size_t k = 0; k < read.imu.size(); ++k) {
    EXPECT_EQ(read.imu[k].t, recording_.imu[k].t);
    EXPECT_EQ(read.imu[k].acceleration, recording_.imu[k].acceleration);
    EXPECT_EQ(read.imu[k].gyroscope, recording_.imu[k].gyroscope);
    EXPECT_EQ(read.truth[k].T_W_B.p, recording_.truth[k].T_W_B.p);
    EXPECT_LT((read.truth[k].T_W_B.q.coeffs() - recording_.truth[k].T_W_B.q.coeffs()).norm(), 1e-15);  // normalized
    EXPECT_EQ(read.truth[k].v_W, recording_.truth[k].v_W);
    EXPECT_EQ(read.truth[k].b_a, recording_.truth[k].b_a);
    EXPECT_EQ(read.truth[k].b_g, recording_.truth[k].b_g);
  }
  for (size_t n = 0; n < read.images.size(); ++n) {
    EXPECT_EQ(read.images[n].t, recording_.images[n].t);
    ASSERT_EQ(read.images[n].tracks.size(), recording_.images[n].tracks.size());
    EXPECT_EQ(read.images[n].tracks.back().id, recording_.images[n].tracks.back().id);
    EXPECT_EQ(read.images[n].tracks.back().x, recording_.images[n].tracks.back().x);
  }
  const Calibration &a = read.calibration, &b = recording_.calibration;
  EXPECT_EQ(a.T_B_C.p, b.T_B_C.p);
  EXPECT_EQ(a.T_B_C.q.coeffs(), b.T_B_C.q.coeffs());
  EXPECT_EQ(Vec2(a.fx, a.fy), Vec2(b.fx, b.fy));
  EXPECT_EQ(Vec2(a.cx, a.cy), Vec2(b.cx, b.cy));
  EXPECT_TRUE(a.width == b.width && a.height == b.height && a.gravity == b.gravity && a.noise.continuous);
  EXPECT_TRUE(a.camera_rate == b.camera_rate && a.imu_rate == b.imu_rate);
  EXPECT_EQ(a.noise.accelerometer, b.noise.accelerometer);
  EXPECT_EQ(a.noise.gyroscope, b.noise.gyroscope);
  EXPECT_EQ(a.noise.accelerometer_walk, b.noise.accelerometer_walk);
  EXPECT_EQ(a.noise.gyroscope_walk, b.noise.gyroscope_walk);
}

TEST_F(RecordingFile, ASecondCameraIsReadBackToTheBit) {
  recording_.calibration.camera1 = ForwardStereo().camera1;
  recording_.calibration.camera1->fx = 455.5;
  recording_.images[1].tracks1 = {{recording_.images[1].tracks[0].id, Vec2(0.1, -0.2)}, {99, Vec2(0.3, 0.4)}};
  WriteRecording(recording_, folder_);
  const Recording read = ReadRecording(folder_);
  ASSERT_TRUE(read.calibration.camera1);
  const Camera &a = *read.calibration.camera1, &b = *recording_.calibration.camera1;
  EXPECT_EQ(a.T_B_C.p, b.T_B_C.p);
  EXPECT_EQ(a.T_B_C.q.coeffs(), b.T_B_C.q.coeffs());
  EXPECT_TRUE(a.fx == b.fx && a.fy == b.fy && a.cx == b.cx && a.cy == b.cy && a.width == b.width);
  ASSERT_EQ(read.images.size(), recording_.images.size());
  for (size_t n = 0; n < read.images.size(); ++n) {
    EXPECT_EQ(read.images[n].tracks.size(), recording_.images[n].tracks.size());
    ASSERT_EQ(read.images[n].tracks1.size(), recording_.images[n].tracks1.size());
  }
  EXPECT_EQ(read.images[1].tracks1[1].id, 99);
  EXPECT_EQ(read.images[1].tracks1[1].x, Vec2(0.3, 0.4));
}

TEST_F(RecordingFile, OfASecondCameraEveryMistakeIsNamed) {
  const std::string columns = "#timestamp [ns],track_id,x [normalized],y [normalized]";
  const std::string row = Line("tracks.csv", 2);
  Write("tracks.csv", columns + ",camera\n" + row + ",1\n");
  EXPECT_EQ(Message(), "tracks.csv:2: a point of camera 1, but calibration.yaml has no camera1");
  const std::string known = Read("calibration.yaml");
  std::string section = known.substr(0, known.find("imu:"));
  section.replace(0, 7, "camera1:")
      .erase(section.find("  rate_hz"), section.find("  # T_B_C") - section.find("  rate_hz"));
  Write("calibration.yaml", known + section);
  EXPECT_EQ(Message(), "");
  Write("tracks.csv", columns + ",camera\n" + row + ",1\n" + row + ",0\n" + row + ",1\n");
  EXPECT_EQ(Message(), "tracks.csv:4: the track is in this image already, got track_id 0 of camera 1");
  Write("tracks.csv", columns + ",camera\n" + row + ",2\n");
  EXPECT_EQ(Message(), "tracks.csv:2: camera: must lie in [0, 1], got \"2\"");
  Write("calibration.yaml", known + "camera1:\n  rate_hz: 20\n");
  EXPECT_EQ(Message(), "calibration.yaml: camera1.intrinsics.fx is missing");
  Write("calibration.yaml", known + section + "  rate_hz: 20\n");
  EXPECT_EQ(Message(), "calibration.yaml:" +
                           std::to_string(std::count(known.begin(), known.end(), '\n') +
                                          std::count(section.begin(), section.end(), '\n') + 1) +
                           ": camera1.rate_hz: nothing of this name is known here");
}

TEST_F(RecordingFile, WorksWithoutTruthWithBlankLinesAndWithOtherLineEnds) {
  fs::remove(folder_ / "groundtruth.csv");
  const std::string text = Read("imu.csv") + "\n \n";
  for (const std::string end : {"\r\n", "\r"}) {
    std::string other;
    for (const char c : text) other += c == '\n' ? end : std::string(1, c);
    Write("imu.csv", other);
    const Recording read = ReadRecording(folder_);
    EXPECT_TRUE(read.truth.empty());
    EXPECT_EQ(read.imu.size(), recording_.imu.size());
    EXPECT_EQ(read.imu.back().acceleration, recording_.imu.back().acceleration);
  }
}

// The row itself is out of order, not the thousands below it.
TEST_F(RecordingFile, AStampThatJumpsAheadCostsOneRow) {
  const std::string line = Line("imu.csv", 40), stamp = line.substr(0, line.find(','));
  const std::string jump = std::to_string(std::stoll(stamp) + 3600000000000);
  ReplaceLine("imu.csv", 40, jump + line.substr(stamp.size()));
  const std::string words = "imu.csv:40: the timestamp jumps ahead of those in the rows below, got " + jump;
  EXPECT_EQ(Message(), words);
  std::vector<LeftOut> left_out;
  const Recording read = ReadRecording(folder_, &left_out);
  EXPECT_EQ(read.imu.size(), recording_.imu.size() - 1);
  ASSERT_EQ(left_out.size(), 1u);
  EXPECT_EQ(left_out[0].count, 1);
  EXPECT_NE(left_out[0].first.find(words), std::string::npos) << left_out[0].first;
}

// As motion capture writes that has lost sight of the body.
TEST_F(RecordingFile, ATruthMayHavePosesWithoutNumbers) {
  const size_t poses = recording_.truth.size();
  const auto spoil = [&](size_t first, size_t end) {
    for (size_t k = first; k < end; ++k) {
      const int n = static_cast<int>(k) + 2;
      const std::string line = Line("groundtruth.csv", n);
      ReplaceLine("groundtruth.csv", n, line.substr(0, line.find(',')) + ",nan" + line.substr(line.find(',', 30)));
    }
  };
  spoil(0, poses / 4);
  EXPECT_NE(Message().find("groundtruth.csv:2: p_x: not finite, got \"nan\""), std::string::npos) << Message();
  std::vector<LeftOut> left_out;
  EXPECT_EQ(ReadRecording(folder_, &left_out).truth.size(), poses - poses / 4);
  ASSERT_EQ(left_out.size(), 1u);
  EXPECT_EQ(left_out[0].count, static_cast<int>(poses / 4));
  spoil(poses / 4, poses / 2 + 2);
  EXPECT_THROW(ReadRecording(folder_, &left_out), FileError);
}

TEST(OutOfOrder, LeavesOutTheFewest) {
  EXPECT_EQ(OutOfOrder({}), std::vector<bool>());
  EXPECT_EQ(OutOfOrder({1, 2, 2, 3}), std::vector<bool>({false, false, false, false}));
  EXPECT_EQ(OutOfOrder({1, 9, 2, 3}), std::vector<bool>({false, true, false, false}));
  EXPECT_EQ(OutOfOrder({9, 1, 2, 3}), std::vector<bool>({true, false, false, false}));
  EXPECT_EQ(OutOfOrder({1, 3, 2, 4}), std::vector<bool>({false, false, true, false}));
}

// One line replaced by another, or by one of the file's own, =2, is refused with "file:line: words".
TEST_F(RecordingFile, FaultyLinesAreNamed) {
  for (const auto& row : Cases("files/recording_lines.cases")) {
    const std::string &file = row.at(0), good = Read(file), by = row.at(2);
    ReplaceLine(file, std::stoi(row.at(1)), by[0] == '=' ? Line(file, std::stoi(by.substr(1))) : by);
    EXPECT_EQ(Message(), file + ":" + row[1] + ": " + row.at(3));
    Write(file, good);
  }
}

TEST_F(RecordingFile, MissingHeadersRowsAndFilesAreNamed) {
  const std::string good = Read("tracks.csv");
  Write("tracks.csv", good + Line("tracks.csv", 2) + "\n");
  EXPECT_NE(Message().find("the timestamp goes backwards, got 1403715273262143232 after "), std::string::npos);
  Write("tracks.csv", good);
  ReplaceLine("tracks.csv", 1, "#timestamp [ns],track_id,x");
  EXPECT_EQ(Message(),
            "tracks.csv:2: a row of 4 columns, but the first line names 3, got \"1403715273262143232,0,-0.2684411…\"");
  ReplaceLine("tracks.csv", 1, "#timestamp [s],track_id,x,y");
  EXPECT_EQ(Message().find("tracks.csv:1: the first line must name the columns and begin with \"#timestamp [ns]\""),
            0u);
  Write("tracks.csv", "");
  EXPECT_EQ(Message(), "tracks.csv:1: the file is empty");
  Write("tracks.csv", "#timestamp [ns],track_id,x,y\n");
  EXPECT_EQ(Message(), "tracks.csv:2: at least one image is needed");
  fs::remove(folder_ / "tracks.csv");
  EXPECT_EQ(Message(), "tracks.csv: cannot be read: No such file or directory");
  Write("tracks.csv", good);
  Write("imu.csv", Line("imu.csv", 1) + "\n" + Line("imu.csv", 2) + "\n");
  EXPECT_EQ(Message(), "imu.csv:3: at least two IMU measurements are needed");
}

TEST_F(RecordingFile, ATruthThatIsNoneIsNamed) {
  const std::string good = Read("groundtruth.csv");
  Write("groundtruth.csv", Line("groundtruth.csv", 1) + "\n");
  EXPECT_EQ(Message(), "groundtruth.csv:2: at least one pose is needed; where the truth is not known, remove the file");
  Write("groundtruth.csv", good.substr(good.find('\n') + 1));
  EXPECT_EQ(Message().find("groundtruth.csv:1: the first line must name the columns and begin with"), 0u) << Message();
  Write("groundtruth.csv", "\xff\xfe#");
  EXPECT_EQ(Message(), "groundtruth.csv:1: the file is in UTF-16; save it as UTF-8");
  fs::remove(folder_ / "groundtruth.csv");
  fs::create_symlink(folder_ / "elsewhere.csv", folder_ / "groundtruth.csv");
  EXPECT_EQ(Message(), "groundtruth.csv: cannot be read: No such file or directory");
}

TEST_F(RecordingFile, OtherUnitsAreNoticed) {
  for (ImuMeasurement& measurement : recording_.imu) measurement.acceleration /= 9.81;
  WriteRecording(recording_, folder_);
  EXPECT_NE(Message().find(" long (median), where gravity alone is 9.81"), std::string::npos) << Message();
  for (ImuMeasurement& measurement : recording_.imu)
    measurement = {measurement.t / 1e3, 9.81 * measurement.acceleration, Vec3::Zero()};
  recording_.images.resize(1);
  recording_.truth.clear();
  WriteRecording(recording_, folder_);
  EXPECT_EQ(
      Message().find("imu.csv:1: the timestamps are in microseconds if there are as many a second as imu.rate_hz"), 0u)
      << Message();
}

TEST_F(RecordingFile, StampsOfOneFileInAnotherUnitAreNamed) {
  const std::regex stamp("\\n(\\d+)\\d{3},");
  const std::string of_rate = "the timestamps are in microseconds if there are as many a second as ";
  for (const auto& [name, says] : {std::pair<std::string, std::string>{"imu.csv", of_rate + "imu.rate_hz"},
                                   {"tracks.csv", of_rate + "camera.rate_hz"},
                                   {"groundtruth.csv", "; it looks like microseconds, and must be in nanoseconds"}}) {
    const std::string text = Read(name);
    Write(name, std::regex_replace(text, stamp, "\n$1,"));
    EXPECT_NE(Message().find(says), std::string::npos) << Message();
    Write(name, text);
  }
}

// As spreadsheets, OpenCV and people write it.
TEST_F(RecordingFile, HarmlessMarksAreRead) {
  for (const char* name : {"imu.csv", "tracks.csv", "calibration.yaml"}) Write(name, "\xef\xbb\xbf" + Read(name));
  EXPECT_EQ(ReadRecording(folder_).imu.size(), recording_.imu.size());
  for (const char separator : {';', '\t'}) {
    WriteRecording(recording_, folder_);
    std::string text = Read("imu.csv");
    std::replace(text.begin(), text.end(), ',', separator);
    Write("imu.csv", text);
    EXPECT_EQ(ReadRecording(folder_).imu.back().acceleration, recording_.imu.back().acceleration);
    ReplaceLine("imu.csv", 2, std::string("1403715273262143232") + separator + "0,1");
    EXPECT_EQ(Message().find("imu.csv:2: a row of 2 columns, but the first line names 7"), 0u) << Message();
  }
  WriteRecording(recording_, folder_);
  Write("calibration.yaml", "%YAML:1.0\n---\n" + Read("calibration.yaml"));
  Replace("calibration.yaml", "rate_hz: 20", "rate_hz: \"20\"\t# Hz");
  EXPECT_EQ(ReadRecording(folder_).calibration.camera_rate, recording_.calibration.camera_rate);
}

// Columns are found by their names, in EuRoC's spelling too.
TEST_F(RecordingFile, ColumnsMayStandInAnotherOrder) {
  std::istringstream lines(Read("imu.csv"));
  std::string line,
      changed = "timestamp,a_RS_S_x [m s^-2],a_RS_S_y,a_RS_S_z,w_RS_S_x [rad s^-1],w_RS_S_y,w_RS_S_z,note\n";
  std::getline(lines, line);
  while (std::getline(lines, line)) {
    std::vector<std::string_view> cells = SplitAt(',', line);
    std::rotate(cells.begin() + 1, cells.begin() + 4, cells.end());
    for (const std::string_view cell : cells) changed += std::string(cell) + ",";
    changed += "none\n";
  }
  Write("imu.csv", changed);
  EXPECT_EQ(ReadRecording(folder_).imu.back().acceleration, recording_.imu.back().acceleration);
  EXPECT_EQ(ReadRecording(folder_).imu.back().gyroscope, recording_.imu.back().gyroscope);
  ReplaceLine("imu.csv", 1, "timestamp,a_x,a_y,a_z,w_x,w_y,w_z,w_RS_S_z");
  EXPECT_EQ(Message(), "imu.csv:1: two columns are called w_z (without units and frames)");
  ReplaceLine("imu.csv", 1, "timestamp,a_x,a_y,a_z,w_x,w_y,wz,note");
  EXPECT_EQ(Message(),
            "imu.csv:1: there is no column w_z; the first line names timestamp, a_x, a_y, a_z, w_x, w_y, wz, note");
}

TEST_F(RecordingFile, TheCalibrationIsReadStrictly) {
  for (const auto& row : Cases("files/calibration.cases")) {
    WriteRecording(recording_, folder_);
    Replace("calibration.yaml", row.at(0), row.at(1));
    EXPECT_TRUE(IsSaid(row.at(2), Message())) << row[1] << Message();
  }
}

TEST_F(RecordingFile, YamlOfOtherWritersIsRead) {
  const std::string path = (folder_ / "other.yaml").string();
  Write("other.yaml",
        "%YAML:1.0\ncam0: &first\n  T: !!opencv-matrix\n    rows: 1\n    data: [ 1., 2.,\n      3. ]\n"
        "  rate: !!float 20\n  flow: {size: [4, 5], none: {}, last: 6,}\n  empty: {}\n"
        "  points:\n  - {x: 1}\n  - {x: 2}\n"
        "  \"maker\": \"No. # 1\"  # camera's\n  'json': {\"fx\": 7}\n");
  const YamlFile yaml(path, "cam0");
  EXPECT_EQ(yaml.Numbers("T.data", 3), (std::vector<double>{1, 2, 3}));
  EXPECT_EQ(yaml.Positive("rate"), 20.0);
  EXPECT_EQ(yaml.Numbers("flow.size", 2), (std::vector<double>{4, 5}));
  EXPECT_EQ(yaml.Positive("flow.last"), 6.0);
  EXPECT_FALSE(yaml.Has("empty"));
  EXPECT_EQ(yaml.Word("points"), "{x: 1}, {x: 2}");
  EXPECT_EQ(yaml.Word("maker"), "No. # 1");
  EXPECT_EQ(yaml.Positive("json.fx"), 7.0);
}

// Where each line was joined to a list that was counted anew, a megabyte took minutes.
TEST_F(RecordingFile, LongListsInYamlAreReadInLinearTime) {
  std::string rows = "a:\n", open = "a: [0";
  for (int i = 0; i < 200000; ++i) {
    rows += "- [1]\n";
    open += ",\n1";
  }
  Write("other.yaml", rows);
  EXPECT_EQ(YamlFile((folder_ / "other.yaml").string()).Numbers("a", 200000).back(), 1.0);
  Write("other.yaml", open + "]\n");
  EXPECT_EQ(YamlFile((folder_ / "other.yaml").string()).Numbers("a", 200001).back(), 1.0);
}

TEST_F(RecordingFile, AFailedWriteLeavesTheOlderRecording) {
  const std::string before = Read("imu.csv");
  fs::remove(folder_ / "tracks.csv");
  fs::create_directory(folder_ / "tracks.csv");
  Recording other = recording_;
  other.imu.pop_back();
  EXPECT_THROW(WriteRecording(other, folder_), WriteError);
  EXPECT_EQ(Read("imu.csv"), before);
  for (const auto& entry : fs::directory_iterator(folder_)) {
    EXPECT_NE(entry.path().extension(), ".partial") << entry.path();
  }
}

// As a motion capture system gives it.
TEST_F(RecordingFile, OfTheTruthPosesAreEnough) {
  std::istringstream lines(Read("groundtruth.csv"));
  std::string line, poses;
  while (std::getline(lines, line)) {
    size_t end = 0;
    for (int cell = 0; cell < 8; ++cell) end = line.find(',', end + 1);
    poses += line.substr(0, end) + "\n";
  }
  Write("groundtruth.csv", poses);
  const std::vector<StampedState> truth = ReadRecording(folder_).truth;
  ASSERT_EQ(truth.size(), recording_.truth.size());
  for (size_t i = 1; i + 1 < truth.size(); ++i) {
    EXPECT_LT((truth[i].v_W - recording_.truth[i].v_W).norm(), 1e-3) << i;
    EXPECT_EQ(truth[i].b_g, Vec3::Zero());
  }
}

TEST_F(RecordingFile, TruthMayBeInTumsFormat) {
  Write("groundtruth.csv",
        "#timestamp, p_x, p_y, p_z, q_w, q_x, q_y, q_z\n1403715273262143232, 1, 2, 3, 0.8, 0, 0, 0.6\n");
  EXPECT_FALSE(IsTum((folder_ / "groundtruth.csv").string()));
  fs::remove(folder_ / "groundtruth.csv");
  const std::string head = "# ground truth trajectory\n# timestamp tx ty tz qx qy qz qw\n",
                    rows = "1403715273.262143232 1 2 3 0 0 0.6 0.8\n1403715273.762143232\t1 2.5 3 0 0 0.6 0.8\n";
  Write("groundtruth.txt", head + rows);
  const std::vector<StampedState> truth = ReadRecording(folder_).truth;
  ASSERT_EQ(truth.size(), 2u);
  EXPECT_NEAR(truth[1].t, 0.5, 1e-6) << "a double of seconds since 1970 resolves 2e-7 s";
  EXPECT_EQ(truth[0].T_W_B.p, Vec3(1, 2, 3));
  EXPECT_EQ(truth[0].T_W_B.q.w(), 0.8);
  EXPECT_NEAR(truth[0].v_W.y(), 1.0, 1e-5);
  const auto message = [&](const std::string& more) { return Write("groundtruth.txt", head + rows + more), Message(); };
  EXPECT_EQ(
      message("1403715274 1 2 3 0 0 0.6\n"),
      "groundtruth.txt:5: a pose is timestamp tx ty tz qx qy qz qw, eight numbers, got \"1403715274 1 2 3 0 0 0.6\"");
  EXPECT_EQ(message("1403715273.5 1 2 3 0 0 0.6 0.8\n"),
            "groundtruth.txt:5: the timestamp is repeated or goes backwards, got 1403715273.5");
  EXPECT_EQ(message("1403715274 1 2 3 0 0 6 8\n"),
            "groundtruth.txt:5: the quaternion must be of length 1, got 10.000000");
  EXPECT_EQ(
      message("1403715274262 1 2 3 0 0 0.6 0.8\n"),
      "groundtruth.txt:5: the timestamp is more than ten days from the first IMU measurement, got 1403715274262, which "
      "must be in seconds");
  EXPECT_EQ(message("1403715274262142976 1 2 3 0 0 0.6 0.8\n"),
            "groundtruth.txt:5: timestamp [s]: absurdly large (beyond 1e15), got \"1403715274262142976\"");
}

// Motion capture systems often have y upwards.
TEST_F(RecordingFile, ATruthWhoseZIsNotUpIsRefusedOrLeftOut) {
  recording_ = SimulateRecording(Handheld({3.0}), {Vec3(5, 0, 0), Vec3(0, 5, 0), Vec3(-5, 0, 0), Vec3(0, -5, 0)});
  WriteRecording(recording_, folder_);
  EXPECT_EQ(Message(), "");
  for (StampedState& state : recording_.truth) state.T_W_B.q = ExpSO3({-M_PI / 2, 0, 0}) * state.T_W_B.q;
  WriteRecording(recording_, folder_);
  EXPECT_EQ(Message().find("groundtruth.csv: z must be up in its world, but turned into it the accelerations are "),
            0u);
  std::vector<LeftOut> left_out;  // the accelerometer may be at fault as well
  EXPECT_TRUE(ReadRecording(folder_, &left_out).truth.empty());
  ASSERT_EQ(left_out.size(), 1u);
  EXPECT_EQ(left_out[0].first.find("z must be up in its world"), 0u);
}

TEST_F(RecordingFile, ClocksThatDifferAreNamed) {
  for (Image& image : recording_.images) image.t -= 3600.0;
  WriteRecording(recording_, folder_);
  EXPECT_EQ(
      Message().find("tracks.csv: the clocks of camera and IMU differ: no image lies within the IMU's time; the images "
                     "are from -3600.00 s to "),
      0u)
      << Message();
}

// In nanoseconds, so far from the origin, doubles in seconds no longer tell the measurements apart, or even overflow.
TEST_F(RecordingFile, TimestampsFarFromTheFirstReadingAreRefused) {
  const int64_t origin = recording_.origin_ns, farthest = origin + kLongestRecordingNs;
  const int last = 1 + static_cast<int>(recording_.imu.size());
  const auto row = [](int64_t stamp) { return std::to_string(stamp) + ",0,0,0,0,0,9.8"; };
  for (const int64_t stamp : {farthest + 1, std::numeric_limits<int64_t>::max()}) {
    ReplaceLine("imu.csv", last, row(stamp));
    EXPECT_EQ(Message(), "imu.csv:" + std::to_string(last) +
                             ": the timestamp is more than ten days from the first IMU measurement, got " +
                             std::to_string(stamp) + " against " + std::to_string(origin));
  }
  ReplaceLine("imu.csv", last, row(farthest));
  const Recording read = ReadRecording(folder_);
  EXPECT_EQ(NanosecondsAt(read.imu.back().t, read.origin_ns), farthest);
  ReplaceLine("tracks.csv", 2, "0,1,0,0");  // images, and the truth, before the first measurement as well
  EXPECT_EQ(Message(),
            "tracks.csv:2: the timestamp is more than ten days from the first IMU measurement, got 0 against " +
                std::to_string(origin));
}

}  // namespace
}  // namespace ch5
