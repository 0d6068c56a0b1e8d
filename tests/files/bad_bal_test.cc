/// Faulty BAL files: each is refused in words that name the file, the line and the value; none crashes the reader.
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/stat.h>

#include <filesystem>
#include <fstream>

#include "ch5_backend/files/bal.h"
#include "ch5_backend/files/text_reader.h"
#include "tests/data_folder.h"
#include "tests/temporary_folder.h"

namespace ch5 {
namespace {

namespace fs = std::filesystem;

// Two cameras see two points; line 1 the counts, lines 2–5 observations, 6 and 7 cameras, 8 and 9 points.
const std::vector<std::string> kLines = {
    "2 2 4",          "0 0 1.5 2.5",          "1 0 -3.5 4.5",           "0 1 5.5 -6.5",
    "1 1 7.5 8.5",    "0 0 0 0 0 -5 500 0 0", "0 0.1 0 0 0 -5 500 0 0", "0.25 0.5 0",
    "-0.25 0.5 0.125"};

std::string Join(const std::vector<std::string>& lines) {
  std::string text;
  for (const std::string& line : lines) text += line + "\n";
  return text;
}

class BadBal : public testing::Test {
 protected:
  void Write(const std::string& text) const {
    fs::remove(path_);  // some file systems flush a file that is written over, which takes its time
    std::ofstream(path_, std::ios::binary) << text;
  }

  // The message, or "" if the file is taken.
  std::string Message(const std::string& text) const {
    Write(text);
    return test::Refusal<FileError>([&] { ReadBal(path_); });
  }

  test::TemporaryFolder folder_;
  std::string path_ = folder_ / "bad.txt";
};

TEST_F(BadBal, TheGoodFileIsTaken) {
  EXPECT_EQ(Message(Join(kLines)), "");
  EXPECT_EQ(ReadBal(path_).points[1], Vec3(-0.25, 0.5, 0.125));
}

TEST_F(BadBal, MissingFilesAndFoldersAndDevices) {
  const auto expect = [](const std::string& path, const std::string& message) {
    EXPECT_EQ(test::Refusal<FileError>([&] { ReadBal(path); }), message);
  };
  expect("/no/such/file.txt", "/no/such/file.txt: cannot be read: No such file or directory");
  expect("/tmp", "/tmp: cannot be read: it is a directory");
  expect("/dev/zero", "/dev/zero: cannot be read: it is not a regular file");
  ASSERT_EQ(mkfifo(path_.c_str(), 0600), 0);  // nobody writes into it: to read it would never end
  expect(path_, path_ + ": cannot be read: it is not a regular file");
  expect("", ": cannot be read: No such file or directory");
}

TEST_F(BadBal, EmptyFiles) {
  EXPECT_EQ(Message(""), path_ + ":1: number of cameras: the file ends where a number is expected");
  EXPECT_EQ(Message("\n \n\t"), path_ + ":3: number of cameras: the file ends where a number is expected");
}

// One line of the good file replaced by another.
TEST_F(BadBal, CountsIndicesAndNumbersThatAreNone) {
  for (const auto& row : Cases("files/bad_bal.cases")) {
    std::vector<std::string> lines = kLines;
    lines.at(std::stoul(row.at(0)) - 1) = row.at(1);
    EXPECT_EQ(Message(Join(lines)), path_ + ":" + row[0] + ": " + row.at(2)) << row[1];
  }
}

TEST_F(BadBal, CountsThatTheFileIsTooSmallForTakeNoMemory) {
  rusage before, after;
  getrusage(RUSAGE_SELF, &before);
  const std::string text = Join(kLines).substr(6);
  EXPECT_EQ(Message("2147483647 2147483647 2147483647\n" + text),
            path_ +
                ":1: the header promises 2147483647 cameras, 2147483647 points and 2147483647 observations, "
                "34359738352 numbers, but only " +
                std::to_string(text.size() + 1) + " bytes follow");
  EXPECT_NE(Message("2 2 1000\n" + text).find(":1: the header promises 2 cameras"), std::string::npos);
  getrusage(RUSAGE_SELF, &after);
  EXPECT_LT(after.ru_maxrss - before.ru_maxrss, 100 * 1024);  // kB
}

TEST_F(BadBal, ARepeatedObservationIsLeftOutOfManyIfItMay) {
  std::string text = "2 20 41\n";
  for (int i = 0; i < 40; ++i) text += std::to_string(i / 20) + " " + std::to_string(i % 20) + " 1.5 2.5\n";
  text += "1 3 7 7\n" + Join({kLines[5], kLines[6]});
  for (int i = 0; i < 20; ++i) text += kLines[7] + "\n";
  EXPECT_EQ(Message(text), path_ + ":42: observation 40 is repeated: camera 1 saw point 3 in line 25 already");
  std::vector<LeftOut> left_out;
  const BalProblem problem = ReadBal(path_, &left_out);
  ASSERT_EQ(left_out.size(), 1u);
  EXPECT_EQ(left_out[0].count, 1);
  EXPECT_EQ(left_out[0].first, Message(text));
  EXPECT_EQ(problem.observations.size(), 40u);
  EXPECT_EQ(problem.observations[23].pixel, Vec2(1.5, 2.5));
}

TEST_F(BadBal, NumbersTooSmallForADoubleAreZero) {
  std::vector<std::string> lines = kLines;
  lines[7] = "1e-999 -1e-999 4.9e-324";
  ASSERT_EQ(Message(Join(lines)), "");
  EXPECT_EQ(ReadBal(path_).points[0], Vec3(0, 0, 4.9e-324));
}

TEST_F(BadBal, TrailingText) {
  EXPECT_EQ(Message(Join(kLines) + "\n0.5\n"), path_ + ":11: text after the end of the data, got \"0.5\"");
  EXPECT_EQ(Message(Join(kLines) + "\n \t\r\n"), "");
}

TEST_F(BadBal, BinaryAndCompressedFiles) {
  EXPECT_EQ(Message(std::string("\x7f"
                                "ELF\x02\x01\x00\xff",
                                8)),
            path_ + R"(:1: number of cameras: not a whole number, got "\x7fELF\x02\x01\x00\xff")");
  for (const char* begin : {"BZh91AY&SY", "\x1f\x8b\x08", "PK\x03\x04", "\xfd\x37zXZ", "\x28\xb5\x2f\xfd"})
    EXPECT_NE(Message(begin).find(":1: the file is compressed; unpack it first"), std::string::npos) << begin;
  const std::string long_word(1000000, 'x');
  EXPECT_EQ(Message(long_word),
            path_ + ":1: number of cameras: not a whole number, got \"" + std::string(32, 'x') + "…\"");
}

// Whatever the place of the cut: only a cut within the last number cannot be seen.
TEST_F(BadBal, FilesCutShort) {
  const std::string text = Join(kLines);
  const size_t last_number = text.rfind(' ') + 1;
  for (size_t length = 0; length <= last_number; ++length) {
    const std::string message = Message(text.substr(0, length));
    EXPECT_EQ(message.rfind(path_ + ":", 0), 0u) << length;
  }
  EXPECT_EQ(Message(text.substr(0, text.rfind('0') - 1)),
            path_ + ":9: point 1, z: the file ends where a number is expected");
}

}  // namespace
}  // namespace ch5
