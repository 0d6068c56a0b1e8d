// Tables on disk: exact numbers, whole files or none.
#include "ch5_backend/world/files/csv.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <cstdlib>
#include <fstream>
#include <limits>
#include <sstream>

namespace ch5 {
namespace {

class Csv : public testing::Test {
 protected:
  void SetUp() override { std::filesystem::create_directories(folder_); }
  void TearDown() override { std::filesystem::remove_all(folder_); }

  static std::string Read(const std::filesystem::path& path) {
    std::ostringstream text;
    text << std::ifstream(path).rdbuf();
    return text.str();
  }
  static std::string WhyNot(const std::filesystem::path& path) {
    try {
      WriteFileAtomically(path, "new");
    } catch (const WriteError& error) {
      return error.what();
    }
    return "";
  }

  std::filesystem::path folder_ =
      std::filesystem::temp_directory_path() /
      ("ch5_csv_" + std::to_string(getpid()) + testing::UnitTest::GetInstance()->current_test_info()->name());
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
  EXPECT_EQ(table.Text(), "name,count,length_m\npose,3,0.5\npoint,20,inf\n");
  EXPECT_THROW(table.Row("pose", 3), std::invalid_argument);
}

TEST_F(Csv, FilesAreMadeWithTheirFolders) {
  WriteFileAtomically(folder_ / "a" / "b" / "c.csv", "x\n1\n");
  EXPECT_EQ(Read(folder_ / "a" / "b" / "c.csv"), "x\n1\n");
  EXPECT_FALSE(std::filesystem::exists(folder_ / "a" / "b" / "c.csv.partial"));
}

TEST_F(Csv, AFullDiskLeavesTheOldFileAndSaysWhy) {
  if (!std::filesystem::exists("/dev/full")) GTEST_SKIP() << "this system has no /dev/full to write to";
  const auto path = folder_ / "table.csv";
  WriteFileAtomically(path, "old");
  std::filesystem::create_symlink("/dev/full", path.string() + ".partial");  // the disk is full where it writes first
  const std::string why = WhyNot(path);
  EXPECT_NE(why.find(path.string()), std::string::npos) << why;
  EXPECT_NE(why.find("No space left"), std::string::npos) << why;
  EXPECT_EQ(Read(path), "old");
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
