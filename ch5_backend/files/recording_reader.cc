// The reading half of recording_file.h.

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <set>

#include "ch5_backend/files/csv_reader.h"
#include "ch5_backend/files/recording_file.h"
#include "ch5_backend/files/yaml_file.h"

namespace ch5 {
namespace {

// The time of a row from the first IMU measurement [s], which it must be near.
double TimeOf(const CsvReader& csv, int64_t stamp, const Recording& recording) {
  if (std::abs(stamp - recording.origin_ns) > kLongestRecordingNs) {
    std::string unit;
    for (const auto& [factor, name] : {std::pair(1e3, "microseconds"), {1e6, "milliseconds"}, {1e9, "seconds"}}) {
      const double off = factor * static_cast<double>(stamp) - static_cast<double>(recording.origin_ns);
      if (std::abs(off) < static_cast<double>(kLongestRecordingNs)) unit = name;
    }
    csv.Fail("the timestamp is more than ten days from the first IMU measurement, got " + std::to_string(stamp) +
             " against " + std::to_string(recording.origin_ns) +
             (unit.empty() ? "" : "; it looks like " + unit + ", and must be in nanoseconds"));
  }
  return SecondsAt(stamp, recording.origin_ns);
}

// Goes to the next row. The writer ends each one, so that one without an end is cut, perhaps in its last number.
bool NextRow(CsvReader* csv) {
  if (!csv->NextRow()) return false;
  if (csv->EndsInRow()) csv->Fail("the file ends in the middle of a line; is it cut? If not, end it with a newline");
  return true;
}

// Stamps in another unit, by their number a second.
void RequireNanoseconds(const CsvReader& csv, const std::string& sensor, double rate) {
  const std::string unit = csv.UnitOfStamps(rate);
  if (unit.empty() || unit == "nanoseconds") return;
  csv.Fail("the timestamps are in " + unit + " if there are as many a second as " + sensor +
           ".rate_hz says; they must be in nanoseconds");
}

bool JumpTogether(const std::vector<ClockJump>& a, const std::vector<ClockJump>& b) {
  constexpr double kSame = 5.0;  // [s]; the pause, and an image's period
  const auto is_same = [](const ClockJump& x, const ClockJump& y) { return std::abs(x.by - y.by) < kSame; };
  return std::equal(a.begin(), a.end(), b.begin(), b.end(), is_same);
}

// Jumps of all clocks together are taken back but for a pause, after which an estimator begins anew.
// @return whether the truth's clock jumps too
bool TakeBackJumps(CsvReader* imu, CsvReader* tracks, CsvReader* truth, Recording* recording) {
  const std::vector<ClockJump> of_imu = imu->ClockJumps(), of_tracks = tracks->ClockJumps();
  if (of_imu.empty() || !JumpTogether(of_imu, of_tracks)) return false;
  std::vector<ClockJump> of_truth;
  if (truth) of_truth = truth->ClockJumps();
  std::vector<std::pair<int, int64_t>> imu_lines, track_lines, truth_lines;
  double taken_back = 0.0;
  for (size_t k = 0; k < of_imu.size(); ++k) {
    const int64_t ns = std::llround(1e9 * (of_imu[k].by - kClockPause));
    recording->clock_steps.push_back(
        {of_imu[k].before - taken_back + 0.5 * kClockPause, ns, imu->Path() + ":" + std::to_string(of_imu[k].line)});
    taken_back += 1e-9 * static_cast<double>(ns);
    imu_lines.emplace_back(of_imu[k].line, ns);
    track_lines.emplace_back(of_tracks[k].line, ns);
    if (truth && JumpTogether(of_imu, of_truth)) truth_lines.emplace_back(of_truth[k].line, ns);
  }
  imu->TakeBack(imu_lines);
  tracks->TakeBack(track_lines);
  if (truth) truth->TakeBack(truth_lines);
  return !truth_lines.empty();
}

void ReadImu(CsvReader* csv, Recording* recording, std::vector<LeftOut>* left_out, std::vector<int>* lines) {
  RequireNanoseconds(*csv, "imu", recording->calibration.imu_rate);
  ReadEach(csv->Path(), left_out, [&] {
    if (!NextRow(csv)) return false;
    const int64_t stamp = csv->Stamp();
    if (recording->imu.empty()) recording->origin_ns = stamp;
    recording->imu.push_back({TimeOf(*csv, stamp, *recording), csv->Vector("a_"), csv->Vector("w_")});
    if (lines) lines->push_back(csv->Line());
    return true;
  });
  if (const std::string why = WhyNotInUnits(recording->imu, recording->calibration); !why.empty()) csv->Fail(why);
}

void ReadTracks(CsvReader* csv, Recording* recording, std::vector<LeftOut>* left_out) {
  RequireNanoseconds(*csv, "camera", recording->calibration.camera_rate);
  std::set<std::pair<int, int>> seen;  // of the current image: camera and id
  const bool has_camera = csv->Has("camera");
  ReadEach(csv->Path(), left_out, [&] {
    if (!NextRow(csv)) return false;
    const double t = TimeOf(*csv, csv->Stamp(/*may_repeat=*/true), *recording);
    if (recording->images.empty() || recording->images.back().t != t) {
      recording->images.push_back({t, {}});
      seen.clear();
    }
    const int id = static_cast<int>(csv->Integer("track_id", 0, std::numeric_limits<int>::max()));
    const int camera = has_camera ? static_cast<int>(csv->Integer("camera", 0, 1)) : 0;
    if (camera == 1 && !recording->calibration.camera1) {
      csv->Fail("a point of camera 1, but calibration.yaml has no camera1");
    }
    if (!seen.insert({camera, id}).second) {
      csv->Fail("the track is in this image already, got track_id " + std::to_string(id) +
                (has_camera ? " of camera " + std::to_string(camera) : ""));
    }
    const Vec2 x(csv->Number("x"), csv->Number("y"));
    // 10 is 84° off the axis.
    if (x.cwiseAbs().maxCoeff() > 10.0) {
      csv->Fail("coordinates must be normalized (within ±10), not pixels, got " + std::to_string(x.x()) + ", " +
                std::to_string(x.y()));
    }
    Image& image = recording->images.back();
    (camera == 0 ? image.tracks : image.tracks1).push_back({id, x});
    return true;
  });
  const std::vector<Image>& frames = recording->images;
  if (frames.empty()) csv->Fail("at least one image is needed");
  const auto in_imus_time = [&](const Image& image) { return image.t >= 0.0 && image.t <= recording->imu.back().t; };
  if (std::none_of(frames.begin(), frames.end(), in_imus_time)) {
    throw FileError(csv->Path() + ": " + ClocksDiffer(frames.front().t, frames.back().t, recording->imu));
  }
}

void ReadTruth(CsvReader* csv, Recording* recording, std::vector<LeftOut>* left_out) {
  const bool has_velocity = csv->Has("v_x"), has_biases = csv->Has("bg_x") || csv->Has("ba_x");
  ReadPoses(csv->Path(), left_out, [&] {
    if (!NextRow(csv)) return false;
    StampedState state;
    state.t = TimeOf(*csv, csv->Stamp(), *recording);
    state.T_W_B = {csv->Rotation(), csv->Vector("p_")};
    if (has_velocity) state.v_W = csv->Vector("v_");
    if (has_biases) {
      state.b_g = csv->Vector("bg_");
      state.b_a = csv->Vector("ba_");
    }
    recording->truth.push_back(state);
    return true;
  });
  CompleteTruth(*csv, has_velocity, &recording->truth);
}

// How well the truth's rotations agree with the gyroscope's, as a correlation of the angles between rows 0.1 s apart: 1 if
// they do, and hardly more than 0 if the quaternions' parts are in another order.
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
  const bool scalar_is_last = IsTum(path);
  const auto as_is = [](const Qd& q) { return q; };
  const auto other = [&](const Qd& q) {  // as if its columns had been read in the other order
    return scalar_is_last ? Qd(q.x(), q.y(), q.z(), q.w()) : Qd(q.z(), q.w(), q.x(), q.y());
  };
  const double agreement = AgreementWithGyroscope(recording, other);
  if (agreement < 0.9 || agreement < AgreementWithGyroscope(recording, as_is) + 0.1) return;
  const std::string first = "w, x, y, z", last = "x, y, z, w";
  throw FileError(path + ": the quaternions must stand in the order " + (scalar_is_last ? last : first) +
                  "; these agree with the gyroscope in the order " + (scalar_is_last ? first : last));
}

// Turned into W, the accelerations are upwards on average, since speeds hardly change in the long run.
std::string ContradictionToUp(const Recording& recording) {
  Vec3 sum = Vec3::Zero();
  int count = 0;
  for (const ImuMeasurement& measurement : recording.imu) {
    const auto state = StateAt(recording.truth, measurement.t);
    if (!state) continue;
    sum += state->T_W_B.q * measurement.acceleration;
    ++count;
  }
  const double tilt = std::atan2(sum.head<2>().norm(), sum.z()) * 180.0 / M_PI;
  if (count < 2.0 * recording.calibration.imu_rate || tilt < 40.0) return "";  // in 2 s, 4 m/s² may last
  return "z must be up in its world, but turned into it the accelerations are " + std::to_string(std::lround(tilt)) +
         "° off on average; are these the IMU's poses, and is its acceleration +9.81 upwards at rest?";
}

constexpr double kTiny = 1e-12, kLarge = 1e6;

// Keys of the estimator's section, or of a camera that is not one of the two (camera2, cam1, …), not of the calibration.
bool IsExtra(const std::string& key) {
  if (key.rfind("camera1.", 0) == 0) return false;
  const size_t digit = key.rfind("camera", 0) == 0 ? 6 : 3;
  return key.rfind("estimator.", 0) == 0 || (key.rfind("cam", 0) == 0 && key[digit] >= '1' && key[digit] <= '9');
}

// The numbers `names` under `key`, which no list may give: publishers differ in the order.
std::vector<double> ReadNamed(const YamlFile& yaml, const std::string& key, const std::vector<std::string>& names,
                              double low, double high) {
  if (yaml.Has(key)) yaml.Fail(key, "name its numbers: {" + names[0] + ": …, " + names[1] + ": …, …}");
  std::vector<double> numbers;
  for (const std::string& name : names) numbers.push_back(yaml.Number(key + "." + name, low, high));
  return numbers;
}

// @param name  of its section, camera or camera1
Camera ReadCamera(const YamlFile& yaml, const std::string& name) {
  Camera c;
  const std::vector<double> f = ReadNamed(yaml, name + ".intrinsics", {"fx", "fy", "cx", "cy"}, -kLarge, kLarge);
  c.fx = f[0], c.fy = f[1], c.cx = f[2], c.cy = f[3];
  const std::vector<double> size = yaml.Numbers(name + ".resolution", 2);
  for (const double pixels : size) {
    if (!(pixels >= 1.0 && pixels <= kLarge && pixels == std::floor(pixels)))
      yaml.Fail(name + ".resolution", "must be two numbers of pixels, got " + yaml.Word(name + ".resolution"));
  }
  c.width = static_cast<int>(size[0]), c.height = static_cast<int>(size[1]);
  if (const std::string why = WhyNotInPixels(c); !why.empty()) yaml.Fail(name + ".intrinsics.fx", why);
  const std::vector<double> p = yaml.Numbers(name + ".p_B_C", 3);
  c.T_B_C.p = Vec3(p[0], p[1], p[2]);
  if (c.T_B_C.p.cwiseAbs().maxCoeff() > kLongestLever)
    yaml.Fail(name + ".p_B_C", "must be in meters, got " + yaml.Word(name + ".p_B_C"));
  const std::vector<double> q = ReadNamed(yaml, name + ".q_B_C", {"w", "x", "y", "z"}, -1.01, 1.01);
  c.T_B_C.q = Qd(q[0], q[1], q[2], q[3]);
  if (const std::string why = WhyNotUnit(c.T_B_C.q); !why.empty()) yaml.Fail(name + ".q_B_C.w", why);
  c.T_B_C.q.normalize();
  return c;
}

}  // namespace

