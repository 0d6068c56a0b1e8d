#pragma once
/// Where camera 1 sees the corners of camera 0, in its image of the same time.
///
///   predict   on the epipolar line, at the depth at which the corner was seen last, or the others are; then at others
///   follow    pyramidal Lucas–Kanade from camera 0's image to camera 1's, and back
///   check     the essential matrix of the two known places: near the epipolar line, in front of both cameras
///
/// With f = [x₀, 1], R = R_C1_C0, t = t_C1_C0 and the inverse depth w, x₁ is seen where
///
///   S (R f + w t) = 0,   S = [1 0 −u₁; 0 1 −v₁]:   two equations in w; what they leave is the distance from the line

#include <functional>
#include <map>

#include "ch5_backend/track/tracker.h"

namespace ch5 {

class StereoMatcher {
 public:
  /// @param calibration  with camera1
  /// @param lens1        of camera 1
  StereoMatcher(const Calibration& calibration, const Lens& lens1, const TrackerOptions& options = {});

  /// @param tracker  has just been given camera 0's image of the same time
  /// @param gray1    8 bits a pixel, of camera 1's size
  /// @return the corners that both see, under their ids, on camera 1's plane z = 1
  std::vector<TrackedPoint> Match(const Tracker& tracker, const cv::Mat& gray1);

 private:
  // Looks at one depth for each corner. @return those that are not found there
  std::vector<const Tracker::Corner*> LookFor(const std::vector<const Tracker::Corner*>& corners,
                                              const std::function<double(int)>& inverse_depth_of,
                                              const std::vector<cv::Mat>& pyramid0,
                                              const std::vector<cv::Mat>& pyramid1, std::vector<TrackedPoint>* seen);
  std::optional<TrackedPoint> Check(const Tracker::Corner& corner, const cv::Point2f& pixel);

  Camera camera_;
  Lens lens_;
  Transform T_C1_C0_;
  TrackerOptions options_;
  std::map<int, double> inverse_depths_;  ///< of the last image's corners, by id [1/m]
};

}  // namespace ch5
