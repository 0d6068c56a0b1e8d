// The writing half of recording_file.h.

#include "ch5_backend/files/recording_file.h"
#include "ch5_backend/files/tables/text_writer.h"
#include "ch5_backend/files/tables/trajectory_file.h"

namespace ch5 {
namespace {

// `form` with each % replaced by the next of the numbers.
std::string Fill(std::string_view form, std::initializer_list<double> numbers) {
  std::string text;
  const double* next = numbers.begin();
  for (const char c : form) {
    if (c == '%') {
      AppendNumber(*next++, ' ', &text);
      text.pop_back();
    } else {
      text += c;
    }
  }
  return text;
}

// @param rate  a line of its own, which camera 1 does not have
std::string FormatCamera(const Camera& c, const std::string& rate) {
  const auto& [q, p] = c.T_B_C;
  return Fill(R"(  intrinsics: {fx: %, fy: %, cx: %, cy: %}  # [px]
  resolution: [%, %]                        # [px]
)",
              {c.fx, c.fy, c.cx, c.cy, 1.0 * c.width, 1.0 * c.height}) +
         rate +
         Fill(R"(  # T_B_C maps camera coordinates into the body (= IMU) frame.
  p_B_C: [%, %, %]                          # [m]
  q_B_C: {w: %, x: %, y: %, z: %}           # Hamilton
)",
              {p.x(), p.y(), p.z(), q.w(), q.x(), q.y(), q.z()});
}

std::string FormatCalibration(const Calibration& c) {
  std::string text = "camera:\n" + FormatCamera(c, Fill("  rate_hz: %\n", {c.camera_rate}));
  if (c.camera1) text += "camera1:  # takes its images at the same times\n" + FormatCamera(*c.camera1, "");
  return text + Fill(R"(imu:
  rate_hz: %
  gyroscope_noise_density: %      # [rad/s/sqrt(Hz)]
  gyroscope_random_walk: %        # [rad/s^2/sqrt(Hz)]
  accelerometer_noise_density: %  # [m/s^2/sqrt(Hz)]
  accelerometer_random_walk: %    # [m/s^3/sqrt(Hz)]
  gravity: %                      # [m/s^2], along -z of the world frame
)",
                     {c.imu_rate, c.noise.gyroscope, c.noise.gyroscope_walk, c.noise.accelerometer,
                      c.noise.accelerometer_walk, c.gravity});
}

std::string FormatImu(const Recording& recording) {
  std::string text = "#timestamp [ns],w_x [rad/s],w_y,w_z,a_x [m/s^2],a_y,a_z\n";
  for (const auto& [t, a, w] : recording.imu) {
    text += std::to_string(NanosecondsAt(t, recording.OriginAt(t))) + ',';
    for (const double x : {w.x(), w.y(), w.z(), a.x(), a.y(), a.z()}) AppendNumber(x, ',', &text);
    text.back() = '\n';
  }
  return text;
}

std::string FormatTracks(const Recording& recording) {
  const bool has_two = recording.calibration.camera1.has_value();
  std::string text = "#timestamp [ns],track_id,x [normalized],y [normalized]";
  text += has_two ? ",camera\n" : "\n";
  for (const Image& frame : recording.images) {
    const std::string stamp = std::to_string(NanosecondsAt(frame.t, recording.OriginAt(frame.t))) + ',';
    const auto add = [&](const std::vector<TrackedPoint>& tracks, const char* end) {
      for (const TrackedPoint& track : tracks) {
        text += stamp;
        AppendNumber(track.id, ',', &text);
        AppendNumber(track.x.x(), ',', &text);
        AppendNumber(track.x.y(), '\n', &text);
        text.replace(text.size() - 1, 1, end);
      }
    };
    add(frame.tracks, has_two ? ",0\n" : "\n");
    if (has_two) add(frame.tracks1, ",1\n");
  }
  return text;
}

}  // namespace

void WriteRecording(const Recording& recording, const std::filesystem::path& folder) {
  FileBatch batch;
  batch.Add(folder / "calibration.yaml", FormatCalibration(recording.calibration));
  batch.Add(folder / "imu.csv", FormatImu(recording));
  batch.Add(folder / "tracks.csv", FormatTracks(recording));
  if (!recording.truth.empty()) {
    batch.Add(folder / "groundtruth.csv", FormatEuroc(recording.truth, recording.origin_ns));
  }
  batch.Commit();
}

}  // namespace ch5
