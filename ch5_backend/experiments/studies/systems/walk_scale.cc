// Whose is the scale of Tango's walk? Its truth is taken for what happened, and the observations, the IMU, or both are
// replaced by what would have been measured then.
#include <Eigen/LU>

#include "ch5_backend/evaluate/trajectory_error.h"
#include "ch5_backend/experiments/studies/systems/system_studies.h"
#include "ch5_backend/files/recording_file.h"
#include "ch5_backend/simulate/random.h"
#include "ch5_backend/window/batch.h"
#include "ch5_backend/window/landmarks.h"
#include "ch5_backend/window/prediction.h"
#include "ch5_backend/window/start_values.h"

namespace ch5 {
namespace {

constexpr double kPixels = 0.8;  // the publisher's median error of a triangulated track is 0.78 px

// The truth of each image, its bias zero where the measurements have none.
std::vector<StampedState> StatesOf(const Recording& recording, bool gyroscope, bool accelerometer) {
  std::vector<StampedState> states;
  for (const Image& image : recording.images) {
    states.push_back(*StateAt(recording.truth, image.t));
    if (gyroscope) states.back().b_g.setZero();
    if (accelerometer) states.back().b_a.setZero();
  }
  return states;
}

// Every track is that of the point where its rays from the true poses meet.
void SimulateObservations(int seed, Recording* recording) {
  Window window;
  SetCalibration(EstimatorOptions{recording->calibration}, &window);
  for (const StampedState& state : StatesOf(*recording, false, false)) {
    Frame frame;
    frame.id = static_cast<int>(window.frames.size());
    frame.pose = std::make_shared<VertexPose>(state.T_W_B.q, state.T_W_B.p);
    AppendImage(frame.id, recording->images[window.frames.size()], &window);
    window.frames.push_back(std::move(frame));
  }
  TriangulateLandmarks(&window);
  const double pixel = 1.0 / recording->calibration.FocalLength();
  RemoveOutliers(3.0 * pixel, &window);
  for (Image& image : recording->images) image.tracks.clear();
  Random random(static_cast<uint64_t>(seed));
  for (const auto& [id, landmark] : window.landmarks) {
    if (landmark.seen.size() < 2) continue;
    const Vec3 p_W = LandmarkInWorld(window, landmark);
    for (const WindowObservation& seen : landmark.seen) {
      const VertexPose& pose = *window.frames[static_cast<size_t>(seen.frame)].pose;
      const Vec3 p_B = pose.q().conjugate() * (p_W - pose.p());
      const Vec3 p_C = window.T_B_C().q.conjugate() * (p_B - window.T_B_C().p);
      const Vec2 noise(random.Normal(), random.Normal());
      recording->images[static_cast<size_t>(seen.frame)].tracks.push_back(
          {id, p_C.hnormalized() + kPixels * pixel * noise});
    }
  }
}

// α, β and γ from one state to the next by the states, less those by the measurements.
Vec9 ReadingError(const StampedState& from, const StampedState& to, const Preintegration& imu, double gravity) {
  const double t = imu.SumDt();
  const Vec3 G(0, 0, gravity);
  const Qd inverse = from.T_W_B.q.conjugate();
  Vec9 error;
  error << inverse * (0.5 * t * t * G + to.T_W_B.p - from.T_W_B.p - t * from.v_W) - imu.Alpha(),
      inverse * (t * G + to.v_W - from.v_W) - imu.Beta(), LogSO3(imu.Gamma().conjugate() * inverse * to.T_W_B.q);
  return error;
}

/// The x at which error(x) = 0, by Newton's steps with differences; only what the named sensors can correct is moved.
Vec9 Root(const std::function<Vec9(const Vec9&)>& error, bool gyroscope, bool accelerometer) {
  Vec9 x = Vec9::Zero();
  for (int iteration = 0; iteration < 3; ++iteration) {
    const Vec9 e = error(x);
    Eigen::Matrix<double, 9, 9> J;
    for (int column = 0; column < 9; ++column) J.col(column) = (error(x + 1e-4 * Vec9::Unit(column)) - e) / 1e-4;
    const Vec3 turn = gyroscope ? Vec3(J.bottomRightCorner<3, 3>().inverse() * e.tail<3>()) : Vec3::Zero();
    x.tail<3>() -= turn;
    if (accelerometer)
      x.head<6>() -= J.topLeftCorner<6, 6>().inverse() * (e.head<6>() - J.topRightCorner<6, 3>() * turn);
  }
  return x;
}

/// A reading between two of the recording's, as it was recorded, without the biases of the sensors that are made consistent.
ImuMeasurement ReadingAt(double t, bool gyroscope, bool accelerometer, const Recording& recording) {
  const auto next = std::lower_bound(recording.imu.begin() + 1, std::prev(recording.imu.end()), t,
                                     [](const ImuMeasurement& measurement, double at) { return measurement.t < at; });
  const ImuMeasurement &a = *std::prev(next), &b = *next;
  const double u = (t - a.t) / (b.t - a.t);
  ImuMeasurement measurement{t, (1.0 - u) * a.acceleration + u * b.acceleration,
                             (1.0 - u) * a.gyroscope + u * b.gyroscope};
  const StampedState truth = *StateAt(recording.truth, t);
  if (gyroscope) measurement.gyroscope -= truth.b_g;
  if (accelerometer) measurement.acceleration -= truth.b_a;
  return measurement;
}

// Takes the truth's bias from the measurements and adds what makes each interval lead from state to state: two shapes for
// the accelerometer and one for the gyroscope, all zero at the images.
void MakeConsistent(bool gyroscope, bool accelerometer, Recording* recording) {
  const std::vector<StampedState> states = StatesOf(*recording, gyroscope, accelerometer);
  const auto recorded = [&](double t) { return ReadingAt(t, gyroscope, accelerometer, *recording); };
  std::vector<ImuMeasurement> all;
  auto next = recording->imu.begin();
  for (size_t k = 1; k < states.size(); ++k) {
    const double t0 = states[k - 1].t, t1 = states[k].t;
    std::vector<ImuMeasurement> base{recorded(t0)};
    for (; next != recording->imu.end() && next->t < t1 - 1e-9; ++next) {
      if (next->t > t0 + 1e-9) base.push_back(recorded(next->t));
    }
    base.push_back(recorded(t1));
    const auto corrected = [&](const Vec9& x) {
      std::vector<ImuMeasurement> measurements = base;
      for (ImuMeasurement& measurement : measurements) {
        const double u = (measurement.t - t0) / (t1 - t0), shape = u * (1.0 - u);
        measurement.acceleration += shape * (x.head<3>() + (1.0 - 2.0 * u) * x.segment<3>(3));
        measurement.gyroscope += shape * x.tail<3>();
      }
      return measurements;
    };
    const auto error = [&](const Vec9& x) -> Vec9 {
      const auto imu = IntegrateFrom(states[k - 1], corrected(x), t1, recording->calibration.noise);
      return ReadingError(states[k - 1], states[k], *imu, recording->calibration.gravity);
    };
    const std::vector<ImuMeasurement> measurements = corrected(Root(error, gyroscope, accelerometer));
    all.insert(all.end(), measurements.begin(), std::prev(measurements.end()));
    if (k + 1 == states.size()) all.push_back(measurements.back());
  }
  recording->imu = all;
}

}  // namespace

CsvTable WalkScaleTable(int trial, const std::filesystem::path& data) {
  CsvTable table("observations,gyroscope,accelerometer,trial,ate_m,scale_error,cost");
  const Recording walk = ReadRecording(data / "tango_walk");
  const auto name = [](bool replaced) { return replaced ? "by the truth" : "recorded"; };
  for (const bool observations : {false, true}) {
    Recording seen = walk;
    if (observations) SimulateObservations(trial + 1, &seen);
    for (const int replaced : {0, 1, 2, 3}) {
      const bool gyroscope = replaced % 2 == 1, accelerometer = replaced > 1;
      Recording recording = seen;
      if (gyroscope || accelerometer) MakeConsistent(gyroscope, accelerometer, &recording);
      const EstimatorOptions options{recording.calibration};
      const BatchResult result =
          SolveBatch(options, recording.images, StatesOf(recording, gyroscope, accelerometer), recording.imu);
      const auto found = CompareTrajectories(result.states, recording.truth);
      table.Row(name(observations), name(gyroscope), name(accelerometer), trial, found->position_rmse,
                found->scale - 1.0, result.solve.final_cost);
    }
  }
  return table;
}

}  // namespace ch5
