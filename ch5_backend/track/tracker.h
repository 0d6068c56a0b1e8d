#pragma once
/// The front end: corners that are followed from image to image.
///
///   predict   each corner turns as the gyroscope says
///   follow    pyramidal Lucas–Kanade, there and back (Bouguet 2001)
///   check     one essential matrix for all, by RANSAC on eight rays (Longuet-Higgins 1981)
///   refill    new corners where there are none (Shi & Tomasi 1994)

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
};

class Tracker {
 public:
  Tracker(const Calibration& calibration, const Lens& lens, const TrackerOptions& options = {})
      : calibration_(calibration), lens_(lens), options_(options) {}

  /// Follows the last image's corners into this one, and adds new ones.
  /// @param gray    8 bits a pixel, of the calibration's size
  /// @param R_C1_C0 turns rays of the last image into this one's; only a prediction
  /// @return the corners on the plane z = 1; a corner keeps its id while it is followed
  std::vector<TrackedPoint> Track(const cv::Mat& gray, const Qd& R_C1_C0);
  /// Ends all tracks.
  void Forget() { corners_.clear(); }

 private:
  struct Corner {
    int id;
    cv::Point2f pixel;
    Vec2 x;  ///< its place on the plane z = 1
  };
  std::vector<Corner> Follow(const std::vector<cv::Mat>& pyramid, const Qd& R_C1_C0);
  void AddCorners(const cv::Mat& gray);
  std::optional<Vec2> Normalized(const cv::Point2f& pixel) const;
  std::optional<cv::Point2f> Pixel(const Vec2& x) const;

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
