#include "tests/track/textured_room.h"

#include <png.h>

#include <cmath>
#include <stdexcept>

#include "ch5_backend/files/tables/text_writer.h"
#include "ch5_backend/files/tables/trajectory_file.h"

namespace ch5 {
namespace {

namespace fs = std::filesystem;

const Vec3 kLow(-5, -5, -2), kHigh(5, 5, 3);
constexpr int64_t kOrigin = 1'500'000'000'000'000'000;

uint32_t Hash(uint32_t a, uint32_t b, uint32_t c) {
  uint32_t h = a * 0x9E3779B1u ^ b * 0x85EBCA77u ^ c * 0xC2B2AE3Du;
  h = (h ^ (h >> 15)) * 0x2C1B3C6Du;
  h = (h ^ (h >> 12)) * 0x297A2D39u;
  return h ^ (h >> 15);
}

// Random values −1 … 1 on a grid of unit cells, smooth in between.
double Noise(double u, double v, uint32_t seed) {
  const double fu = std::floor(u), fv = std::floor(v);
  const auto at = [&](int du, int dv) {
    return Hash(static_cast<uint32_t>(static_cast<int>(fu) + du), static_cast<uint32_t>(static_cast<int>(fv) + dv),
                seed) /
               2147483648.0 -
           1.0;
  };
  const auto smooth = [](double s) { return s * s * (3.0 - 2.0 * s); };
  const double a = smooth(u - fu), b = smooth(v - fv);
  return (1 - b) * ((1 - a) * at(0, 0) + a * at(1, 0)) + b * ((1 - a) * at(0, 1) + a * at(1, 1));
}

// The paint: blots of 40, 15 and 6 cm, their edges steep as those of real things.
double Paint(const Vec3& point, int wall) {
  const int axis = wall / 2;
  const double u = point[(axis + 1) % 3], v = point[(axis + 2) % 3];
  const auto seed = static_cast<uint32_t>(wall);
  const double blots = 1.0 * Noise(u / 0.4, v / 0.4, seed) + 0.8 * Noise(u / 0.15, v / 0.15, seed + 10) +
                       0.5 * Noise(u / 0.06, v / 0.06, seed + 20);
  return 128.0 + 90.0 * std::tanh(1.5 * blots);
}

// The distance along the ray, and the wall: 2 · axis, and 1 more on the high side.
std::pair<double, int> Hit(const Vec3& from, const Vec3& direction) {
  std::pair<double, int> nearest{1e9, 0};
  for (int axis = 0; axis < 3; ++axis) {
    const bool high = direction[axis] > 0.0;
    const double distance = ((high ? kHigh : kLow)[axis] - from[axis]) / direction[axis];
    if (distance < nearest.first) nearest = {distance, 2 * axis + high};
  }
  return nearest;
}

void WritePng(const std::vector<uint8_t>& gray, const Camera& c, const fs::path& file) {
  png_image png{};
  png.version = PNG_IMAGE_VERSION;
  png.width = static_cast<png_uint_32>(c.width);
  png.height = static_cast<png_uint_32>(c.height);
  png.format = PNG_FORMAT_GRAY;
  png.flags = PNG_IMAGE_FLAG_FAST;
  if (!png_image_write_to_file(&png, file.c_str(), 0, gray.data(), 0, nullptr)) throw std::runtime_error(png.message);
}

// Numbers separated by commas.
std::string List(std::initializer_list<double> numbers) {
  std::string text;
  for (const double number : numbers) AppendNumber(number, ',', &text);
  text.pop_back();
  return text;
}

std::string CameraYaml(const Camera& c, double rate, const Lens& lens) {
  const Mat33 R = c.T_B_C.q.toRotationMatrix();
  const Vec3& p = c.T_B_C.p;
  std::string T;
  for (int i = 0; i < 3; ++i) T += List({R(i, 0), R(i, 1), R(i, 2), p[i]}) + ",\n         ";
  const bool is_sphere = lens.model == Lens::Model::kDoubleSphere, is_view = lens.model == Lens::Model::kFieldOfView;
  const bool is_wide = lens.model == Lens::Model::kEquidistant;
  // Kalibr's files have the published focal lengths; see lens.h.
  const double scale = is_sphere ? 1.0 + lens.k[0] : is_view ? lens.k[0] / (2.0 * std::tan(lens.k[0] / 2.0)) : 1.0;
  const std::string before = is_sphere ? List({lens.k[0], lens.k[1]}) + "," : "";
  const std::string coefficients = is_view ? List({lens.k[0]}) : List({lens.k[0], lens.k[1], lens.k[2], lens.k[3]});
  return "%YAML:1.0\nsensor_type: camera\nT_BS:\n  cols: 4\n  rows: 4\n  data: [" + T +
         "0.0, 0.0, 0.0, 1.0]\nrate_hz: " + List({rate}) + "\nresolution: [" + List({1.0 * c.width, 1.0 * c.height}) +
         "]\ncamera_model: " + (is_sphere ? "ds" : "pinhole") + "\nintrinsics: [" + before +
         List({scale * c.fx, scale * c.fy, c.cx, c.cy}) + "] # fu, fv, cu, cv\ndistortion_model: " +
         (is_wide     ? "equidistant"
          : is_view   ? "fov"
          : is_sphere ? "none"
                      : "radial-tangential") +
         "\ndistortion_coefficients: [" + coefficients + "]\n";
}

std::string ImuYaml(const Calibration& c) {
  return "%YAML:1.0\nsensor_type: imu\nrate_hz: " + List({c.imu_rate}) +
         "\ngyroscope_noise_density: " + List({c.noise.gyroscope}) +
         "\ngyroscope_random_walk: " + List({c.noise.gyroscope_walk}) +
         "\naccelerometer_noise_density: " + List({c.noise.accelerometer}) +
         "\naccelerometer_random_walk: " + List({c.noise.accelerometer_walk}) + "\n";
}

}  // namespace

Vec3 WallPoint(const Vec3& from, const Vec3& direction) { return from + Hit(from, direction).first * direction; }

RoomRenderer::RoomRenderer(const Camera& camera, const Lens& lens) : camera_(camera) {
  for (int v = 0; v < camera.height; ++v) {
    for (int u = 0; u < camera.width; ++u) {
      const std::optional<Vec2> x = lens.Undistort(camera.Normalized({u, v}));
      rays_.push_back(x ? Vec3(x->homogeneous()) : Vec3::Zero());
    }
  }
}

std::vector<uint8_t> RoomRenderer::Render(const Transform& T_W_B, uint32_t seed) const {
  const Transform& T_B_C = camera_.T_B_C;
  const Transform T_W_C = {T_W_B.q * T_B_C.q, T_W_B.p + T_W_B.q * T_B_C.p};
  std::vector<uint8_t> gray(rays_.size());
  const Mat33 R = T_W_C.q.toRotationMatrix();
  for (size_t i = 0; i < rays_.size(); ++i) {
    if (rays_[i].z() == 0.0) continue;
    const Vec3 direction = R * rays_[i];
    const auto [distance, wall] = Hit(T_W_C.p, direction);
    const uint32_t h = Hash(static_cast<uint32_t>(i), seed, 99);
    // Four bytes' sum: nearly normal, σ = 148.
    const double noise = 1.0 * (h & 255) + (h >> 8 & 255) + (h >> 16 & 255) + (h >> 24) - 510.0;
    const double value = Paint(T_W_C.p + distance * direction, wall) + 2.0 / 148.0 * noise;
    gray[i] = static_cast<uint8_t>(std::clamp(value + 0.5, 0.0, 255.0));
  }
  return gray;
}

namespace {

// Both cameras have one lens, but not one noise.
void WriteImages(const Trajectory& trajectory, const Camera& camera, const RenderOptions& options, uint32_t number,
                 const fs::path& folder) {
  const double rate = options.calibration.camera_rate;
  fs::create_directories(folder / "data");
  WriteFileAtomically(folder / "sensor.yaml", CameraYaml(camera, rate, options.lens));
  const RoomRenderer renderer(camera, options.lens);
  std::string images = "#timestamp [ns],filename\n";
  const auto count = static_cast<uint32_t>(options.path.duration * rate) + 1;
  for (uint32_t i = 0; i < count; ++i) {
    const double t = i / rate;
    const std::string stamp = std::to_string(NanosecondsAt(t, kOrigin));
    WritePng(renderer.Render(trajectory.At(t).T_W_B, i + 100'000 * number), camera, folder / "data" / (stamp + ".png"));
    images += stamp + "," + stamp + ".png\n";
  }
  WriteFileAtomically(folder / "data.csv", images);
}

}  // namespace

void WriteRenderedFlight(const RenderOptions& options, const fs::path& folder) {
  const Calibration& c = options.calibration;
  const Trajectory trajectory = Handheld(options.path);
  const SimulatedImu imu = SimulateImu(trajectory, c, {});
  std::string table =
      "#timestamp [ns],w_RS_S_x [rad s^-1],w_RS_S_y [rad s^-1],w_RS_S_z [rad s^-1],a_RS_S_x [m s^-2],"
      "a_RS_S_y [m s^-2],a_RS_S_z [m s^-2]\n";
  for (const auto& [t, a, w] : imu.measurements) {
    table += std::to_string(NanosecondsAt(t, kOrigin)) + "," + List({w.x(), w.y(), w.z(), a.x(), a.y(), a.z()}) + "\n";
  }
  const fs::path mav0 = folder / "mav0";
  WriteFileAtomically(mav0 / "imu0" / "data.csv", table);
  WriteFileAtomically(mav0 / "imu0" / "sensor.yaml", ImuYaml(c));
  if (options.with_truth) {
    WriteFileAtomically(mav0 / "state_groundtruth_estimate0" / "data.csv", FormatEuroc(imu.truth, kOrigin));
  }
  WriteImages(trajectory, c, options, 0, mav0 / "cam0");
  if (c.camera1) WriteImages(trajectory, *c.camera1, options, 1, mav0 / "cam1");
}

}  // namespace ch5
