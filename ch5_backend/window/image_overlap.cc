#include "ch5_backend/window/image_overlap.h"

#include <algorithm>
#include <cmath>

namespace ch5 {

// Andrew's monotone chain: the lower hull from left to right, then the upper one back; the area by the shoelace formula.
double HullArea(Array<Vec2> points) {
  if (points.size() < 3) return 0.0;
  std::sort(points.begin(), points.end(),
            [](const Vec2& a, const Vec2& b) { return a.x() < b.x() || (a.x() == b.x() && a.y() < b.y()); });
  const auto cross = [](const Vec2& a, const Vec2& b) { return a.x() * b.y() - a.y() * b.x(); };
  Array<Vec2> hull;
  for (int side = 0; side < 2; ++side) {
    const size_t begin = hull.size();
    for (const Vec2& p : points) {
      while (hull.size() >= begin + 2 && cross(hull.back() - hull[hull.size() - 2], p - hull.back()) <= 0.0) {
        hull.pop_back();
      }
      hull.push_back(p);
    }
    hull.pop_back();  // the other side begins with this point
    std::reverse(points.begin(), points.end());
  }
  double twice = 0.0;
  for (size_t i = 0; i < hull.size(); ++i) twice += cross(hull[i], hull[(i + 1) % hull.size()]);
  return 0.5 * twice;
}

ImageOverlap ImageOverlapOf(const Window& window, int older, int newer) {
  const auto camera = [&](int frame) { return window.frames[window.IndexOf(frame)].pose->q() * window.extrinsic->q(); };
  const Qd q_W_older = camera(older), q_W_newer = camera(newer);
  Array<Vec2> all, matched;
  double angles = 0.0;
  for (const auto& [id, landmark] : window.landmarks) {
    const WindowObservation* now = landmark.In(newer);
    if (!now) continue;
    all.push_back(now->x);
    const WindowObservation* before = landmark.In(older);
    if (!before) continue;
    matched.push_back(now->x);
    const Vec3 u = q_W_older * before->x.homogeneous(), v = q_W_newer * now->x.homogeneous();
    angles += std::atan2(u.cross(v).norm(), u.dot(v));
  }
  if (all.empty()) return {};
  const double area = HullArea(all);
  return {area > 0.0 ? HullArea(matched) / area : 0.0,
          static_cast<double>(matched.size()) / static_cast<double>(all.size()),
          matched.empty() ? 0.0 : angles / static_cast<double>(matched.size())};
}

}  // namespace ch5
