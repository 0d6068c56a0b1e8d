/// The Python module ch5: graphs with residuals in Python, solving, marginalizing, and the estimator. NumPy in and out.
#include <pybind11/eigen.h>
#include <pybind11/functional.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include "ch5_backend/files/recording_file.h"
#include "ch5_backend/marginalize/marginalize.h"
#include "ch5_backend/sparse/joint_covariance.h"
#include "ch5_backend/sparse/sparse_optimizer.h"
#include "ch5_backend/types/pose_graph/edge_between.h"
#include "ch5_backend/version.h"
#include "ch5_backend/window/estimator.h"

namespace py = pybind11;

namespace {

// A base class, so that it is there before the vertex.
struct Memory {
  ch5::VecX now, before;
};

// Numbers that add, as many as are given.
class VertexNumbers : private Memory, public ch5::Vertex {
 public:
  VertexNumbers(const ch5::VecX& x, bool landmark)
      : Memory{x, x},
        Vertex(static_cast<int>(x.size()), static_cast<int>(x.size()), now.data(), before.data(),
               landmark ? ch5::Role::kLandmark : ch5::Role::kPose) {}
  void Plus(const double* delta) override { now += Eigen::Map<const ch5::VecX>(delta, now.size()); }
  ch5::VecX Minus(const ch5::VecX& x0) const override { return now - x0; }
  std::string TypeInfo() const override { return "Vector"; }
};

// A residual in Python, differentiated numerically; or residual and Jacobians, if `jacobians` is there.
class EdgeFunction : public ch5::Edge {
 public:
  EdgeFunction(std::vector<std::shared_ptr<ch5::Vertex>> vertices, py::function residual, int size,
               py::object jacobians)
      : Edge(size, std::move(vertices), nullptr, nullptr),
        residual_function_(std::move(residual)),
        jacobian_function_(std::move(jacobians)),
        r_(ch5::VecX::Zero(size)),
        W_(ch5::MatXX::Identity(size, size)) {
    SetMemory(r_.data(), W_.data());
  }

  void ComputeResidual() override { Take(residual_function_(*Arguments()), &r_); }
  void ComputeJacobians() override {
    if (jacobian_function_.is_none()) return Edge::ComputeJacobians();
    TakeJacobians();
    const py::object given = jacobian_function_(*Arguments());
    if (!py::isinstance<py::sequence>(given) || py::len(given) != J_.size()) {
      throw std::invalid_argument(Name() + ": its jacobians are no list of " + std::to_string(J_.size()) +
                                  " matrices, one a vertex");
    }
    for (size_t i = 0; i < J_.size(); ++i) Take(given[py::int_(i)], &J_[i]);
  }
  std::string TypeInfo() const override { return "Edge of Python"; }

 private:
  py::tuple Arguments() const {
    py::tuple x(vertices_.size());
    for (size_t i = 0; i < vertices_.size(); ++i) x[i] = ch5::VecX(vertices_[i]->Parameters());
    return x;
  }
  // What a function has returned; for a single number a float will do.
  template <typename Matrix>
  void Take(const py::handle& given, Matrix* own) const {
    if (PyFloat_Check(given.ptr()) && own->size() == 1) return void(own->setConstant(given.cast<double>()));
    const auto size = [](Eigen::Index rows, Eigen::Index columns) {
      return std::to_string(rows) + "x" + std::to_string(columns) + " numbers";
    };
    std::string got = py::str(py::type::of(given).attr("__name__"));
    try {
      const auto numbers = given.cast<Matrix>();
      got = size(numbers.rows(), numbers.cols());
      if (numbers.rows() == own->rows() && numbers.cols() == own->cols()) return void(*own = numbers);
    } catch (const py::cast_error&) {  // got is its type
    }
    throw std::invalid_argument(Name() + ": its function returned " + got + ", expected " +
                                size(own->rows(), own->cols()));
  }
  void TakeJacobians() const override {
    if (!J_.empty()) return;
    for (const auto& vertex : vertices_) J_.emplace_back(ch5::MatXX::Zero(r_.size(), vertex->LocalDimension()));
    for (size_t i = 0; i < J_.size(); ++i) jacobians_[i] = J_[i].data();
  }

