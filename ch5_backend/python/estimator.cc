// The estimator and its recordings in the Python module.
#include <pybind11/eigen.h>
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include <cstring>

#include "ch5_backend/files/recording_file.h"
#include "ch5_backend/python/shared.h"
#include "ch5_backend/window/estimator.h"

namespace {

py::dict Describe(const ch5::StampedState& state) {
  return py::dict(py::arg("t") = state.t, py::arg("p") = state.T_W_B.p,
                  py::arg("q") = Eigen::Vector4d(state.T_W_B.q.coeffs()), py::arg("v") = state.v_W,
                  py::arg("b_a") = state.b_a, py::arg("b_g") = state.b_g);
}

py::object DescribeIf(const std::optional<ch5::StampedState>& state) {
  return state ? py::object(Describe(*state)) : py::none();
}

// An estimator, and the state of its last image.
class PyEstimator : private OneThread {
 public:
  PyEstimator(const ch5::Calibration& calibration, const std::string& policy, bool covariance, bool estimate_extrinsic,
              bool estimate_time_offset, double time_offset)
      : estimator_(Options(calibration, covariance, estimate_extrinsic, estimate_time_offset, time_offset),
                   Policy(policy)) {}

  void AddImu(double t, const ch5::Vec3& acceleration, const ch5::Vec3& gyroscope) {
    const auto lock = Use("Estimator");
    estimator_.AddImu({t, acceleration, gyroscope});
  }
  void AddImuRows(const Rows& rows) {
    const auto lock = Use("Estimator");
    if (rows.ndim() != 2 || rows.shape(1) != 7)
      throw std::invalid_argument("add_imu: rows of t, acceleration, gyroscope: n x 7");
    for (py::ssize_t k = 0; k < rows.shape(0); ++k) {
      const double* row = rows.data(k);
      estimator_.AddImu({row[0], {row[1], row[2], row[3]}, {row[4], row[5], row[6]}});
    }
  }

  py::dict AddFrame(double t, const py::object& given_ids, const Rows& points) {
    const auto lock = Use("Estimator");
    const auto numbers = py::array::ensure(given_ids);
    if (numbers && numbers.size() > 0 && !std::strchr("iu", numbers.dtype().kind()))
      throw std::invalid_argument("add_frame: ids are whole numbers");
    const py::array_t<int64_t, py::array::c_style | py::array::forcecast> ids(numbers);
    const py::ssize_t n = ids.size();
    if (ids.ndim() != 1 || (n > 0 && (points.ndim() != 2 || points.shape(0) != n || points.shape(1) != 2)))
      throw std::invalid_argument("add_frame: one id a row of points");
    ch5::Image image{t, {}};
    for (py::ssize_t k = 0; k < n; ++k) {
      const auto id = static_cast<int>(ids.data()[k]);
      if (id != ids.data()[k])
        throw std::invalid_argument("add_frame: the id " + std::to_string(ids.data()[k]) +
                                    " does not fit into 32 bits");
      image.tracks.push_back({id, ch5::Vec2(points.data(k)[0], points.data(k)[1])});
    }
    const auto add = [&] {
      const py::gil_scoped_release unlocked;
      return estimator_.AddFrame(image);
    };
    const ch5::FrameReport report = add();
    const char* status[] = {"starting", "tracking", "restarted"};
    return py::dict(py::arg("status") = status[static_cast<int>(report.status)], py::arg("segment") = report.segment,
                    py::arg("message") = report.message, py::arg("landmarks") = report.landmarks,
                    py::arg("state") = DescribeIf(report.state),
                    py::arg("covariance") = report.covariance ? py::cast(report.covariance->state) : py::none());
  }

  py::object PredictAt(double t) {
    const auto lock = Use("Estimator");
    return DescribeIf(estimator_.PredictAt(t));
  }
  double TimeOffset() {
    const auto lock = Use("Estimator");
    return estimator_.TimeOffset();
  }

