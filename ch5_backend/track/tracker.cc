#include "ch5_backend/track/tracker.h"

#include <algorithm>

#include <opencv2/imgproc.hpp>
#include <opencv2/video/tracking.hpp>

namespace ch5 {
namespace {

const cv::Size kPatch(21, 21);
constexpr double kQuality = 0.01;  // of a corner, times the image's best
constexpr float kBorder = 5.0f;    // nearer to the image's edge a patch lacks too much [px]
constexpr int kWide = 800;         // corners of wider images are found in the first level that is not [px]

struct Candidate {
  double strength;
  cv::Point pixel;
};

// Of one row: ∇I ∇Iᵀ, each entry summed over three columns.
struct Products {
  Eigen::ArrayXf xx, xy, yy;
};

Products ProductsOfRow(const cv::Mat& gradient, int y) {
  const Eigen::Map<const Eigen::Array<int16_t, 2, Eigen::Dynamic>> g(gradient.ptr<int16_t>(y), 2, gradient.cols);
  const Eigen::ArrayXf gx = g.row(0).cast<float>(), gy = g.row(1).cast<float>();
  const auto sum = [](const Eigen::ArrayXf& p) -> Eigen::ArrayXf {
    const Eigen::Index n = p.size() - 2;
    return p.head(n) + p.segment(1, n) + p.tail(n);
  };
  return {sum(gx * gx), sum(gx * gy), sum(gy * gy)};
}

// How much of a corner each pixel is: with H = [a b; b c] = Σ ∇I ∇Iᵀ over 3 × 3 pixels, H's lesser eigenvalue, here twice
// that: a + c − √((a − c)² + 4b²)  (Shi & Tomasi 1994).
cv::Mat StrengthsOf(const cv::Mat& gradient) {
  cv::Mat strengths = cv::Mat::zeros(gradient.size(), CV_32FC1);
  Products above = ProductsOfRow(gradient, 0), here = ProductsOfRow(gradient, 1);
  for (int y = 1; y + 1 < gradient.rows; ++y) {
    Products below = ProductsOfRow(gradient, y + 1);
    const Eigen::ArrayXf a = above.xx + here.xx + below.xx, b = above.xy + here.xy + below.xy,
                         c = above.yy + here.yy + below.yy;
    Eigen::Map<Eigen::ArrayXf>(strengths.ptr<float>(y) + 1, gradient.cols - 2) =
        a + c - ((a - c).square() + 4.0f * b.square()).sqrt();
    above = std::move(here);
    here = std::move(below);
  }
  return strengths;
}

// The best pixel of each cell where `free` is 1, not 0, if none beside it is better; the strongest first.
std::vector<Candidate> BestOfCells(const cv::Mat& strengths, const cv::Mat& free, int cell) {
  std::vector<Candidate> best;
  for (int v = 1; v + 1 < strengths.rows; v += cell) {
    for (int u = 1; u + 1 < strengths.cols; u += cell) {
      const cv::Rect part(u, v, std::min(cell, strengths.cols - 1 - u), std::min(cell, strengths.rows - 1 - v));
      double most = 0.0, beside = 0.0;
      cv::Point at;
      cv::minMaxLoc(strengths(part), nullptr, &most, nullptr, &at, free(part));
      if (most <= 0.0) continue;
      at += part.tl();
      cv::minMaxLoc(strengths(cv::Rect(at.x - 1, at.y - 1, 3, 3)), nullptr, &beside);
      if (beside == most) best.push_back({most, at});
    }
  }
  std::stable_sort(best.begin(), best.end(), [](const auto& p, const auto& q) { return p.strength > q.strength; });
  return best;
}

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
  std::vector<cv::Mat> pyramid = MakePyramid(Equalize(gray));
  corners_ = corners_.empty() ? corners_ : Follow(pyramid, R_C1_C0);
  pyramid_ = std::move(pyramid);
  AddCorners();
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
void Tracker::AddCorners() {
  int level = 0;
  while (level < kLevels && calibration_.width >> level > kWide) ++level;
  const cv::Mat& gradient = pyramid_[2 * level + 1];
  const float scale = 1.0f / static_cast<float>(1 << level);
  const auto distance = static_cast<int>(scale * options_.min_distance);
  cv::Mat free(gradient.size(), CV_8UC1, cv::Scalar(1));
  const auto take = [&](const cv::Point& pixel) {
    if (free.at<uchar>(pixel) == 0) return false;
    cv::circle(free, pixel, distance, cv::Scalar(0), cv::FILLED);
    return true;
  };
  const auto crowded = [&](const Corner& corner) { return !take(scale * corner.pixel); };
  corners_.erase(std::remove_if(corners_.begin(), corners_.end(), crowded), corners_.end());
  if (corners_.size() >= static_cast<size_t>(options_.max_tracks)) return;
  // In a cell so small one corner keeps all others away.
  const auto candidates = BestOfCells(StrengthsOf(gradient), free, std::max(1, 2 * distance / 3));
  for (const auto& [strength, at] : candidates) {
    if (corners_.size() >= static_cast<size_t>(options_.max_tracks)) return;
    if (strength < kQuality * candidates.front().strength) return;
    if (!take(at)) continue;
    const cv::Point2f pixel = cv::Point2f(at) / scale;
    if (const std::optional<Vec2> x = RayOf(pixel, calibration_, lens_)) corners_.push_back({next_id_++, pixel, *x});
  }
}

}  // namespace ch5
