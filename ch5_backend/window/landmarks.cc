#include "ch5_backend/window/landmarks.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <set>

#include "ch5_backend/math/array_memory.h"
#include "ch5_backend/math/median.h"
#include "ch5_backend/math/transform.h"

namespace ch5 {
namespace {

// An observation is a false match if its error is this many times the largest mean error of a landmark. With 3 px that
// is 90 px: a smaller error may as well come from a poor depth, and then the landmark is removed.
constexpr double kFalseMatch = 30.0;

// Errors that most landmarks have are noise of the images: a landmark goes beyond so many times their median error. Beyond so
// many times `max_error` images and IMU contradict each other.
constexpr double kTimesMedian = 2.0, kMostNoise = 3.0;

// T_W_C of a frame.
Transform CameraOf(const Window& window, int frame, const Transform& T_B_C) {
  const VertexPose& pose = *window.frames.at(static_cast<size_t>(window.IndexOf(frame))).pose;
  return Transform{pose.q(), pose.p()} * T_B_C;
}
Transform CameraOf(const Window& window, int frame) { return CameraOf(window, frame, window.T_B_C()); }

// T_W_C of one frame.
struct View {
  Mat33 R_C_W;
  Vec3 p_W_C;

  explicit View(const Transform& T_W_C) : R_C_W(T_W_C.q.conjugate().toRotationMatrix()), p_W_C(T_W_C.p) {}
  Vec3 ToCamera(const Vec3& p_W) const { return R_C_W * (p_W - p_W_C); }
  Vec3 ToWorld(const Vec3& p_C) const { return R_C_W.transpose() * p_C + p_W_C; }
  double ReprojectionError(const Vec3& p_W, const Vec2& x) const { return (ToCamera(p_W).hnormalized() - x).norm(); }
};

// A landmark's reprojection errors on the normalized plane.
struct Errors {
  double mean = 0.0, largest = 0.0;
};

// The views of all frames, found once for many landmarks.
class Views {
 public:
  explicit Views(const Window& window) : window_(window) {
    const double td = window.time_offset->GetEstimate()[0];
    for (const Frame& frame : window.frames) {
      views_.emplace_back(CameraOf(window, frame.id));
      delays_.push_back(td - frame.clock_offset);
      if (window.extrinsic1) views1_.emplace_back(CameraOf(window, frame.id, window.T_B_C1()));
    }
  }

  // Calls call(view, x) for each image of a landmark, camera 0's before camera 1's of the same time.
  template <typename Call>
  void ForEach(const WindowLandmark& landmark, const Call& call) const {
    size_t k = 0;  // both are in order of time
    for (const WindowObservation& seen : landmark.seen) {
      while (window_.frames[k].id != seen.frame) ++k;
      call(views_[k], Vec2(seen.x - delays_[k] * seen.velocity));  // as Window::PointOf
      if (seen.second) call(views1_[k], Vec2(seen.second->x - delays_[k] * seen.second->velocity));
    }
  }

  Vec3 InWorld(const WindowLandmark& landmark) const {
    const WindowObservation& host = landmark.seen.front();
    return views_[IndexOf(host)].ToWorld(PointOf(host).homogeneous() / landmark.inverse_depth->InverseDepth());
  }

  double ErrorOf(const WindowObservation& seen, const WindowLandmark& landmark) const {
    return views_[IndexOf(seen)].ReprojectionError(InWorld(landmark), PointOf(seen));
  }

  // Over all observations but the host's, whose error is zero.
  Errors ErrorsOf(const WindowLandmark& landmark) const {
    const Vec3 p_W = InWorld(landmark);
    Errors errors;
    int views = 0;
    ForEach(landmark, [&](const View& view, const Vec2& x) {
      const double error = view.ReprojectionError(p_W, x);
      errors.mean += error;
      errors.largest = std::max(errors.largest, error);
      ++views;
    });
    errors.mean /= static_cast<double>(views - 1);
    return errors;
  }