bool IsTum(const std::string& path) {
  TextReader reader(path);
  while (const auto line = reader.ReadLine()) {
    const auto words = Words(*line);
    if (!words.empty() && words[0][0] != '#') return words.size() == 8 && line->find(',') == std::string_view::npos;
  }
  return false;
}

std::vector<StampedState> ReadTum(const std::string& path, int64_t origin_ns, std::vector<LeftOut>* left_out) {
  constexpr const char* kNames[] = {"timestamp [s]", "tx", "ty", "tz", "qx", "qy", "qz", "qw"};
  TextReader reader(path);
  const std::set<int> jumps = LinesOutOfOrder(reader.Stamps([](std::string_view line) {
    const auto words = Words(line);
    return words.empty() || words[0][0] == '#' ? std::string_view() : words[0];
  }));
  std::vector<StampedState> states;
  ReadPoses(path, left_out, [&] {
    const auto line = reader.ReadLine();
    if (!line) return false;
    const auto words = Words(*line);
    if (words.empty() || words[0][0] == '#') return true;
    if (words.size() != 8)
      reader.Fail("a pose is timestamp tx ty tz qx qy qz qw, eight numbers, got " + TextReader::Quote(*line));
    double x[8];
    for (size_t k = 0; k < 8; ++k) x[k] = reader.ToDouble(words[k], kNames[k]);
    StampedState state;
    state.t = RoundToNanosecond(x[0] - 1e-9 * static_cast<double>(origin_ns));
    if (std::abs(state.t) > 1e-9 * kLongestRecordingNs)
      reader.Fail("the timestamp is more than ten days from the first IMU measurement, got " + std::string(words[0]) +
                  ", which must be in seconds");
    if (!states.empty() && state.t <= states.back().t)
      reader.Fail("the timestamp is repeated or goes backwards, got " + std::string(words[0]));
    if (jumps.count(reader.Line()) > 0)
      reader.Fail("the timestamp jumps ahead of those in the rows below, got " + std::string(words[0]));
    state.T_W_B = {Qd(x[7], x[4], x[5], x[6]), Vec3(x[1], x[2], x[3])};
    if (const std::string why = WhyNotUnit(state.T_W_B.q); !why.empty()) reader.Fail(why);
    state.T_W_B.q.normalize();
    states.push_back(state);
    return true;
  });
  DifferentiatePositions(&states);
  return states;
}

