#include "ch5_backend/track/track_images.h"

#include <algorithm>
#include <ctime>
#include <set>

#include <opencv2/core/utility.hpp>

#include "ch5_backend/files/text_reader.h"
#include "ch5_backend/track/image_file.h"
#include "ch5_backend/track/stereo_match.h"
#include "ch5_backend/types/inertial/preintegration.h"

namespace ch5 {
namespace {

// R_C1_C0 by the gyroscope, without its bias: what it turned from t0 to t1.
Qd RotationBetween(const Recording& recording, double t0, double t1) {
  const std::vector<ImuSample> samples = SamplesBetween(recording.imu, t0, t1);
  if (samples.empty()) return Qd::Identity();
  const Preintegration imu(samples, Vec3::Zero(), Vec3::Zero(), recording.calibration.noise);
  const Qd& R_B_C = recording.calibration.T_B_C.q;
  return (R_B_C.conjugate() * imu.Gamma() * R_B_C).conjugate();
}

cv::Mat ReadImage(const std::filesystem::path& path, const Camera& camera) {
  const cv::Mat gray = ReadGray(path);
  if (gray.cols == camera.width && gray.rows == camera.height) return gray;
  const auto size = [](int width, int height) { return std::to_string(width) + " × " + std::to_string(height); };
  throw FileError(path.string() + ": an image of " + size(gray.cols, gray.rows) + " pixels, but its calibration says " +
                  size(camera.width, camera.height));
}

}  // namespace

TrackedRecording TrackImages(const EurocFolder& folder, const TrackerOptions& options,
                             const std::function<void(double)>& progress, std::vector<LeftOut>* left_out) {
  const std::clock_t begin = std::clock();
  cv::setNumThreads(1);
  TrackedRecording result{folder.recording};
  const Calibration& calibration = folder.recording.calibration;
  Tracker tracker(calibration, folder.lens, options);
  std::optional<StereoMatcher> matcher;
  if (calibration.camera1) matcher.emplace(calibration, folder.lens1, options);
  std::set<int> ids;
  size_t observations = 0;
  double last = folder.images.front().t;
  auto next = folder.images.begin();
  ReadEach("images", left_out, [&] {
    if (next == folder.images.end()) return false;
    const ImageFile& image = *next++;
    if (image.t - last > 5.0 / calibration.camera_rate) tracker.Forget();
    const cv::Mat gray = ReadImage(image.path, calibration);
    result.recording.images.push_back({image.t, tracker.Track(gray, RotationBetween(folder.recording, last, image.t))});
    if (matcher && !image.path1.empty()) {
      result.recording.images.back().tracks1 = matcher->Match(tracker, ReadImage(image.path1, *calibration.camera1));
    }
    for (const TrackedPoint& track : result.recording.images.back().tracks) ids.insert(track.id);
    observations += result.recording.images.back().tracks.size();
    last = image.t;
    if (progress) {
      progress(static_cast<double>(result.recording.images.size()) / static_cast<double>(folder.images.size()));
    }
    return true;
  });
  result.mean_length = static_cast<double>(observations) / static_cast<double>(std::max<size_t>(ids.size(), 1));
  result.seconds = static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC;
  return result;
}

}  // namespace ch5
