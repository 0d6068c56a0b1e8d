// The reading half of recording_file.h.

#include <cstdlib>
#include <limits>
#include <optional>
#include <set>

#include "ch5_backend/files/csv_reader.h"
#include "ch5_backend/files/recording_file.h"
#include "ch5_backend/files/yaml_numbers.h"

namespace ch5 {
namespace {

// The time stamps of a file, which must increase and be near the origin.
class TimeStamps {
 public:
  // The time stamp of the current row [ns].
  // @param origin  nullopt: this one is the origin
  int64_t Read(const CsvReader& csv, bool may_repeat, std::optional<int64_t> origin) {
    const int64_t stamp = csv.Integer(0, 0, std::numeric_limits<int64_t>::max());
    if (origin && std::abs(stamp - *origin) > kLongestRecordingNs) {
      csv.Fail("the timestamp is more than ten days from the first IMU measurement, got " + std::to_string(stamp) +
               " against " + std::to_string(*origin));
    }
    const std::string got = ", got " + std::to_string(stamp) + " after " + std::to_string(last_);
    if (stamp < last_) csv.Fail("the timestamp goes backwards" + got);
    if (stamp == last_ && !may_repeat) csv.Fail("the timestamp is repeated" + got);
    last_ = stamp;
    return stamp;
  }