void CompleteTruth(const CsvReader& csv, bool has_velocity, std::vector<StampedState>* truth) {
  if (truth->empty()) csv.Fail("at least one pose is needed; where the truth is not known, remove the file");
  if (!has_velocity) DifferentiatePositions(truth);
}

void CheckTruth(const std::string& path, std::vector<LeftOut>* left_out, Recording* recording) {
  CheckOrderOfQuaternions(path, *recording);
  const std::string contradiction = ContradictionToUp(*recording);
  if (contradiction.empty()) return;
  if (!left_out) throw FileError(path + ": " + contradiction);
  left_out->push_back({path, static_cast<int>(recording->truth.size()), contradiction});
  recording->truth.clear();
}

Calibration ReadCalibration(const std::filesystem::path& file) {
  const YamlFile yaml(file.string());
  Calibration c;
  const auto is_of_camera1 = [](const auto& value) { return value.first.rfind("camera1.", 0) == 0; };
  static_cast<Camera&>(c) = ReadCamera(yaml, "camera");
  c.camera_rate = yaml.Number("camera.rate_hz", kTiny, kLarge);
  if (std::any_of(yaml.Values().begin(), yaml.Values().end(), is_of_camera1)) c.camera1 = ReadCamera(yaml, "camera1");
  c.imu_rate = yaml.Number("imu.rate_hz", kTiny, kLarge);
  c.noise.gyroscope = yaml.Number("imu.gyroscope_noise_density", kTiny, kLarge);
  c.noise.gyroscope_walk = yaml.Number("imu.gyroscope_random_walk", kTiny, kLarge);
  c.noise.accelerometer = yaml.Number("imu.accelerometer_noise_density", kTiny, kLarge);
  c.noise.accelerometer_walk = yaml.Number("imu.accelerometer_random_walk", kTiny, kLarge);
  c.gravity = yaml.Number("imu.gravity", kTiny, kLarge);
  for (const auto& [key, value] : yaml.Values()) {
    if (!value.is_asked && !IsExtra(key)) yaml.Fail(key, "nothing of this name is known here");
  }
  return c;
}

