#include "ch5_backend/track/stereo_match.h"

#include <algorithm>

#include "ch5_backend/math/median.h"

namespace ch5 {
namespace {

constexpr double kFirstInverseDepth = 0.2;     // before any is known [1/m]
constexpr double kLargestInverseDepth = 10.0;  // 0.1 m, the least depth that the estimators take
// Further disparities to look at [rad]. They are near to one another, since few levels are used: in a coarse one a patch
// holds so much of a slanted floor, whose disparity changes along it, that it leads away from the point.
constexpr double kGuesses[] = {0.0, 0.02, 0.04, 0.06, 0.08, 0.11, 0.14};
constexpr int kStereoLevels = 1;

double MedianInverseDepth(const std::map<int, double>& inverse_depths) {
  if (inverse_depths.empty()) return kFirstInverseDepth;
  std::vector<double> values;
  for (const auto& [id, value] : inverse_depths) values.push_back(value);
  return Median(std::move(values));
}

// The inverse depth at which x1 is nearest to its epipolar line.
struct OnEpipolarLine {
  double inverse_depth = 0.0;  // [1/m]
  double distance = 0.0;       // of x1 from the line, on the plane z = 1
};

OnEpipolarLine MeetEpipolarLine(const Transform& T_C1_C0, const Vec2& x0, const Vec2& x1) {
  const Vec3 Rf = T_C1_C0.q * x0.homogeneous();
  const Vec3& t = T_C1_C0.p;
  const Vec2 a = Rf.head<2>() - x1 * Rf.z(), b = t.head<2>() - x1 * t.z();
  const double w = -a.dot(b) / std::max(b.squaredNorm(), 1e-12);
  return {w, (a + w * b).norm() / std::max(Rf.z() + w * t.z(), 1e-3)};
}

}  // namespace

StereoMatcher::StereoMatcher(const Calibration& calibration, const Lens& lens1, const TrackerOptions& options)
    : camera_(*calibration.camera1), lens_(lens1), options_(options) {
  const Transform &T_B_C0 = calibration.T_B_C, &T_B_C1 = camera_.T_B_C;
  T_C1_C0_ = {T_B_C1.q.conjugate() * T_B_C0.q, T_B_C1.q.conjugate() * (T_B_C0.p - T_B_C1.p)};
}

std::vector<TrackedPoint> StereoMatcher::Match(const Tracker& tracker, const cv::Mat& gray1) {
  const std::vector<cv::Mat> pyramid1 = MakePyramid(Equalize(gray1));
  const std::map<int, double> before = std::move(inverse_depths_);
  inverse_depths_.clear();
  const double typical = MedianInverseDepth(before);
  std::vector<const Tracker::Corner*> missing;
  for (const Tracker::Corner& corner : tracker.Corners()) missing.push_back(&corner);
  std::vector<TrackedPoint> seen;
  const auto look = [&](const auto& inverse_depth_of) {
    missing = LookFor(missing, inverse_depth_of, tracker.Pyramid(), pyramid1, &seen);
  };
  look([&](int id) {
    const auto known = before.find(id);
    return known == before.end() ? typical : known->second;
  });
  const double base_line = std::max(T_C1_C0_.p.norm(), 1e-3);
  for (const double disparity : kGuesses) look([=](int) { return disparity / base_line; });
  return seen;
}

std::vector<const Tracker::Corner*> StereoMatcher::LookFor(const std::vector<const Tracker::Corner*>& corners,
                                                           const std::function<double(int)>& inverse_depth_of,
                                                           const std::vector<cv::Mat>& pyramid0,
                                                           const std::vector<cv::Mat>& pyramid1,
                                                           std::vector<TrackedPoint>* seen) {
  std::vector<const Tracker::Corner*> tried, missing;
  std::vector<cv::Point2f> from, to;
  for (const Tracker::Corner* corner : corners) {
    const Vec3 ray = T_C1_C0_.q * corner->x.homogeneous() + inverse_depth_of(corner->id) * T_C1_C0_.p;
    const std::optional<cv::Point2f> predicted =
        ray.z() > 0.1 ? PixelOf(ray.hnormalized(), camera_, lens_) : std::nullopt;
    if (!predicted) {
      missing.push_back(corner);
      continue;
    }
    tried.push_back(corner);
    from.push_back(corner->pixel);
    to.push_back(*predicted);
  }
  const std::vector<bool> found =
      FollowThereAndBack(pyramid0, pyramid1, from, kStereoLevels, options_.max_round_trip, &to);
  for (size_t i = 0; i < tried.size(); ++i) {
    const auto point = found[i] ? Check(*tried[i], to[i]) : std::nullopt;
    if (point) {
      seen->push_back(*point);
    } else {
      missing.push_back(tried[i]);
    }
  }
  return missing;
}

std::optional<TrackedPoint> StereoMatcher::Check(const Tracker::Corner& corner, const cv::Point2f& pixel) {
  if (!Inside(camera_).contains(pixel)) return std::nullopt;
  const std::optional<Vec2> x1 = RayOf(pixel, camera_, lens_);
  if (!x1) return std::nullopt;
  const auto [w, distance] = MeetEpipolarLine(T_C1_C0_, corner.x, *x1);
  const double tolerance = options_.max_stereo / camera_.FocalLength();
  const double least = -tolerance / std::max(T_C1_C0_.p.norm(), 1e-3);  // by the noise of what is far
  if (distance > tolerance || w < least || w > kLargestInverseDepth) return std::nullopt;
  inverse_depths_[corner.id] = std::max(w, 0.0);
  return TrackedPoint{corner.id, *x1};
}

}  // namespace ch5
