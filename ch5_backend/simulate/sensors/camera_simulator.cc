#include "ch5_backend/simulate/sensors/camera_simulator.h"

#include <optional>

#include "ch5_backend/math/option_checks.h"
#include "ch5_backend/math/transform.h"
#include "ch5_backend/simulate/random.h"

namespace ch5 {
namespace {

void Check(const Calibration& c, const CameraOptions& o) {
  CheckPositive("Calibration::camera_rate", c.camera_rate);
  CheckPositive("Calibration::fx", c.fx);
  CheckPositive("Calibration::fy", c.fy);
  CheckOption("Calibration::width", c.width, 1);
  CheckOption("Calibration::height", c.height, 1);
  CheckNotNegative("CameraOptions::pixel_sigma", o.pixel_sigma);
  CheckPositive("CameraOptions::near", o.near);
  CheckOption("CameraOptions::far", o.far, o.near);
  CheckOption("CameraOptions::max_tracks", o.max_tracks, 0);
  CheckOption("CameraOptions::max_track_length", o.max_track_length, 1);
  CheckOption("CameraOptions::drop_probability", o.drop_probability, 0, 1);
  CheckOption("CameraOptions::outlier_fraction", o.outlier_fraction, 0, 1);
  CheckOption("CameraOptions::time_offset", o.time_offset, -1e6, 1e6);
}

// Follows the points from image to image.
class FrontEnd {
 public:
  FrontEnd(const std::vector<Vec3>& points_W, const Calibration& calibration, const CameraOptions& options)
      : points_W_(points_W),
        calibration_(calibration),
        options_(options),
        random_(options.seed),
        random1_(options.seed ^ 0x1ca7e4a1),
        tracks_(points_W.size()) {}

  Image Look(double stamp, const Transform& T_W_B) {
    Image image{stamp, LookWithCamera0(T_W_B)};
    if (calibration_.camera1) image.tracks1 = LookWithCamera1(T_W_B);
    return image;
  }

 private:
  std::vector<TrackedPoint> LookWithCamera0(const Transform& T_W_B) {
    std::vector<TrackedPoint> observations;
    std::vector<size_t> candidates;
    const Transform T_W_C = T_W_B * calibration_.T_B_C;
    for (size_t k = 0; k < points_W_.size(); ++k) {
      Track& track = tracks_[k];
      track.x = Project(calibration_, T_W_C, points_W_[k]);
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

  // Those of camera 0's points that it sees too, as a front end finds them.
  std::vector<TrackedPoint> LookWithCamera1(const Transform& T_W_B) {
    const Camera& camera = *calibration_.camera1;
    std::vector<TrackedPoint> observations;
    const Transform T_W_C = T_W_B * camera.T_B_C;
    for (size_t k = 0; k < points_W_.size(); ++k) {
      if (!tracks_[k].id) continue;
      const std::optional<Vec2> x = Project(camera, T_W_C, points_W_[k]);
      if (x) observations.push_back(Disturb(camera, *tracks_[k].id, *x, &random1_));
    }
    return observations;
  }

  struct Track {
    std::optional<int> id;  // while it is followed
    int length = 0;         // images
    std::optional<Vec2> x;  // where the point is in this image [normalized], if in it
  };

  std::optional<Vec2> Project(const Camera& camera, const Transform& T_W_C, const Vec3& p_W) const {
    const Vec3 p_C = T_W_C.q.conjugate() * (p_W - T_W_C.p);
    if (!(p_C.z() >= options_.near && p_C.z() <= options_.far)) return std::nullopt;
    const Vec2 x = p_C.hnormalized();
    return camera.Contains(camera.Pixel(x)) ? std::optional<Vec2>(x) : std::nullopt;
  }

  bool Loses(const Track& track) {
    return !track.x || track.length >= options_.max_track_length || random_.Uniform() < options_.drop_probability;
  }

  TrackedPoint Observe(Track* track) {
    ++track->length;
    return Disturb(calibration_, *track->id, *track->x, &random_);
  }

  TrackedPoint Disturb(const Camera& camera, int id, const Vec2& x, Random* random) const {
    const Vec2 d = NormalVector<2>(random, options_.pixel_sigma);
    if (random->Uniform() < options_.outlier_fraction) {
      const double u = random->Uniform(0.0, camera.width);
      const double v = random->Uniform(0.0, camera.height);
      return {id, camera.Normalized({u, v})};
    }
    return {id, x + Vec2(d.x() / camera.fx, d.y() / camera.fy)};
  }

  const std::vector<Vec3>& points_W_;
  const Calibration& calibration_;
  const CameraOptions& options_;
  Random random_, random1_;    // camera 1 has its own: camera 0's tracks are the same without it
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
    frames.push_back(front_end.Look(stamp, trajectory.At(t).T_W_B));
  }
  return frames;
}

}  // namespace ch5