 private:
  int64_t last_ = -1;
};

Vec3 ReadVector(const CsvReader& csv, size_t column) {
  return {csv.Double(column), csv.Double(column + 1), csv.Double(column + 2)};
}

// Empty if ‖q‖ = 1 within 1e-3. Six printed digits give 1e-5; a larger error means another column.
std::string WhyNotUnit(const Qd& q) {
  if (std::abs(q.norm() - 1.0) < 1e-3) return "";
  return "the quaternion must be of length 1, got " + std::to_string(q.norm());
}

void ReadImu(const std::string& path, Recording* recording) {
  CsvReader csv(path, {"#timestamp [ns]", "w_x", "w_y", "w_z", "a_x", "a_y", "a_z"});
  TimeStamps stamps;
  while (csv.NextRow()) {
    const bool is_first = recording->imu.empty();
    const int64_t stamp = stamps.Read(csv, false, is_first ? std::nullopt : std::optional(recording->origin_ns));
    if (is_first) recording->origin_ns = stamp;
    recording->imu.push_back({SecondsAt(stamp, recording->origin_ns), ReadVector(csv, 4), ReadVector(csv, 1)});
  }
  if (const std::string why = WhyNotInUnits(recording->imu, recording->calibration); !why.empty()) csv.Fail(why);
}

void ReadTracks(const std::string& path, Recording* recording) {
  CsvReader csv(path, {"#timestamp [ns]", "track_id", "x", "y"}, "camera");
  TimeStamps stamps;
  std::set<std::pair<int, int>> seen;  // of the current image: camera and id
  while (csv.NextRow()) {
    const double t = SecondsAt(stamps.Read(csv, true, recording->origin_ns), recording->origin_ns);
    if (recording->frames.empty() || recording->frames.back().t != t) {
      recording->frames.push_back({t, {}});
      seen.clear();
    }
    const int id = static_cast<int>(csv.Integer(1, 0, std::numeric_limits<int>::max()));
    const int camera = csv.HasOptional() ? static_cast<int>(csv.Integer(4, 0, 1)) : 0;
    if (camera == 1 && !recording->calibration.camera1) {
      csv.Fail("a point of camera 1, but calibration.yaml has no camera1");
    }
    if (!seen.insert({camera, id}).second) {
      csv.Fail("the track is in this image already, got track_id " + std::to_string(id) +
               (csv.HasOptional() ? " of camera " + std::to_string(camera) : ""));
    }
    const Vec2 x(csv.Double(2), csv.Double(3));
    // 10 is 84° off the axis.
    if (x.cwiseAbs().maxCoeff() > 10.0) {
      csv.Fail("coordinates must be normalized (within ±10), not pixels, got " + std::to_string(x.x()) + ", " +
               std::to_string(x.y()));
    }
    Image& image = recording->frames.back();
    (camera == 0 ? image.tracks : image.tracks1).push_back({id, x});
  }
  if (recording->frames.empty()) csv.Fail("at least one image is needed");
}

void ReadTruth(const std::string& path, Recording* recording) {
  CsvReader csv(path, {"#timestamp [ns]", "p_x", "p_y", "p_z", "q_w", "q_x", "q_y", "q_z", "v_x", "v_y", "v_z", "bg_x",
                       "bg_y", "bg_z", "ba_x", "ba_y", "ba_z"});
  TimeStamps stamps;
  while (csv.NextRow()) {
    StampedState state;
    state.t = SecondsAt(stamps.Read(csv, false, recording->origin_ns), recording->origin_ns);
    const Qd q(csv.Double(4), csv.Double(5), csv.Double(6), csv.Double(7));
    if (const std::string why = WhyNotUnit(q); !why.empty()) csv.Fail(why);
    state.T_W_B = {q.normalized(), ReadVector(csv, 1)};
    state.v_W = ReadVector(csv, 8);
    state.b_g = ReadVector(csv, 11);
    state.b_a = ReadVector(csv, 14);
    recording->truth.push_back(state);
  }
}

// How well the truth's rotations agree with the gyroscope's, as a correlation of the angles between rows 0.1 s apart: 1 if
// they do, and hardly more than 0 if the quaternions' parts stand in another order.
// @param reorder  the quaternion that a row's four numbers are taken for
template <typename Reorder>
double AgreementWithGyroscope(const Recording& recording, const Reorder& reorder) {
  constexpr double kStep = 0.1;
  double both = 0.0, by_truth = 0.0, by_gyroscope = 0.0;
  auto measurement = recording.imu.begin();
  const StampedState* from = nullptr;
  for (const StampedState& to : recording.truth) {
    if (!from) from = &to;
    if (to.t - from->t < kStep) continue;
    while (measurement != recording.imu.end() && measurement->t < from->t) ++measurement;
    Vec3 rate = Vec3::Zero();
    int count = 0;
    for (; measurement != recording.imu.end() && measurement->t < to.t; ++measurement, ++count)
      rate += measurement->gyroscope;
    if (count > 0) {
      const Vec3 turn = LogSO3(reorder(from->T_W_B.q).conjugate() * reorder(to.T_W_B.q));
      const Vec3 measured = rate * (to.t - from->t) / count;
      both += turn.dot(measured);
      by_truth += turn.squaredNorm();
      by_gyroscope += measured.squaredNorm();
    }
    from = &to;
  }
  constexpr double kLeast = 0.01;  // [rad²]: with less motion nothing can be said
  return std::min(by_truth, by_gyroscope) < kLeast ? 0.0 : both / std::sqrt(by_truth * by_gyroscope);
}

void CheckOrderOfQuaternions(const std::string& path, const Recording& recording) {
  const auto as_is = [](const Qd& q) { return q; };
  const auto scalar_last = [](const Qd& q) {
    return Qd(q.z(), q.w(), q.x(), q.y());
  };  // columns x, y, z, w were read as w, x, y, z
  const double agreement = AgreementWithGyroscope(recording, scalar_last);
  if (agreement < 0.9 || agreement < AgreementWithGyroscope(recording, as_is) + 0.1) return;
  throw FileError(path +
                  ": the quaternions must stand in the order w, x, y, z; these agree with the gyroscope in the order "
                  "x, y, z, w");
}

constexpr double kTiny = 1e-12, kLarge = 1e6, kFar = 500.0;  // [m]

// @param name  of its section, camera or camera1
Camera ReadCamera(const std::string& file, const std::string& name, YamlNumbers* yaml) {
  const auto take = [&](const std::string& key, double low, double high) {
    return yaml->Take(name + "." + key, low, high);
  };
  Camera c;
  c.fx = take("intrinsics.fx", kTiny, kLarge);
  c.fy = take("intrinsics.fy", kTiny, kLarge);
  c.cx = take("intrinsics.cx", -kLarge, kLarge);
  c.cy = take("intrinsics.cy", -kLarge, kLarge);
  c.width = static_cast<int>(take("resolution[0]", 1, kLarge));
  c.height = static_cast<int>(take("resolution[1]", 1, kLarge));
  for (int i = 0; i < 3; ++i) c.T_B_C.p[i] = take("p_B_C[" + std::to_string(i) + "]", -kFar, kFar);
  const auto part = [&](const char* of_q) { return take(std::string("q_B_C.") + of_q, -1.01, 1.01); };
  const double w = part("w"), x = part("x"), y = part("y"), z = part("z");
  const Qd q(w, x, y, z);
  if (const std::string why = WhyNotUnit(q); !why.empty()) throw FileError(file + ": " + name + ".q_B_C: " + why);
  c.T_B_C.q = q.normalized();
  return c;
}

}  // namespace

Calibration ReadCalibration(const std::filesystem::path& file) {
  YamlNumbers yaml(file.string());
  Calibration c;
  static_cast<Camera&>(c) = ReadCamera(file.string(), "camera", &yaml);
  c.camera_rate = yaml.Take("camera.rate_hz", kTiny, kLarge);
  if (yaml.HasSection("camera1")) c.camera1 = ReadCamera(file.string(), "camera1", &yaml);
  c.imu_rate = yaml.Take("imu.rate_hz", kTiny, kLarge);
  c.noise.gyroscope = yaml.Take("imu.gyroscope_noise_density", kTiny, kLarge);
  c.noise.gyroscope_walk = yaml.Take("imu.gyroscope_random_walk", kTiny, kLarge);
  c.noise.accelerometer = yaml.Take("imu.accelerometer_noise_density", kTiny, kLarge);
  c.noise.accelerometer_walk = yaml.Take("imu.accelerometer_random_walk", kTiny, kLarge);
  c.gravity = yaml.Take("imu.gravity", kTiny, kLarge);
  yaml.ExpectAllTaken();
  return c;
}

CalibrationExtras ReadCalibrationExtras(const std::filesystem::path& file) {
  const std::string section = "estimator.";
  CalibrationExtras extras;
  const YamlNumbers yaml(file.string());
  for (const auto& [key, word, line] : yaml.Words()) {
    const std::string where = file.string() + ":" + std::to_string(line) + ": " + key;
    if (key.rfind(section, 0) == 0) {
      extras.estimator.push_back({key.substr(section.size()), word, where});
    } else {
      extras.not_used.push_back(where);
    }
  }
  return extras;
}

Recording ReadRecording(const std::filesystem::path& folder) {
  Recording recording;
  recording.calibration = ReadCalibration(folder / "calibration.yaml");
  ReadImu((folder / "imu.csv").string(), &recording);
  ReadTracks((folder / "tracks.csv").string(), &recording);
  const std::filesystem::path truth = folder / "groundtruth.csv";
  if (std::filesystem::exists(truth)) {
    ReadTruth(truth.string(), &recording);
    CheckOrderOfQuaternions(truth.string(), recording);
  }
  return recording;
}

}  // namespace ch5