 private:
  static ch5::EstimatorOptions Options(const ch5::Calibration& calibration, bool covariance, bool estimate_extrinsic,
                                       bool estimate_time_offset, double time_offset) {
    ch5::EstimatorOptions options;
    options.calibration = calibration;
    options.report_covariance = covariance;
    options.estimate_extrinsic = estimate_extrinsic;
    options.estimate_time_offset = estimate_time_offset;
    options.time_offset = time_offset;
    return options;
  }
  static std::unique_ptr<ch5::WindowPolicy> Policy(const std::string& name) {
    if (name == "vins") return ch5::MakeVinsPolicy();
    if (name == "okvis") return ch5::MakeOkvisPolicy();
    throw std::invalid_argument("Estimator: policy is '" + name + "', expected 'vins' or 'okvis'");
  }

  ch5::Estimator estimator_;
};

/// (calibration, IMU, images) of a recording's folder.
py::tuple ReadRecording(const std::filesystem::path& folder) {
  const ch5::Recording recording = ch5::ReadRecording(folder.string());
  ch5::MatXX imu(recording.imu.size(), 7);
  for (size_t k = 0; k < recording.imu.size(); ++k) {
    imu.row(static_cast<Eigen::Index>(k)) << recording.imu[k].t, recording.imu[k].acceleration.transpose(),
        recording.imu[k].gyroscope.transpose();
  }
  py::list frames;
  for (const ch5::Image& image : recording.images) {
    std::vector<int> ids;
    Eigen::Matrix<double, Eigen::Dynamic, 2> points(image.tracks.size(), 2);
    for (size_t k = 0; k < image.tracks.size(); ++k) {
      ids.push_back(image.tracks[k].id);
      points.row(static_cast<Eigen::Index>(k)) = image.tracks[k].x;
    }
    frames.append(py::make_tuple(image.t, ids, points));
  }
  return py::make_tuple(recording.calibration, imu, frames);
}

}  // namespace

void DefineEstimator(py::module_& module) {
  py::class_<ch5::Calibration>(module, "Calibration", "Camera and IMU.")
      .def(py::init<>())
      .def_readwrite("fx", &ch5::Calibration::fx)
      .def_readwrite("fy", &ch5::Calibration::fy)
      .def_readwrite("gravity", &ch5::Calibration::gravity)
      .def(
          "set_extrinsic",
          [](ch5::Calibration& c, const ch5::Vec3& p, const Eigen::Vector4d& q) {
            c.T_B_C = {ch5::Qd(q[3], q[0], q[1], q[2]), p};
          },
          py::arg("p_B_C"), py::arg("q_B_C"))
      .def(
          "set_noise",
          [](ch5::Calibration& c, double a, double g, double a_walk, double g_walk) {
            c.noise = {a, g, a_walk, g_walk, true};
          },
          py::arg("accelerometer"), py::arg("gyroscope"), py::arg("accelerometer_walk"), py::arg("gyroscope_walk"));
  py::class_<PyEstimator>(module, "Estimator", "Visual-inertial odometry by VINS's window or OKVIS's.")
      .def(py::init<const ch5::Calibration&, const std::string&, bool, bool, bool, double>(), py::arg("calibration"),
           py::arg("policy") = "vins", py::arg("covariance") = false, py::arg("estimate_extrinsic") = false,
           py::arg("estimate_time_offset") = false, py::arg("time_offset") = 0.0)
      .def("add_imu", &PyEstimator::AddImu, py::arg("t"), py::arg("acceleration"), py::arg("gyroscope"))
      .def("add_imu", &PyEstimator::AddImuRows, py::arg("rows"), "Many at once: rows of t, acceleration, gyroscope.")
      .def("add_frame", &PyEstimator::AddFrame, py::arg("t"), py::arg("ids"), py::arg("points"),
           "Tracks on the normalized plane, an id a row. Other threads of Python go on meanwhile.")
      .def("predict_at", &PyEstimator::PredictAt, py::arg("t"), "The state at t by the IMU, or None.")
      .def_property_readonly("time_offset", &PyEstimator::TimeOffset, "By which the camera's clock is late [s].");
  module.def("read_recording", &ReadRecording, py::arg("folder"),
             "calibration, IMU as rows of t, acceleration, gyroscope, and images as tuples (t, ids, points).");
}