  py::function residual_function_;
  py::object jacobian_function_;
  ch5::VecX r_;
  ch5::MatXX W_;
  mutable std::vector<ch5::MatXX> J_;
};

py::dict Solve(ch5::Graph* graph, int max_iterations, double cost_tolerance) {
  ch5::SolveOptions options;
  options.max_iterations = max_iterations;
  options.cost_tolerance = cost_tolerance;
  const ch5::Summary summary = ch5::SparseOptimizer(graph).Solve(options);
  ch5::VecX cost(summary.trace.size()), lambda(summary.trace.size());
  for (size_t k = 0; k < summary.trace.size(); ++k) {
    cost[k] = summary.trace[k].cost;
    lambda[k] = summary.trace[k].lambda;
  }
  return py::dict(py::arg("message") = summary.message, py::arg("converged") = ch5::IsConverged(summary.termination),
                  py::arg("initial_cost") = summary.initial_cost, py::arg("final_cost") = summary.final_cost,
                  py::arg("iterations") = summary.iterations, py::arg("cost") = cost, py::arg("lambda") = lambda);
}

py::dict Describe(const ch5::StampedState& state) {
  return py::dict(py::arg("t") = state.t, py::arg("p") = state.T_W_B.p,
                  py::arg("q") = Eigen::Vector4d(state.T_W_B.q.coeffs()), py::arg("v") = state.v_W,
                  py::arg("b_a") = state.b_a, py::arg("b_g") = state.b_g);
}

py::object DescribeIf(const std::optional<ch5::StampedState>& state) {
  return state ? py::object(Describe(*state)) : py::none();
}

// An estimator, and the state of its last image.
class PyEstimator {
 public:
  PyEstimator(const ch5::Calibration& calibration, const std::string& policy, bool covariance)
      : estimator_(Options(calibration, covariance), Policy(policy)) {}

  void AddImu(double t, const ch5::Vec3& acceleration, const ch5::Vec3& gyroscope) {
    estimator_.AddImu({t, acceleration, gyroscope});
  }

  py::dict AddFrame(double t, const std::vector<int>& ids, const Eigen::Matrix<double, Eigen::Dynamic, 2>& points) {
    if (static_cast<Eigen::Index>(ids.size()) != points.rows())
      throw std::invalid_argument("add_frame: one id a row of points");
    ch5::Image image{t, {}};
    for (size_t k = 0; k < ids.size(); ++k) image.tracks.push_back({ids[k], points.row(static_cast<Eigen::Index>(k))});
    const ch5::FrameReport report = estimator_.AddFrame(image);
    const char* status[] = {"starting", "tracking", "restarted"};
    return py::dict(py::arg("status") = status[static_cast<int>(report.status)], py::arg("segment") = report.segment,
                    py::arg("message") = report.message, py::arg("landmarks") = report.landmarks,
                    py::arg("state") = DescribeIf(report.state),
                    py::arg("covariance") = report.covariance ? py::cast(report.covariance->state) : py::none());
  }

  py::object PredictAt(double t) const { return DescribeIf(estimator_.PredictAt(t)); }

 private:
  static ch5::EstimatorOptions Options(const ch5::Calibration& calibration, bool covariance) {
    ch5::EstimatorOptions options;
    options.calibration = calibration;
    options.report_covariance = covariance;
    return options;
  }
  static std::unique_ptr<ch5::WindowPolicy> Policy(const std::string& name) {
    if (name == "vins") return ch5::MakeVinsPolicy();
    if (name == "okvis") return ch5::MakeOkvisPolicy();
    throw std::invalid_argument("Estimator: policy is '" + name + "', expected 'vins' or 'okvis'");
  }