 private:
  size_t IndexOf(const WindowObservation& seen) const { return static_cast<size_t>(window_.IndexOf(seen.frame)); }
  Vec2 PointOf(const WindowObservation& seen) const { return seen.x - delays_[IndexOf(seen)] * seen.velocity; }

  const Window& window_;
  Array<View> views_, views1_;
  Array<double> delays_;  // td − td_k
};

// Removes what camera 1 sees of a landmark: its point there is another.
void ForgetSecondViews(Window* window, WindowLandmark* landmark) {
  for (const auto& edge : EdgesAt(window->graph, {landmark->inverse_depth})) {
    const auto& vertices = edge->Vertices();
    if (std::find(vertices.begin(), vertices.end(), window->extrinsic1) != vertices.end())
      window->graph.RemoveEdge(edge);
  }
  for (WindowObservation& seen : landmark->seen) seen.second.reset();
}

// Whether what the image before the newest saw of it has been removed as a false match.
bool LacksThePrevious(const Window& window, const WindowLandmark& landmark) {
  const auto& recent = landmark.recent.points;
  if (recent.size() < 2) return false;
  const int previous = recent[recent.size() - 2].frame;
  return window.IndexOf(previous) >= 0 && !landmark.In(previous);
}

// Removes false matches where at least half of the observations fit. If the previous one was removed too, the track has
// jumped to another point, and is kept.
void RemoveFalseMatches(double max_error, const Views& views, Window* window, WindowLandmark* landmark) {
  auto& seen = landmark->seen;
  if (seen.size() < 3 || LacksThePrevious(*window, *landmark)) return;
  const auto error = [&](const WindowObservation& one) { return views.ErrorOf(one, *landmark); };
  const auto fitting =
      std::count_if(seen.begin() + 1, seen.end(), [&](const auto& one) { return error(one) < max_error; });
  if (2 * fitting < static_cast<std::ptrdiff_t>(seen.size()) - 1) return;
  const auto is_false = [&](const WindowObservation& one) { return error(one) > kFalseMatch * max_error; };
  for (auto one = seen.begin() + 1; (one = std::find_if(one, seen.end(), is_false)) != seen.end();
       one = seen.erase(one)) {
    const auto pose = window->frames[static_cast<size_t>(window->IndexOf(one->frame))].pose;
    for (const auto& edge : EdgesAt(window->graph, {landmark->inverse_depth})) {
      if (edge->Vertices()[2] == pose) window->graph.RemoveEdge(edge);
    }
  }
}

// They are removed from the graph too.
template <typename Predicate>
void EraseIf(Window* window, const Predicate& predicate) {
  std::vector<std::shared_ptr<Vertex>> erased;
  for (auto it = window->landmarks.begin(); it != window->landmarks.end();) {
    if (!predicate(it->second)) {
      ++it;
      continue;
    }
    const auto& vertex = it->second.inverse_depth;
    if (vertex && window->graph.Contains(*vertex)) erased.push_back(vertex);
    it = window->landmarks.erase(it);
  }
  window->graph.RemoveVertices(erased);
}

// Makes the second observation the host's. The point keeps its position in the world if it lies in front.
void ChangeHost(const std::function<double(const Transform&, const Vec3&)>& depth_in, const Window& window,
                WindowLandmark* landmark) {
  if (landmark->inverse_depth) {
    const double depth = depth_in(CameraOf(window, landmark->seen[1].frame), LandmarkInWorld(window, *landmark));
    landmark->inverse_depth =
        MakeShared<VertexInverseDepth>(1.0 / (depth > 0.0 && std::isfinite(depth) ? depth : kInitialDepth));
  }
  landmark->seen.erase(landmark->seen.begin());
}

}  // namespace

// Each view gives  x × (R_C_C0 p + t_C_C0) = 0,  two rows in the homogeneous point of the host's camera C0.
double TriangulateDepth(const Window& window, const WindowLandmark& landmark) {
  const Transform T_W_C0 = CameraOf(window, landmark.Host());
  Eigen::Matrix4d AtA = Eigen::Matrix4d::Zero();
  const auto add = [&](const Transform& T_W_C, const Vec2& x) {
    Eigen::Matrix<double, 3, 4> P;
    P << (T_W_C.q.conjugate() * T_W_C0.q).toRotationMatrix(), T_W_C.q.conjugate() * (T_W_C0.p - T_W_C.p);
    const Vec3 ray = x.homogeneous().normalized();
    for (int row = 0; row < 2; ++row) {
      const Eigen::Matrix<double, 1, 4> a = ray[row] * P.row(2) - ray[2] * P.row(row);
      AtA += a.transpose() * a;
    }
  };
  for (const WindowObservation& seen : landmark.seen) {
    add(CameraOf(window, seen.frame), window.PointOf(seen));
    if (!seen.second || !window.HasStereoDepth()) continue;
    add(CameraOf(window, seen.frame, window.T_B_C1()),
        window.PointAt(seen.frame, seen.second->x, seen.second->velocity));
  }
  // The solver for matrices of any size is compiled once for all files (math/precompiled.h); it keeps its memory.
  thread_local MatXX A(4, 4);
  thread_local Eigen::SelfAdjointEigenSolver<MatXX> solver(4);
  A = AtA;
  const Eigen::Vector4d p = solver.compute(A).eigenvectors().col(0);
  const double depth = p.z() / p.w();
  return std::isfinite(depth) && depth >= kLeastDepth ? depth : kInitialDepth;
}

namespace {

// Adds a point to a track, and calls set(frame, ẋ) for those whose velocity has become another.
template <typename Set>
void UpdateVelocities(const RecentPoint& point, RecentTrack* track, const Set& set) {
  Array<RecentPoint>& last = track->points;
  if (last.size() == 3) last.erase(last.begin());
  last.push_back(point);
  ++track->images;
  const auto slope = [&](size_t a, size_t b) -> Vec2 { return (last[b].x - last[a].x) / (last[b].t - last[a].t); };
  if (last.size() == 2) {
    set(last[0].frame, slope(0, 1));
    set(last[1].frame, slope(0, 1));
  } else if (last.size() == 3) {
    if (track->images == 3) set(last[0].frame, slope(1, 2));  // the track's first image
    set(last[1].frame, slope(0, 2));
    set(last[2].frame, slope(0, 1));
  }
}

// Calls change(observation) for that of a frame, if it is still there.
template <typename Change>
void ChangeObservation(int frame, WindowLandmark* landmark, const Change& change) {
  for (auto seen = landmark->seen.rbegin(); seen != landmark->seen.rend() && seen->frame >= frame; ++seen) {
    if (seen->frame == frame) change(&*seen);
  }
}

}  // namespace

void AppendToTrack(const RecentPoint& point, WindowLandmark* landmark) {
  constexpr size_t kWindow = 12;  // frames: mostly all that it will need
  if (landmark->seen.empty()) landmark->seen.reserve(kWindow);
  landmark->seen.push_back({point.frame, point.x, Vec2::Zero()});
  UpdateVelocities(point, &landmark->recent, [&](int frame, const Vec2& velocity) {
    ChangeObservation(frame, landmark, [&](WindowObservation* seen) { seen->velocity = velocity; });
  });
}

void AppendSecondView(const RecentPoint& point, WindowLandmark* landmark) {
  if (landmark->seen.empty() || landmark->seen.back().frame != point.frame) return;
  landmark->seen.back().second = SecondView{point.x, Vec2::Zero()};
  UpdateVelocities(point, &landmark->recent1, [&](int frame, const Vec2& velocity) {
    ChangeObservation(frame, landmark, [&](WindowObservation* seen) {
      if (seen->second) seen->second->velocity = velocity;
    });
  });
}

void AppendImage(int frame, const Image& image, Window* window) {
  for (const TrackedPoint& point : image.tracks) {
    AppendToTrack({frame, image.t, point.x}, &window->landmarks[point.id]);
  }
  if (!window->extrinsic1) return;
  for (const TrackedPoint& point : image.tracks1) {
    const auto landmark = window->landmarks.find(point.id);
    if (landmark != window->landmarks.end()) AppendSecondView({frame, image.t, point.x}, &landmark->second);
  }
}

namespace {

// How a camera of the window moves at a frame's time, in its own axes.
class CameraMotion {
 public:
  CameraMotion(const Transform& T_W_B, const Vec3& v_W, const Vec3& omega_B, const Transform& T_B_C)
      : T_C_W_(Inverse(T_W_B * T_B_C)),
        v_C_(T_B_C.q.conjugate() * (T_W_B.q.conjugate() * v_W + omega_B.cross(T_B_C.p))),
        omega_C_(T_B_C.q.conjugate() * omega_B) {}

