// Tables on disk: exact numbers, whole files or none.
#include "ch5_backend/files/tables/csv.h"

#include <gtest/gtest.h>
#include <sys/resource.h>

#include <csignal>
#include <cstdlib>
#include <limits>

#include "tests/temporary_folder.h"

namespace ch5 {
namespace {

class Csv : public testing::Test {
 protected:
  static std::string WhyNot(const std::filesystem::path& path) {
    return test::Refusal<WriteError>([&] { WriteFileAtomically(path, "new"); });
  }

  test::TemporaryFolder temporary_;
  std::filesystem::path folder_ = temporary_.Path();
};

TEST_F(Csv, NumbersReadBackToTheSameBits) {
  for (const double x : {0.1, 1.0 / 3.0, -1e-300, 5e-324, 1.7976931348623157e308, 123456789.0}) {
    CsvTable table("x");
    table.Row(x);
    EXPECT_EQ(std::strtod(table.Text().c_str() + 2, nullptr), x);
  }
}

TEST_F(Csv, RowsAreTheHeadersWidth) {
  CsvTable table("name,count,length_m");
  table.Row("pose", 3, 0.5);
  table.Row(std::string("point"), size_t{20}, std::numeric_limits<double>::infinity());
  table.Row("line", 2, std::numeric_limits<double>::quiet_NaN());
  EXPECT_EQ(table.Text(), "name,count,length_m\npose,3,0.5\npoint,20,inf\nline,2,\n");
  EXPECT_THROW(table.Row("pose", 3), std::invalid_argument);
}

TEST_F(Csv, FilesAreMadeWithTheirFolders) {
  WriteFileAtomically(folder_ / "a" / "b" / "c.csv", "x\n1\n");
  EXPECT_EQ(test::ReadText(folder_ / "a" / "b" / "c.csv"), "x\n1\n");
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(folder_ / "a" / "b"), {}), 1) << "and nothing else";
}

TEST_F(Csv, AFullDiskLeavesTheOldFileAndSaysWhy) {
  const auto path = folder_ / "table.csv";
  WriteFileAtomically(path, "old");
  // A limit on the size of files stands for the end of the disk.
  const auto handler = std::signal(SIGXFSZ, SIG_IGN);
  rlimit before;
  ASSERT_EQ(getrlimit(RLIMIT_FSIZE, &before), 0);
  const rlimit small = {1, before.rlim_max};
  ASSERT_EQ(setrlimit(RLIMIT_FSIZE, &small), 0);
  const std::string why = WhyNot(path);
  setrlimit(RLIMIT_FSIZE, &before);
  std::signal(SIGXFSZ, handler);
  EXPECT_EQ(why, "cannot write " + path.string() + ": File too large");
  EXPECT_EQ(test::ReadText(path), "old");
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(folder_), {}), 1) << "nothing is left of the attempt";
}

TEST_F(Csv, TwoBatchesOfTheSameFileDoNotTouchEachOther) {
  const auto path = folder_ / "table.csv";
  FileBatch one, other;
  one.Add(path, "one\n");
  other.Add(path, "the other\n");
  one.Commit();
  EXPECT_EQ(test::ReadText(path), "one\n");
  other.Commit();
  EXPECT_EQ(test::ReadText(path), "the other\n");
}

TEST_F(Csv, ANameMayBeAsLongAsTheSystemAllows) {
  const auto path = folder_ / (std::string(251, 'x') + ".csv");
  WriteFileAtomically(path, "x\n");
  EXPECT_EQ(test::ReadText(path), "x\n");
}

TEST_F(Csv, TheInputIsNotOverwrittenUnderAnyOfItsNames) {
  const auto input = folder_ / "input.txt", link = folder_ / "link.txt", other = folder_ / "other.txt";
  WriteFileAtomically(input, "mine");
  std::filesystem::create_symlink("input.txt", link);
  for (const auto& path : {input, link, folder_ / "." / "input.txt"}) {
    FileBatch batch(input);
    batch.Add(other, "result");
    EXPECT_THROW(batch.Add(path, "result"), WriteError) << path;
  }
  EXPECT_EQ(test::ReadText(input), "mine");
  EXPECT_FALSE(std::filesystem::exists(other));
}

TEST_F(Csv, AFolderThatRemainsEmptyGoesAgain) {
  const auto empty = folder_ / "was there", full = folder_ / "a" / "b";
  std::filesystem::create_directory(empty);
  {
    const OutputFolder of_old(empty), of_new(empty / "c" / "d"), used(full);
    WriteFileAtomically(full / "c.csv", "x\n");
  }
  EXPECT_TRUE(std::filesystem::is_empty(empty)) << "it is there, and c is not";
  EXPECT_EQ(test::ReadText(full / "c.csv"), "x\n");
}

TEST_F(Csv, APlaceThatCannotBeWrittenIsNamed) {
  WriteFileAtomically(folder_ / "file", "old");
  EXPECT_NE(WhyNot(folder_ / "file" / "table.csv").find((folder_ / "file").string()), std::string::npos);
  std::filesystem::create_directories(folder_ / "folder.csv" / "not empty");
  EXPECT_NE(WhyNot(folder_ / "folder.csv").find("folder.csv"), std::string::npos);
  EXPECT_TRUE(std::filesystem::is_directory(folder_ / "folder.csv" / "not empty"));
}

}  // namespace
}  // namespace ch5