  ch5::Estimator estimator_;
};

void DefineVertices(py::module_& module) {
  using Numbers = Eigen::VectorXd;
  py::class_<ch5::Vertex, std::shared_ptr<ch5::Vertex>>(module, "Vertex")
      .def_property(
          "x", [](const ch5::Vertex& v) { return ch5::VecX(v.Parameters()); },
          [](ch5::Vertex& v, const Numbers& x) {
            if (x.size() != v.Dimension())
              throw std::invalid_argument("x: " + std::to_string(v.Dimension()) + " numbers are wanted");
            v.Parameters() = x;
          })
      .def_property("fixed", &ch5::Vertex::IsFixed, &ch5::Vertex::SetFixed);
  py::class_<VertexNumbers, ch5::Vertex, std::shared_ptr<VertexNumbers>>(module, "Vector", "Numbers that add.")
      .def(py::init<const ch5::VecX&, bool>(), py::arg("x"), py::arg("landmark") = false);
  py::class_<ch5::VertexPose, ch5::Vertex, std::shared_ptr<ch5::VertexPose>>(module, "Pose")
      .def(py::init([](const ch5::Vec3& p, const Eigen::Vector4d& q) {
             return std::make_shared<ch5::VertexPose>(ch5::Qd(q[3], q[0], q[1], q[2]), p);
           }),
           py::arg("p"), py::arg("q"))
      .def_property(
          "x", [](const ch5::VertexPose& pose) { return pose.GetEstimate(); },
          [](ch5::VertexPose& pose, const ch5::VertexPose::Estimate& x) { pose.SetEstimate(x); },
          "[p, q]; q is normalized.");
}

void DefineEdges(py::module_& module) {
  py::class_<ch5::Edge, std::shared_ptr<ch5::Edge>>(module, "Edge",
                                                    "r(x_0, x_1, ...) of `size` rows; cost rho(r^T W r) / 2.")
      .def(py::init([](std::vector<std::shared_ptr<ch5::Vertex>> vertices, py::function residual, int size,
                       py::object jacobians) -> std::shared_ptr<ch5::Edge> {
             if (size < 1) throw std::invalid_argument("Edge: size = " + std::to_string(size) + ": must be at least 1");
             return std::make_shared<EdgeFunction>(std::move(vertices), std::move(residual), size,
                                                   std::move(jacobians));
           }),
           py::arg("vertices"), py::arg("residual"), py::arg("size"), py::arg("jacobians") = py::none())
      .def_property(
          "information", [](const ch5::Edge& e) { return ch5::MatXX(e.Information()); },
          [](ch5::Edge& e, const ch5::MatXX& W) { e.SetInformation(W); })
      .def("set_huber", [](ch5::Edge& e, double d) { e.SetLossFunction(std::make_shared<ch5::HuberLoss>(d)); })
      .def("set_cauchy", [](ch5::Edge& e, double d) { e.SetLossFunction(std::make_shared<ch5::CauchyLoss>(d)); });
  module.def(
      "between",
      [](std::shared_ptr<ch5::VertexPose> i, std::shared_ptr<ch5::VertexPose> j, const ch5::Vec3& p,
         const Eigen::Vector4d& q) -> std::shared_ptr<ch5::Edge> {
        return std::make_shared<ch5::EdgeSE3Between>(std::move(i), std::move(j), ch5::Qd(q[3], q[0], q[1], q[2]), p);
      },
      py::arg("i"), py::arg("j"), py::arg("p"), py::arg("q"), "The measured pose of j as seen from i.");
}

void DefineGraph(py::module_& module) {
  py::class_<ch5::Graph>(module, "Graph")
      .def(py::init<>())
      .def("add", [](ch5::Graph& g, std::shared_ptr<ch5::Vertex> v) { return g.AddVertex(std::move(v)); })
      .def(
          "add", [](ch5::Graph& g, std::shared_ptr<ch5::Edge> e) { return g.AddEdge(std::move(e)); },
          py::keep_alive<1, 2>())
      .def("cost", [](const ch5::Graph& g) { return ch5::Cost(g); })
      .def("solve", &Solve, py::arg("max_iterations") = 20, py::arg("cost_tolerance") = 1e-6)
      .def("covariance",
           [](ch5::Graph& g, const std::vector<std::shared_ptr<ch5::Vertex>>& v) {
             ch5::Covariance covariance(&g);
             return ch5::JointCovariance(v, &covariance);
           })
      .def(
          "marginalize",
          [](ch5::Graph& g, const std::vector<std::shared_ptr<ch5::Vertex>>& drop) {
            const auto prior = ch5::MarginalizeInto(&g, drop);
            return prior ? py::object(py::make_tuple(prior->GetPrior().J, prior->GetPrior().r0)) : py::none();
          },
          "Drops vertices; returns the prior's (J, r0), which is in the graph, or None.");
}

/// (calibration, IMU, images) of a recording's folder.
py::tuple ReadRecording(const std::string& folder) {
  const ch5::Recording recording = ch5::ReadRecording(folder);
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

void DefineEstimator(py::module_& module) {
  py::class_<ch5::Calibration>(module, "Calibration")
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
  py::class_<PyEstimator>(module, "Estimator")
      .def(py::init<const ch5::Calibration&, const std::string&, bool>(), py::arg("calibration"),
           py::arg("policy") = "vins", py::arg("covariance") = false)
      .def("add_imu", &PyEstimator::AddImu, py::arg("t"), py::arg("acceleration"), py::arg("gyroscope"))
      .def("add_frame", &PyEstimator::AddFrame, py::arg("t"), py::arg("ids"), py::arg("points"))
      .def("predict_at", &PyEstimator::PredictAt, py::arg("t"));
  module.def("read_recording", &ReadRecording,
             "calibration, IMU as rows of t, acceleration, gyroscope, and images as tuples (t, ids, points).");
}

}  // namespace

PYBIND11_MODULE(ch5, module) {
  module.doc() =
      "Chapter 5's back end: graphs, priors and the visual-inertial estimator. Poses are [p, q_x, q_y, q_z, q_w].";
  module.attr("__version__") = py::str("{}.{}.{}").format(CH5_VERSION_MAJOR, CH5_VERSION_MINOR, CH5_VERSION_PATCH);
  DefineVertices(module);
  DefineEdges(module);
  DefineGraph(module);
  DefineEstimator(module);
}