CalibrationExtras ReadCalibrationExtras(const std::filesystem::path& file) {
  const std::string section = "estimator.";
  CalibrationExtras extras;
  const YamlFile yaml(file.string());
  for (const auto& [key, value] : yaml.Values()) {
    if (!IsExtra(key)) continue;
    const std::string where = file.string() + ":" + std::to_string(value.line) + ": " + key;
    if (key.rfind(section, 0) == 0) {
      extras.estimator.push_back({key.substr(section.size()), value.text, where});
    } else {
      extras.not_used.push_back(where);
    }
  }
  return extras;
}

Recording ReadRecording(const std::filesystem::path& folder, std::vector<LeftOut>* left_out,
                        std::vector<int>* imu_lines) {
  Recording recording;
  recording.calibration = ReadCalibration(folder / "calibration.yaml");
  CsvReader imu((folder / "imu.csv").string()), tracks((folder / "tracks.csv").string());
  std::string truth_path;
  for (const char* name : {"groundtruth.txt", "groundtruth.csv"}) {  // a link to nothing is an error
    if (std::filesystem::exists(std::filesystem::symlink_status(folder / name))) truth_path = (folder / name).string();
  }
  const bool is_tum = !truth_path.empty() && IsTum(truth_path);
  std::optional<CsvReader> truth;
  if (!truth_path.empty() && !is_tum) truth.emplace(truth_path);
  const bool truth_jumps = left_out && TakeBackJumps(&imu, &tracks, truth ? &*truth : nullptr, &recording);
  ReadImu(&imu, &recording, left_out, imu_lines);
  ReadTracks(&tracks, &recording, left_out);
  if (is_tum) recording.truth = ReadTum(truth_path, recording.origin_ns, left_out);
  if (truth) ReadTruth(&*truth, &recording, left_out);
  if (!recording.clock_steps.empty() && !truth_path.empty() && !truth_jumps) {
    const auto later = std::find_if(recording.truth.begin(), recording.truth.end(),
                                    [&](const StampedState& state) { return state.t > recording.clock_steps[0].t; });
    const auto count = static_cast<int>(recording.truth.end() - later);
    if (count > 0)
      left_out->push_back(
          {truth_path, count, "its clock does not jump with the others in " + recording.clock_steps[0].where});
    recording.truth.erase(later, recording.truth.end());
  }
  if (!truth_path.empty()) CheckTruth(truth_path, left_out, &recording);
  return recording;
}

}  // namespace ch5
