#include "ch5_backend/track/tracker.h"

#include <opencv2/imgproc.hpp>
#include <opencv2/video/tracking.hpp>

namespace ch5 {
namespace {

const cv::Size kPatch(21, 21);
constexpr double kQuality = 0.01;  // of a corner, times the image's best
constexpr float kBorder = 5.0f;    // nearer to the image's edge a patch lacks too much [px]

}  // namespace

cv::Mat Equalize(const cv::Mat& gray) {
  cv::Mat equal;
  cv::createCLAHE(3.0, {8, 8})->apply(gray, equal);
  return equal;
}

std::vector<cv::Mat> MakePyramid(const cv::Mat& image) {
  std::vector<cv::Mat> pyramid;
  cv::buildOpticalFlowPyramid(image, pyramid, kPatch, kLevels);
  return pyramid;
}

std::vector<bool> FollowThereAndBack(const std::vector<cv::Mat>& pyramid0, const std::vector<cv::Mat>& pyramid1,
                                     const std::vector<cv::Point2f>& from, int levels, double max_round_trip,
                                     std::vector<cv::Point2f>* to) {
  if (from.empty()) return {};
  std::vector<cv::Point2f> back = from;
  std::vector<uchar> found, found_back;
  const cv::TermCriteria stop(cv::TermCriteria::COUNT + cv::TermCriteria::EPS, 30, 0.01);
  const auto follow = [&](const auto& first, const auto& second, const auto& p0, auto* p1, auto* ok) {
    cv::calcOpticalFlowPyrLK(first, second, p0, *p1, *ok, cv::noArray(), kPatch, levels, stop,
                             cv::OPTFLOW_USE_INITIAL_FLOW);
  };
  follow(pyramid0, pyramid1, from, to, &found);
  follow(pyramid1, pyramid0, *to, &back, &found_back);
  std::vector<bool> good(from.size());
  for (size_t i = 0; i < from.size(); ++i) {
    good[i] = found[i] && found_back[i] && !(cv::norm(back[i] - from[i]) > max_round_trip);
  }
  return good;
}

std::optional<Vec2> RayOf(const cv::Point2f& pixel, const Camera& camera, const Lens& lens) {
  return lens.Undistort(camera.Normalized({pixel.x, pixel.y}));
}

std::optional<cv::Point2f> PixelOf(const Vec2& x, const Camera& camera, const Lens& lens) {
  const Vec2 pixel = camera.Pixel(lens.Distort(x));
  if (!camera.Contains(pixel)) return std::nullopt;
  return cv::Point2f(static_cast<float>(pixel.x()), static_cast<float>(pixel.y()));
}

cv::Rect2f Inside(const Camera& camera) {
  return {kBorder, kBorder, static_cast<float>(camera.width) - 2 * kBorder,
          static_cast<float>(camera.height) - 2 * kBorder};
}

std::vector<TrackedPoint> Tracker::Track(const cv::Mat& gray, const Qd& R_C1_C0) {
  const cv::Mat image = Equalize(gray);
  std::vector<cv::Mat> pyramid = MakePyramid(image);
  corners_ = corners_.empty() ? corners_ : Follow(pyramid, R_C1_C0);
  pyramid_ = std::move(pyramid);
  AddCorners(image);
  std::vector<TrackedPoint> tracks;
  for (const Corner& corner : corners_) tracks.push_back({corner.id, corner.x});
  return tracks;
}

std::vector<Tracker::Corner> Tracker::Follow(const std::vector<cv::Mat>& pyramid, const Qd& R_C1_C0) {
  std::vector<cv::Point2f> from, to;
  for (const Corner& corner : corners_) {
    from.push_back(corner.pixel);
    const Vec3 ray = R_C1_C0 * corner.x.homogeneous();
    const std::optional<cv::Point2f> predicted =
        ray.z() > 0.1 ? PixelOf(ray.hnormalized(), calibration_, lens_) : std::nullopt;
    to.push_back(predicted.value_or(corner.pixel));
  }
  const std::vector<bool> found = FollowThereAndBack(pyramid_, pyramid, from, kLevels, options_.max_round_trip, &to);

  std::vector<Corner> followed;
  std::vector<Vec3> f0, f1;
  const cv::Rect2f inside = Inside(calibration_);
  for (size_t i = 0; i < from.size(); ++i) {
    if (!found[i] || !inside.contains(to[i])) continue;
    const std::optional<Vec2> x = RayOf(to[i], calibration_, lens_);
    if (!x) continue;
    followed.push_back({corners_[i].id, to[i], *x});
    f0.push_back(corners_[i].x.homogeneous().normalized());
    f1.push_back(x->homogeneous().normalized());
  }
  const std::vector<bool> good = EssentialInliers(f0, f1, options_.max_epipolar / calibration_.FocalLength(), &random_);
  size_t kept = 0;
  for (size_t i = 0; i < followed.size(); ++i) {
    if (good[i]) followed[kept++] = followed[i];
  }
  followed.resize(kept);
  return followed;
}

// Where two have come close, the older one stays.
void Tracker::AddCorners(const cv::Mat& image) {
  cv::Mat mask(image.size(), CV_8UC1, cv::Scalar(255));
  std::vector<Corner> apart;
  for (const Corner& corner : corners_) {
    if (mask.at<uchar>(corner.pixel) == 0) continue;
    apart.push_back(corner);
    cv::circle(mask, corner.pixel, static_cast<int>(options_.min_distance), cv::Scalar(0), cv::FILLED);
  }
  corners_ = std::move(apart);
  const int missing = options_.max_tracks - static_cast<int>(corners_.size());
  if (missing <= 0) return;
  std::vector<cv::Point2f> found;
  cv::goodFeaturesToTrack(image, found, missing, kQuality, options_.min_distance, mask);
  for (const cv::Point2f& pixel : found) {
    if (const std::optional<Vec2> x = RayOf(pixel, calibration_, lens_)) corners_.push_back({next_id_++, pixel, *x});
  }
}

}  // namespace ch5
