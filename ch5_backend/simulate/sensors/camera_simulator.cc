#include "ch5_backend/simulate/sensors/camera_simulator.h"

#include <optional>
#include <stdexcept>
#include <string>

#include "ch5_backend/simulate/random.h"

namespace ch5 {
namespace {

void Check(const Calibration& c, const CameraOptions& o) {
  const auto require = [](bool condition, const char* what) {
    if (!condition) throw std::invalid_argument(std::string("SimulateCamera: ") + what);
  };
  const auto is_fraction = [](double x) { return x >= 0.0 && x <= 1.0; };
  require(c.camera_rate > 0.0, "camera_rate must be positive");
  require(c.fx > 0.0 && c.fy > 0.0 && c.width > 0 && c.height > 0, "focal lengths and image size must be positive");
  require(std::isfinite(o.pixel_sigma) && o.pixel_sigma >= 0.0, "pixel_sigma must be finite and not negative");
  require(0.0 < o.near && o.near < o.far, "0 < near < far must hold");
  require(o.max_tracks >= 0 && o.max_track_length >= 1, "max_tracks ≥ 0 and max_track_length ≥ 1 must hold");
  require(is_fraction(o.drop_probability), "drop_probability must lie in [0, 1]");
  require(is_fraction(o.outlier_fraction), "outlier_fraction must lie in [0, 1]");
  require(std::isfinite(o.time_offset), "time_offset must be finite");
}

// Follows the points from image to image.
class FrontEnd {
 public:
  FrontEnd(const std::vector<Vec3>& points_W, const Calibration& calibration, const CameraOptions& options)
      : points_W_(points_W),
        calibration_(calibration),
        options_(options),
        random_(options.seed),
        tracks_(points_W.size()) {}

  std::vector<TrackedPoint> Look(const Transform& T_W_B) {
    const Transform& T_B_C = calibration_.T_B_C;
    const Qd q_C_W = (T_W_B.q * T_B_C.q).conjugate();
    const Vec3 p_W_C = T_W_B.q * T_B_C.p + T_W_B.p;
    std::vector<TrackedPoint> observations;
    std::vector<size_t> candidates;
    for (size_t k = 0; k < points_W_.size(); ++k) {
      Track& track = tracks_[k];
      track.x = Project(q_C_W * (points_W_[k] - p_W_C));
      if (track.id && Loses(track)) {
        track.id.reset();
      } else if (track.id) {
        observations.push_back(Observe(&track));
      } else if (track.x) {
        candidates.push_back(k);
      }
    }
    for (const size_t k : candidates) {
      if (observations.size() >= static_cast<size_t>(options_.max_tracks)) break;
      tracks_[k].id = next_id_++;
      tracks_[k].length = 0;
      observations.push_back(Observe(&tracks_[k]));
    }
    return observations;
  }

 private:
  struct Track {
    std::optional<int> id;  // while it is followed
    int length = 0;         // images
    std::optional<Vec2> x;  // where the point is in this image [normalized], if in it
  };

  std::optional<Vec2> Project(const Vec3& p_C) const {
    if (!(p_C.z() >= options_.near && p_C.z() <= options_.far)) return std::nullopt;
    const Vec2 x = p_C.hnormalized(), pixel = calibration_.Pixel(x);
    const bool inside = pixel.x() >= 0.0 && pixel.x() < calibration_.width &&  //
                        pixel.y() >= 0.0 && pixel.y() < calibration_.height;
    return inside ? std::optional<Vec2>(x) : std::nullopt;
  }

  bool Loses(const Track& track) {
    return !track.x || track.length >= options_.max_track_length || random_.Uniform() < options_.drop_probability;
  }

  TrackedPoint Observe(Track* track) {
    ++track->length;
    const double du = options_.pixel_sigma * random_.Normal();
    const double dv = options_.pixel_sigma * random_.Normal();
    if (random_.Uniform() < options_.outlier_fraction) {
      const double u = random_.Uniform(0.0, calibration_.width);
      const double v = random_.Uniform(0.0, calibration_.height);
      return {*track->id, calibration_.Normalized({u, v})};
    }
    return {*track->id, *track->x + Vec2(du / calibration_.fx, dv / calibration_.fy)};
  }

  const std::vector<Vec3>& points_W_;
  const Calibration& calibration_;
  const CameraOptions& options_;
  Random random_;
  std::vector<Track> tracks_;  // [point]
  int next_id_ = 0;
};

}  // namespace

std::vector<Image> SimulateCamera(const Trajectory& trajectory, const std::vector<Vec3>& points_W,
                                  const Calibration& calibration, const CameraOptions& options) {
  Check(calibration, options);
  FrontEnd front_end(points_W, calibration, options);
  std::vector<Image> frames;
  const auto count = static_cast<int64_t>(std::floor(trajectory.Duration() * calibration.camera_rate + 1e-9));
  for (int64_t n = 0; n <= count; ++n) {
    const double stamp = RoundToNanosecond(static_cast<double>(n) / calibration.camera_rate);
    const double t = stamp + options.time_offset;
    if (t < 0.0 || t > trajectory.Duration()) continue;
    frames.push_back({stamp, front_end.Look(trajectory.At(t).T_W_B)});
  }
  return frames;
}

}  // namespace ch5
