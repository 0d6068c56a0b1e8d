// Any bytes as the files of a recording, separated by lines of "%%" (calibration, IMU, tracks and, if it is there, the
// truth): they are refused with a FileError, or what was read is in the order of time.
#include <cmath>
#include <filesystem>
#include <vector>

#include "ch5_backend/files/recording_file.h"
#include "tests/fuzz/memory_file.h"

namespace {

using namespace ch5;
namespace fs = std::filesystem;

constexpr const char* kNames[] = {"calibration.yaml", "imu.csv", "tracks.csv", "groundtruth.csv"};
constexpr size_t kFiles = std::size(kNames);

// A folder whose files are links into memory; in the second one the truth is missing.
class Folder {
 public:
  Folder() : path_((fs::temp_directory_path() / "ch5-fuzz-XXXXXX").string()) {
    fuzz::Require(mkdtemp(path_.data()) != nullptr, "a temporary folder can be made");
    for (const char* folder : {"with", "without"}) {
      fs::create_directory(fs::path(path_) / folder);
      for (size_t k = 0; k < (folder[4] ? 3 : kFiles); ++k) {
        fs::create_symlink(files_[k].Path(), fs::path(path_) / folder / kNames[k]);
      }
    }
  }
  ~Folder() { fs::remove_all(path_); }

  // Fills the files; returns the folder to read.
  fs::path Set(std::string_view text) const {
    constexpr std::string_view kSeparator = "\n%%\n";
    size_t count = 0;
    for (; count < kFiles; ++count) {
      const size_t end = count + 1 < kFiles ? text.find(kSeparator) : std::string_view::npos;
      files_[count].Set(text.substr(0, end));
      text.remove_prefix(end == std::string_view::npos ? text.size() : end + kSeparator.size());
      if (end == std::string_view::npos) break;
    }
    const bool has_truth = count + 1 == kFiles;
    for (size_t k = count + 1; k < kFiles; ++k) files_[k].Set("");
    return fs::path(path_) / (has_truth ? "with" : "without");
  }

 private:
  fuzz::MemoryFile files_[kFiles];
  std::string path_;
};

template <typename T>
void RequireOrder(const std::vector<T>& list) {
  for (size_t k = 1; k < list.size(); ++k) fuzz::Require(list[k - 1].t < list[k].t, "times increase");
}

void Check(const Recording& recording) {
  fuzz::Require(recording.imu.size() >= 2 && !recording.images.empty(), "there is something to follow");
  RequireOrder(recording.imu);
  RequireOrder(recording.images);
  RequireOrder(recording.truth);
  const Calibration& c = recording.calibration;
  fuzz::Require(std::abs(c.T_B_C.q.norm() - 1.0) < 1e-12, "the camera's rotation is of length 1");
  fuzz::Require(c.fx > 0.0 && c.fy > 0.0 && c.width > 0 && c.height > 0, "the camera has an image");
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  static const Folder folder;
  const fs::path path = folder.Set(fuzz::Text(data, size));
  try {
    Check(ReadRecording(path));
  } catch (const FileError&) {
  }
  return 0;
}
