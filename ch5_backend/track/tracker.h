#pragma once
/// The front end: corners that are followed from image to image.
///
///   predict   each corner turns as the gyroscope says
///   follow    pyramidal Lucas–Kanade, there and back (Bouguet 2001)
///   check     one essential matrix for all, by RANSAC on eight rays (Longuet-Higgins 1981)
///   refill    new corners where there are none (Shi & Tomasi 1994)

#include <optional>
#include <random>
#include <vector>

#include <opencv2/core/mat.hpp>

#include "ch5_backend/track/lens.h"
#include "ch5_backend/types/recording.h"

namespace ch5 {

struct TrackerOptions {
  int max_tracks = 150;         ///< in an image
  double min_distance = 25.0;   ///< between corners [px]
  double max_round_trip = 0.5;  ///< of a corner followed there and back [px]
  double max_epipolar = 1.0;    ///< from the epipolar plane [px]
  double max_stereo = 1.5;      ///< in camera 1, from the epipolar line of its known place [px]
};

constexpr int kLevels = 3;

/// The image with a contrast that is the same in bright and dark parts.
cv::Mat Equalize(const cv::Mat& gray);
/// Its levels, for FollowThereAndBack.
/// @param image  of Equalize
std::vector<cv::Mat> MakePyramid(const cv::Mat& image);

/// Follows points by pyramidal Lucas–Kanade from one image to another, and from there back.
/// @param levels  of the pyramids, above the images themselves, up to kLevels: each doubles how far a point may be from there
/// @param to      where they are looked for first; on return, where they are [px]
/// @return which are found, and come back to less than `max_round_trip` from where they were [px]
std::vector<bool> FollowThereAndBack(const std::vector<cv::Mat>& pyramid0, const std::vector<cv::Mat>& pyramid1,
                                     const std::vector<cv::Point2f>& from, int levels, double max_round_trip,
                                     std::vector<cv::Point2f>* to);

/// Between pixels of a camera with a lens and the plane z = 1. Nullopt where there is no such ray, or outside the image.
std::optional<Vec2> RayOf(const cv::Point2f& pixel, const Camera& camera, const Lens& lens);
std::optional<cv::Point2f> PixelOf(const Vec2& x, const Camera& camera, const Lens& lens);
/// The part of the image in which a patch about a point lies mostly inside.
cv::Rect2f Inside(const Camera& camera);

class Tracker {
 public:
  struct Corner {
    int id;
    cv::Point2f pixel;
    Vec2 x;  ///< its place on the plane z = 1
  };

  Tracker(const Calibration& calibration, const Lens& lens, const TrackerOptions& options = {})
      : calibration_(calibration), lens_(lens), options_(options) {}

  /// Follows the last image's corners into this one, and adds new ones.
  /// @param gray    8 bits a pixel, of the calibration's size
  /// @param R_C1_C0 turns rays of the last image into this one's; only a prediction
  /// @return the corners on the plane z = 1; a corner keeps its id while it is followed
  std::vector<TrackedPoint> Track(const cv::Mat& gray, const Qd& R_C1_C0);
  /// Ends all tracks.
  void Forget() { corners_.clear(); }
  /// Of the last image: the corners, the oldest first, and its levels.
  const std::vector<Corner>& Corners() const { return corners_; }
  const std::vector<cv::Mat>& Pyramid() const { return pyramid_; }

 private:
  std::vector<Corner> Follow(const std::vector<cv::Mat>& pyramid, const Qd& R_C1_C0);
  void AddCorners();

  Calibration calibration_;
  Lens lens_;
  TrackerOptions options_;
  std::vector<cv::Mat> pyramid_;  ///< of the last image
  std::vector<Corner> corners_;   ///< the oldest first
  int next_id_ = 0;
  std::mt19937 random_;
};

/// Which of the pairs agree with one essential matrix: f1ᵀ E f0 = 0.
/// @param f0, f1      unit rays of the same points in two images, as many each; fewer than 12 are all taken for good
/// @param max_angle   of a ray from its epipolar plane [rad]
std::vector<bool> EssentialInliers(const std::vector<Vec3>& f0, const std::vector<Vec3>& f1, double max_angle,
                                   std::mt19937* random);

}  // namespace ch5
