#include "ch5_backend/track/euroc_folder.h"

#include <algorithm>
#include <cstdio>

#include "ch5_backend/files/csv_reader.h"
#include "ch5_backend/files/recording_file.h"
#include "ch5_backend/math/transform.h"
#include "ch5_backend/track/sensor_yaml.h"

namespace ch5 {
namespace {

namespace fs = std::filesystem;

constexpr char kNotRead[] = ", such as VINS-Mono's, are not read: ch5_backend/GUIDE.md has a sensor.yaml to fill in";

bool IsIdentity(const Transform& T) { return T.p.norm() < 1e-9 && T.q.vec().norm() < 1e-9; }

std::string Seconds(double t) {
  char text[32];
  std::snprintf(text, sizeof text, "%.2f s", t);
  return text;
}

fs::path FindMav0(const fs::path& folder) {
  for (const fs::path& place : {folder / "mav0", folder}) {
    if (fs::is_directory(place / "cam0")) return place;
  }
  throw FileError(folder.string() + ": neither this folder nor its mav0 holds cam0");
}

// Kalibr's file of cameras or IMU, by its name: camchain.yaml, camchain-imucam-….yaml; imu_config.yaml, imu-….yaml; OpenVINS's
// are kalibr_imucam_chain.yaml and kalibr_imu_chain.yaml.
bool IsKalibrFile(const fs::path& path, const std::string& sensor) {
  const std::string name = path.filename().string();
  const auto has = [&](const char* part) { return name.find(part) != std::string::npos; };
  if (path.extension() != ".yaml" && path.extension() != ".yml") return false;
  return sensor == "imu0" ? name.rfind("imu", 0) == 0 || has("imu_chain") : has("camchain") || has("cam_chain");
}

// The sensor's own sensor.yaml, or else a file of Kalibr's: beside it, in mav0, beside mav0, or as TUM-VI has it in dso/.
std::string FindSensorFile(const fs::path& mav0, const std::string& sensor) {
  const fs::path own = mav0 / sensor / "sensor.yaml", beside = (mav0 / "..").lexically_normal();
  if (fs::exists(own)) return own.string();
  std::vector<std::string> found;
  for (const fs::path& folder : {mav0 / sensor, mav0, beside, beside / "dso"}) {
    if (!found.empty() || !fs::is_directory(folder)) continue;
    for (const fs::directory_entry& entry : fs::directory_iterator(folder))
      if (IsKalibrFile(entry.path(), sensor)) found.push_back(entry.path().string());
  }
  if (found.size() > 1) {
    std::sort(found.begin(), found.end());
    throw FileError("two calibrations, " + found[0] + " and " + found[1] + "; leave the one that is meant");
  }
  if (!found.empty()) return found[0];
  throw FileError(own.string() + ": there is no such file, nor one of Kalibr's (" +
                  (sensor == "imu0" ? "imu….yaml" : "…camchain….yaml") +
                  ") beside it, in mav0, beside that or in dso/ there; other calibrations" + kNotRead);
}

// What this file says, which may hold several sensors, each in a section of its name.
SensorYaml ReadSensor(const fs::path& mav0, const std::string& sensor) {
  const std::string file = FindSensorFile(mav0, sensor);
  SensorYaml yaml(file, sensor);
  if (yaml.Has("projection_parameters.fx") || yaml.Has("imu_topic"))
    throw FileError(file + ": configurations" + kNotRead);
  return yaml;
}

// The IMU's own T_BS; most publishers take the IMU for the body.
Transform ReadImu(const fs::path& mav0, std::vector<LeftOut>* left_out, EurocFolder* result) {
  Recording* recording = &result->recording;
  const SensorYaml yaml = ReadSensor(mav0, "imu0");
  Calibration& c = recording->calibration;
  c.noise.continuous = true;
  c.noise.gyroscope = yaml.Positive("gyroscope_noise_density");
  c.noise.gyroscope_walk = yaml.Positive("gyroscope_random_walk");
  c.noise.accelerometer = yaml.Positive("accelerometer_noise_density");
  c.noise.accelerometer_walk = yaml.Positive("accelerometer_random_walk");
  c.imu_rate = yaml.Positive(yaml.Name("rate_hz", "update_rate"));

  const std::string path = (mav0 / "imu0" / "data.csv").string();
  CsvReader csv(path);
  ReadEach(path, left_out, [&] {
    if (!csv.NextRow()) return false;
    const int64_t stamp = csv.Stamp();
    if (recording->imu.empty()) recording->origin_ns = stamp;
    recording->imu.push_back({SecondsAt(stamp, recording->origin_ns), csv.Vector("a_"), csv.Vector("w_")});
    if (csv.EndsInRow())
      result->notes.push_back("imu0: the last line has no end; if the file is cut, so may be its last number");
    return true;
  });
  if (const std::string why = WhyNotInUnits(recording->imu, recording->calibration); !why.empty()) csv.Fail(why);
  return yaml.Has("T_BS") ? yaml.T_B_S() : Transform{};
}

// EuRoC's and Kalibr's name of the coefficients, or OpenCV's and ROS's.
std::string CoefficientsKey(const SensorYaml& yaml) {
  const std::string key = yaml.Name("distortion_coefficients", "distortion_coeffs");
  return yaml.Name(key, "distortion_coefficients.data");
}

// Kalibr's double sphere has its two numbers before the intrinsics; other cameras' lenses have a model of their own.
Lens ReadLens(const SensorYaml& yaml) {
  Lens lens;
  const bool is_opencvs = yaml.Has("camera_matrix.data");
  const std::string camera = is_opencvs && !yaml.Has("camera_model") ? "pinhole" : yaml.Word("camera_model");
  if (camera == "ds") {
    const std::vector<double> numbers = yaml.Numbers("intrinsics", 6);
    lens.model = Lens::Model::kDoubleSphere;
    lens.k << numbers[0], numbers[1], 0.0, 0.0;
    if (!(lens.k[0] > -1.0 && lens.k[0] < 1.0 && lens.k[1] >= 0.0 && lens.k[1] <= 1.0))
      yaml.Fail("intrinsics", "ξ must lie in (−1, 1) and α in [0, 1], got " + yaml.Word("intrinsics"));
    return lens;
  }
  if (camera != "pinhole") yaml.Fail("camera_model", "must be pinhole or ds, got " + TextReader::Quote(camera));
  const std::string model = is_opencvs && !yaml.Has("distortion_model") ? "plumb_bob" : yaml.Word("distortion_model");
  if (model == "none") return lens;
  if (model == "fov") {
    const double width = yaml.Numbers(CoefficientsKey(yaml), 1)[0];
    if (!(width > 0.0 && width < M_PI))
      yaml.Fail(CoefficientsKey(yaml), "ω must lie in (0, π) rad, got " + std::to_string(width));
    lens.model = Lens::Model::kFieldOfView;
    lens.k << width, 0.0, 0.0, 0.0;
    return lens;
  }
  if (model == "equidistant") {
    lens.model = Lens::Model::kEquidistant;
  } else if (model != "radial-tangential" && model != "radtan" && model != "plumb_bob") {
    yaml.Fail("distortion_model",
              "must be radial-tangential, equidistant, fov or none, got " + TextReader::Quote(model));
  }
  const size_t most = lens.model == Lens::Model::kRadialTangential ? 5 : 4;
  const std::vector<double> k = yaml.Numbers(CoefficientsKey(yaml), 4, most);
  lens.k = Eigen::Map<const Eigen::Vector4d>(k.data());
  if (k.size() == 5) lens.k3 = k[4];
  return lens;
}

// fx, fy, cx, cy, where the lens leaves what is near the axis as it is.
std::vector<double> ReadFocus(const SensorYaml& yaml, const Lens& lens) {
  if (yaml.Has("camera_matrix.data")) {
    const std::vector<double> K = yaml.Numbers("camera_matrix.data", 9);
    return {K[0], K[4], K[2], K[5]};
  }
  const bool is_double_sphere = lens.model == Lens::Model::kDoubleSphere;
  std::vector<double> f = yaml.Numbers("intrinsics", is_double_sphere ? 6 : 4);
  if (is_double_sphere) f.erase(f.begin(), f.begin() + 2);
  const double near_axis = is_double_sphere                          ? 1.0 / (1.0 + lens.k[0])
                           : lens.model == Lens::Model::kFieldOfView ? 2.0 * std::tan(lens.k[0] / 2.0) / lens.k[0]
                                                                     : 1.0;
  f[0] *= near_axis, f[1] *= near_axis;
  return f;
}

Camera ReadIntrinsics(const SensorYaml& yaml, const Lens& lens, const Transform& T_B_I) {
  Camera c;
  c.T_B_C = Inverse(T_B_I) * yaml.T_B_S();
  const std::vector<double> f = ReadFocus(yaml, lens);
  const bool has_size = !yaml.Has("image_width");  // in one key, else in OpenCV's two
  const std::vector<double> size = has_size ? yaml.Numbers("resolution", 2)
                                            : std::vector{yaml.Positive("image_width"), yaml.Positive("image_height")};
  if (!(size[0] >= 1.0 && size[1] >= 1.0 && size[0] < 1e5 && size[1] < 1e5))
    yaml.Fail(has_size ? "resolution" : "image_width", "must be in pixels");
  c.fx = f[0], c.fy = f[1], c.cx = f[2], c.cy = f[3];
  c.width = static_cast<int>(size[0]), c.height = static_cast<int>(size[1]);
  if (const std::string why = WhyNotInPixels(c); !why.empty())
    yaml.Fail(yaml.Name("intrinsics", "camera_matrix.data"), why);
  return c;
}

// Half-way to the image's edges any lens bends rays one to one, to less than 80°, and hardly together. Coefficients of another
// model, or in another order or unit, do not.
void CheckLens(const SensorYaml& yaml, const Lens& lens, const Camera& c) {
  constexpr double kLeast = 0.5;  // of the distance from the axis
  for (const Vec2& part : {Vec2(0.25, 0), Vec2(-0.25, 0), Vec2(0, 0.25), Vec2(0, -0.25)}) {
    const Vec2 pixel(c.cx + part.x() * c.width, c.cy + part.y() * c.height), x_d = c.Normalized(pixel);
    if (const auto x = lens.Undistort(x_d); x && x->norm() > kLeast * x_d.norm()) continue;
    yaml.Fail(lens.model == Lens::Model::kDoubleSphere ? "intrinsics" : CoefficientsKey(yaml),
              "no lens bends the ray of pixel (" + std::to_string(std::lround(pixel.x())) + ", " +
                  std::to_string(std::lround(pixel.y())) + ") so much; are the model and their order right?");
  }
}

fs::path ImageOfRow(const fs::path& folder, const CsvReader& csv) {
  const fs::path image = folder / "data" / std::string(csv.Cell("filename"));
  if (!fs::exists(image)) csv.Fail("there is no image " + image.string());
  return image;
}

// How much later the IMU's clock is than the camera's [s]: Kalibr's t_imu = t_cam + shift.
double ClockShift(const SensorYaml& yaml) {
  return yaml.Has("timeshift_cam_imu") ? yaml.Numbers("timeshift_cam_imu", 1)[0] : 0.0;
}

// The rate that the file names, or that of the images.
double CameraRate(const SensorYaml& yaml, size_t images, double duration) {
  if (yaml.Has("rate_hz") || images < 2) return yaml.Positive("rate_hz");
  return static_cast<double>(images - 1) / duration;
}

void NoteGaps(EurocFolder* result) {
  for (size_t i = 1; i < result->images.size(); ++i) {
    const double last = result->images[i - 1].t, t = result->images[i].t;
    if (t - last > 5.0 / result->recording.calibration.camera_rate)
      result->notes.push_back("cam0 has no image from " + Seconds(last) + " to " + Seconds(t) +
                              "; its tracks end there");
  }
}

void ReadCamera(const fs::path& mav0, const Transform& T_B_I, std::vector<LeftOut>* left_out, EurocFolder* result) {
  const SensorYaml yaml = ReadSensor(mav0, "cam0");
  const fs::path folder = mav0 / "cam0";
  Calibration& c = result->recording.calibration;
  result->lens = ReadLens(yaml);
  static_cast<Camera&>(c) = ReadIntrinsics(yaml, result->lens, T_B_I);
  CheckLens(yaml, result->lens, c);
  const double shift = ClockShift(yaml);

  const std::string path = (folder / "data.csv").string();
  CsvReader csv(path);
  const double end = result->recording.imu.back().t;
  double first = 0.0, last = 0.0;
  size_t count = 0;
  ReadEach(path, left_out, [&] {
    if (!csv.NextRow()) return false;
    last = SecondsAt(csv.Stamp(), result->recording.origin_ns) + shift;
    if (count++ == 0) first = last;
    if (last < 0.0 || last > end) return true;
    const fs::path image = ImageOfRow(folder, csv);
    result->images.push_back({last, image});
    return true;
  });
  if (count == 0) csv.Fail("at least one image is needed");
  if (result->images.empty()) {
    throw FileError(path + ": " + ClocksDiffer(first, last, result->recording.imu));
  }
  c.camera_rate = CameraRate(yaml, count, last - first);
  NoteGaps(result);
  if (const size_t left_out = count - result->images.size(); left_out > 0) {
    result->notes.push_back(std::to_string(left_out) + " images before or after the IMU's measurements are left out");
  }
}

// Each image of cam1 goes with cam0's of the same time; where the two are not synchronized, cam1 is of no use.
void ReadSecondCamera(const fs::path& mav0, const Transform& T_B_I, std::vector<LeftOut>* left_out,
                      EurocFolder* result) {
  constexpr double kSameTime = 1e-3;  // [s]: a camera that turns by 1 rad/s has turned by half a pixel
  const SensorYaml yaml = ReadSensor(mav0, "cam1");
  const fs::path folder = mav0 / "cam1";
  result->lens1 = ReadLens(yaml);
  const Camera camera = ReadIntrinsics(yaml, result->lens1, T_B_I), &first = result->recording.calibration;
  CheckLens(yaml, result->lens1, camera);
  if (camera.width != first.width || camera.height != first.height) {
    result->notes.push_back("cam1 is not used: its images are of another size than cam0's");
    return;
  }
  const double shift = ClockShift(yaml);
  const std::string path = (folder / "data.csv").string();
  CsvReader csv(path);
  auto image = result->images.begin();
  size_t count = 0;
  ReadEach(path, left_out, [&] {
    if (!csv.NextRow()) return false;
    const double t = SecondsAt(csv.Stamp(), result->recording.origin_ns) + shift;
    while (image != result->images.end() && image->t < t - kSameTime) ++image;
    if (image == result->images.end() || image->t > t + kSameTime) return true;
    image->path1 = ImageOfRow(folder, csv);
    ++count;
    return true;
  });
  if (count == 0) {
    result->notes.push_back("cam1 is not used: it has no image within 1 ms of one of cam0's");
    return;
  }
  result->recording.calibration.camera1 = camera;
  if (const size_t without = result->images.size() - count; without > 0) {
    result->notes.push_back(std::to_string(without) + " images of cam0 are without one of cam1 at the same time");
  }
}

// Empty if there are no rotations.
std::vector<StampedState> ReadTruth(const fs::path& path, const Transform& T_B_I, const Recording& recording,
                                    std::vector<LeftOut>* left_out) {
  if (IsTum(path.string())) return ReadTum(path.string(), recording.origin_ns, left_out);
  Transform T_S_I = T_B_I;
  if (const fs::path file = path.parent_path() / "sensor.yaml"; fs::exists(file)) {
    const SensorYaml yaml(file.string());
    if (yaml.Has("T_BS")) T_S_I = Inverse(yaml.T_B_S()) * T_B_I;
  }
  CsvReader csv(path.string());
  if (!csv.Has("q_w")) return {};
  const bool has_velocity = csv.Has("v_x") && IsIdentity(T_S_I), has_biases = csv.Has("b_w_x") && csv.Has("b_a_x");
  std::vector<StampedState> states;
  ReadPoses(path.string(), left_out, [&] {
    if (!csv.NextRow()) return false;
    StampedState state;
    state.t = SecondsAt(csv.Stamp(), recording.origin_ns);
    state.T_W_B = Transform{csv.Rotation(), csv.Vector("p_")} * T_S_I;
    if (has_velocity) state.v_W = csv.Vector("v_");
    if (has_biases) {
      state.b_g = csv.Vector("b_w_");
      state.b_a = csv.Vector("b_a_");
    }
    states.push_back(state);
    return true;
  });
  CompleteTruth(csv, has_velocity, &states);
  return states;
}

// The best that there is: the batch's states, the poses of a motion capture system, or a file of the user's own.
void FindTruth(const fs::path& mav0, const Transform& T_B_I, std::vector<LeftOut>* left_out, EurocFolder* result) {
  std::vector<StampedState>& truth = result->recording.truth;
  for (const char* name :
       {"state_groundtruth_estimate0/data.csv", "vicon0/data.csv", "mocap0/data.csv", "groundtruth.csv",
        "groundtruth.txt", "gt.txt", "../groundtruth.csv", "../groundtruth.txt", "../gt.txt", "leica0/data.csv"}) {
    const fs::path file = (mav0 / name).lexically_normal();
    if (!fs::exists(file)) continue;
    truth = ReadTruth(file, T_B_I, result->recording, left_out);
    std::string note = (file.filename() == "data.csv" ? file.parent_path() : file).filename().string();
    if (truth.empty()) {
      note = "none, since " + note + " has no rotations (columns q_w, q_x, q_y, q_z)";
    } else if (truth.front().t >= result->recording.imu.back().t || truth.back().t <= 0.0) {
      truth.clear();
      note += " has no time in common with the IMU, so there is none";
    } else {
      CheckTruth(file.string(), left_out, &result->recording);
    }
    return result->notes.push_back("ground truth: " + note);
  }
  result->notes.push_back("ground truth: none");
}

}  // namespace

EurocFolder ReadEurocFolder(const fs::path& folder, bool mono, std::vector<LeftOut>* left_out) {
  const fs::path mav0 = FindMav0(folder);
  EurocFolder result;
  const Transform T_B_I = ReadImu(mav0, left_out, &result);
  ReadCamera(mav0, T_B_I, left_out, &result);
  if (!mono && fs::exists(mav0 / "cam1")) ReadSecondCamera(mav0, T_B_I, left_out, &result);
  FindTruth(mav0, T_B_I, left_out, &result);
  return result;
}

}  // namespace ch5