  // ẋ of a point that stands still; nothing behind the camera or too near.
  std::optional<Vec2> VelocityOf(const Vec3& p_W) const {
    const Vec3 p_C = T_C_W_ * p_W, dp_C = -omega_C_.cross(p_C) - v_C_;
    if (!(p_C.z() >= kLeastDepth)) return std::nullopt;
    return Vec2((dp_C.head<2>() - p_C.hnormalized() * dp_C.z()) / p_C.z());
  }

 private:
  Transform T_C_W_;
  Vec3 v_C_, omega_C_;
};

// ω_B at the window's k-th frame, without its bias; nothing where there is no speed or no IMU.
std::optional<Vec3> AngularVelocity(const Window& window, size_t k) {
  const Frame& frame = window.frames[k];
  if (!frame.speed_bias) return std::nullopt;
  const Vec3 b_g = frame.speed_bias->b_g();
  if (frame.imu) return Vec3(frame.imu->Samples().back().gyroscope - b_g);
  if (k + 1 == window.frames.size() || !window.frames[k + 1].imu) return std::nullopt;
  return Vec3(window.frames[k + 1].imu->Samples().front().gyroscope - b_g);
}

}  // namespace

void SetVelocitiesByMotion(Window* window) {
  std::vector<std::optional<CameraMotion>> cameras(window->frames.size()), cameras1(window->frames.size());
  for (size_t k = 0; k < cameras.size(); ++k) {
    const Frame& frame = window->frames[k];
    const auto omega = AngularVelocity(*window, k);
    if (!omega) continue;
    const Transform T_W_B{frame.pose->q(), frame.pose->p()};
    cameras[k].emplace(T_W_B, frame.speed_bias->v(), *omega, window->T_B_C());
    if (window->extrinsic1) cameras1[k].emplace(T_W_B, frame.speed_bias->v(), *omega, window->T_B_C1());
  }
  const auto set = [](const std::optional<CameraMotion>& camera, const Vec3& p_W, Vec2* velocity) {
    if (camera) *velocity = camera->VelocityOf(p_W).value_or(*velocity);
  };
  for (auto& [id, landmark] : window->landmarks) {
    if (!landmark.inverse_depth) continue;
    const Vec3 p_W = LandmarkInWorld(*window, landmark);
    for (WindowObservation& seen : landmark.seen) {
      const auto k = static_cast<size_t>(window->IndexOf(seen.frame));
      set(cameras[k], p_W, &seen.velocity);
      if (seen.second) set(cameras1[k], p_W, &seen.second->velocity);
    }
  }
}

void ReplaceNewestImage(const Image& image, Window* window) {
  const int frame = window->frames.back().id;
  std::set<int> seen_now;
  for (const TrackedPoint& point : image.tracks) seen_now.insert(point.id);
  for (auto it = window->landmarks.begin(); it != window->landmarks.end();) {
    auto& [id, landmark] = *it;
    const bool goes_on = seen_now.count(id) > 0;
    if (goes_on && landmark.seen.back().frame == frame) landmark.seen.pop_back();
    it = !goes_on && landmark.Host() == frame ? window->landmarks.erase(it) : std::next(it);
  }
  AppendImage(frame, image, window);
}

void TriangulateLandmarks(Window* window) {
  for (auto& [id, landmark] : window->landmarks) {
    const bool has_two_views =
        landmark.seen.size() >= 2 || (window->HasStereoDepth() && landmark.seen.front().second.has_value());
    if (landmark.inverse_depth || !has_two_views) continue;
    landmark.inverse_depth = MakeShared<VertexInverseDepth>(1.0 / TriangulateDepth(*window, landmark));
  }
}

Vec3 LandmarkInWorld(const Window& window, const WindowLandmark& landmark) {
  const Transform T_W_C = CameraOf(window, landmark.Host());
  const Vec3 p_C = window.PointOf(landmark.seen.front()).homogeneous() / landmark.inverse_depth->InverseDepth();
  return T_W_C * p_C;
}

void ForgetObservations(int frame, const std::function<double(const Transform& T_W_C, const Vec3& p_W)>& depth_in,
                        Window* window) {
  EraseIf(window, [&](WindowLandmark& landmark) {
    const WindowObservation* seen = landmark.In(frame);
    if (!seen) return false;
    if (landmark.Host() != frame) {
      landmark.seen.erase(landmark.seen.begin() + (seen - landmark.seen.data()));
      return false;
    }
    const size_t left = landmark.seen.size() - 1;
    if (left == 0 || (left == 1 && landmark.inverse_depth)) return true;
    ChangeHost(depth_in, *window, &landmark);
    return false;
  });
}

namespace {

bool HasFailed(const WindowLandmark& landmark) {
  return landmark.inverse_depth && !(landmark.inverse_depth->InverseDepth() > 0.0);
}

}  // namespace

void RemoveFailures(Window* window) { EraseIf(window, HasFailed); }

namespace {

bool HasError(const WindowLandmark& landmark) {
  return landmark.inverse_depth && landmark.seen.size() >= 2 && !HasFailed(landmark);
}

// For landmarks that have one, in the order of the window's landmarks.
Array<Errors> ErrorsOfLandmarks(const Views& views, const Window& window) {
  Array<Errors> errors;
  errors.reserve(window.landmarks.size());
  for (const auto& [id, landmark] : window.landmarks) {
    if (HasError(landmark)) errors.push_back(views.ErrorsOf(landmark));
  }
  return errors;
}

double LargestMeanError(double max_error, const Array<Errors>& errors) {
  Array<double> means;
  means.reserve(errors.size());
  for (const Errors& one : errors) means.push_back(one.mean);
  const double noise = means.empty() ? 0.0 : Median(means);
  return std::clamp(kTimesMedian * noise, max_error, kMostNoise * max_error);
}

}  // namespace

void RemoveOutliers(double max_error, Window* window) {
  const Views views(*window);
  const Array<Errors> errors = ErrorsOfLandmarks(views, *window);
  const double limit = LargestMeanError(max_error, errors);
  auto next = errors.begin();
  EraseIf(window, [&](WindowLandmark& landmark) {
    if (!HasError(landmark)) return HasFailed(landmark);
    Errors error = *next++;
    if (error.largest > kFalseMatch * max_error) {
      RemoveFalseMatches(max_error, views, window, &landmark);
      error = views.ErrorsOf(landmark);
    }
    if (error.mean < limit) return false;
    const auto has_second = [](const WindowObservation& seen) { return seen.second.has_value(); };
    if (std::none_of(landmark.seen.begin(), landmark.seen.end(), has_second)) return true;
    ForgetSecondViews(window, &landmark);  // a landmark that fits camera 0 stays
    landmark.inverse_depth->SetEstimate(VertexInverseDepth::Estimate(1.0 / TriangulateDepth(*window, landmark)));
    return !(views.ErrorsOf(landmark).mean < limit);
  });
}

Parallax ParallaxBetween(const Window& window, int frame_a, int frame_b) {
  Parallax parallax;
  for (const auto& [id, landmark] : window.landmarks) {
    const WindowObservation *a = landmark.In(frame_a), *b = landmark.In(frame_b);
    if (!a || !b) continue;
    ++parallax.common;
    parallax.mean += (a->x - b->x).norm();
  }
  if (parallax.common > 0) parallax.mean /= parallax.common;
  return parallax;
}

}  // namespace ch5
