/// The Python module ch5: graphs with residuals in Python, solving, marginalizing, and the estimator. NumPy in and out.
#include <pybind11/eigen.h>
#include <pybind11/functional.h>
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include "ch5_backend/files/g2o_file.h"
#include "ch5_backend/files/text_reader.h"
#include "ch5_backend/initialize/initialize_pose_graph.h"
#include "ch5_backend/marginalize/marginalize.h"
#include "ch5_backend/math/option_checks.h"
#include "ch5_backend/python/shared.h"
#include "ch5_backend/python/vertices_and_edges.h"
#include "ch5_backend/sparse/joint_covariance.h"
#include "ch5_backend/sparse/sparse_optimizer.h"
#include "ch5_backend/types/pose_graph/edge_between.h"
#include "ch5_backend/version.h"
#include "ch5_backend/window/measurement_checks.h"

namespace {

struct Graph : OneThread {
  ch5::Graph own;
  std::unique_ptr<ch5::G2oFile> file;  // holds the graph, if it was read
  bool is_solved = false;

  std::unique_lock<std::recursive_mutex> Use() { return OneThread::Use("Graph"); }
  ch5::Graph* Get() { return file ? &file->graph : &own; }
};

template <typename T>
T Named(const char* what, const std::string& name, const std::vector<std::pair<const char*, T>>& all) {
  std::string names;
  for (const auto& [word, value] : all) {
    if (name == word) return value;
    names += std::string(names.empty() ? "" : ", ") + word;
  }
  throw std::invalid_argument(std::string(what) + " is '" + name + "', expected one of " + names);
}

std::shared_ptr<const ch5::LossFunction> MakeLoss(const std::string& name, double threshold) {
  using Make = std::shared_ptr<const ch5::LossFunction> (*)(double);
#define CH5_LOSS(Type) \
  [](double d) -> std::shared_ptr<const ch5::LossFunction> { return std::make_shared<ch5::Type>(d); }
  return Named<Make>("set_loss: name", name,
                     {{"huber", CH5_LOSS(HuberLoss)},
                      {"cauchy", CH5_LOSS(CauchyLoss)},
                      {"tukey", CH5_LOSS(TukeyLoss)},
                      {"pseudo-huber", CH5_LOSS(PseudoHuberLoss)},
                      {"geman-mcclure", CH5_LOSS(GemanMcClureLoss)},
                      {"welsch", CH5_LOSS(WelschLoss)},
                      {"fair", CH5_LOSS(FairLoss)},
                      {"saturated", CH5_LOSS(SaturatedLoss)},
                      {"dcs", CH5_LOSS(DcsLoss)}})(threshold);
#undef CH5_LOSS
}

// The options by their names in C++; what is not given stays as it is there.
ch5::SolveOptions OptionsOf(const py::dict& given, ch5::SparseOptimizer* optimizer) {
  ch5::SolveOptions options;
  for (const auto& [key, value] : given) {
    const std::string name = py::str(key);
    const auto take = [&](const char* own, auto* option) {
      if (name != own) return false;
      try {
        *option = value.cast<std::decay_t<decltype(*option)>>();
      } catch (const py::cast_error&) {
        throw std::invalid_argument("solve: " + name + " cannot be a " +
                                    std::string(py::str(py::type::of(value).attr("__name__"))));
      }
      return true;
    };
    if (name == "algorithm") {
      using A = ch5::Algorithm;
      options.algorithm = Named<A>("solve: algorithm", std::string(py::str(value)),
                                   {{"automatic", A::kAutomatic},
                                    {"gauss-newton", A::kGaussNewton},
                                    {"levenberg-marquardt", A::kLevenbergMarquardt},
                                    {"dogleg", A::kDogleg}});
    } else if (name == "damping") {
      using D = ch5::Damping;
      optimizer->SetDamping(Named<D>("solve: damping", std::string(py::str(value)),
                                     {{"diagonal", D::kDiagonal}, {"identity", D::kIdentity}}));
    } else if (!take("cost_tolerance", &options.cost_tolerance) &&
               !take("gradient_tolerance", &options.gradient_tolerance) &&
               !take("step_tolerance", &options.step_tolerance) && !take("tau", &options.tau) &&
               !take("initial_radius", &options.initial_radius) && !take("max_trials", &options.max_trials) &&
               !take("landmark_steps", &options.landmark_steps)) {
      throw std::invalid_argument("solve: there is no option '" + name + "'");
    }
  }
  return options;
}

py::dict Describe(const ch5::IterationInfo& info) {
  return py::dict(py::arg("iteration") = info.iteration, py::arg("cost") = info.cost, py::arg("lambda") = info.lambda,
                  py::arg("gain_ratio") = info.gain_ratio, py::arg("step_norm") = info.step_norm,
                  py::arg("gradient_max") = info.gradient_max, py::arg("trials") = info.trials,
                  py::arg("seconds") = info.seconds);
}

// Without Python's lock, so that other threads go on; it is taken for functions of Python, and once an iteration to see
// whether Ctrl-C was pressed.
py::dict Solve(Graph* graph, int max_iterations, int threads, const py::object& callback, const py::kwargs& others) {
  const auto lock = graph->Use();
  if (graph->is_solved) throw std::runtime_error("solve: the graph is being solved: its callback cannot solve it too");
  ch5::SparseOptimizer optimizer(graph->Get(), threads);
  ch5::SolveOptions options = OptionsOf(others, &optimizer);
  options.max_iterations = max_iterations;
  options.callback = [&](const ch5::IterationInfo& info) {
    const py::gil_scoped_acquire python;
    if (PyErr_CheckSignals() != 0) throw py::error_already_set();
    if (callback.is_none()) return true;
    const py::object answer = callback(Describe(info));
    return answer.is_none() || py::bool_(answer);
  };
  const auto solve = [&] {
    const py::gil_scoped_release unlocked;
    return optimizer.Solve(options);
  };
  graph->is_solved = true;
  const std::unique_ptr<Graph, void (*)(Graph*)> end(graph, [](Graph* g) { g->is_solved = false; });
  const ch5::Summary summary = solve();
  const auto column = [&](auto member) {
    ch5::VecX values(summary.trace.size());
    for (size_t k = 0; k < summary.trace.size(); ++k) values[static_cast<Eigen::Index>(k)] = summary.trace[k].*member;
    return values;
  };
  return py::dict(py::arg("message") = summary.message, py::arg("termination") = ch5::ToString(summary.termination),
                  py::arg("converged") = ch5::IsConverged(summary.termination),
                  py::arg("initial_cost") = summary.initial_cost, py::arg("final_cost") = summary.final_cost,
                  py::arg("iterations") = summary.iterations, py::arg("seconds") = summary.seconds,
                  py::arg("cost") = column(&ch5::IterationInfo::cost),
                  py::arg("lambda") = column(&ch5::IterationInfo::lambda),
                  py::arg("gradient_max") = column(&ch5::IterationInfo::gradient_max));
}

std::shared_ptr<VertexNumbers> VectorOn(const py::array& x, bool landmark) {
  const bool fits =
      py::isinstance<py::array_t<double>>(x) && x.ndim() == 1 && x.writeable() && (x.flags() & py::array::c_style) != 0;
  if (!fits) throw std::invalid_argument("Vector.on: a writable, contiguous array of float64 of one dimension");
  return std::make_shared<VertexNumbers>(py::array_t<double>(x), landmark);
}

void DefineVertices(py::module_& module) {
  using Numbers = Eigen::VectorXd;
  py::class_<ch5::Vertex, std::shared_ptr<ch5::Vertex>>(module, "Vertex", "An unknown.")
      .def_property(
          "x", [](const ch5::Vertex& v) { return ch5::VecX(v.Parameters()); },
          [](ch5::Vertex& v, const Numbers& x) {
            if (x.size() != v.Dimension())
              throw std::invalid_argument("x: " + std::to_string(v.Dimension()) + " numbers are wanted");
            v.Parameters() = x;
          },
          "Its parameters, a copy.")
      .def_property_readonly("view", &View, "Its parameters without a copy: they follow the solver; read-only.")
      .def_property("fixed", &ch5::Vertex::IsFixed, &ch5::Vertex::SetFixed, "Whether it stays as it is.");
  py::class_<VertexNumbers, ch5::Vertex, std::shared_ptr<VertexNumbers>>(module, "Vector", "Numbers that add.")
      .def(py::init([](const Numbers& x, bool landmark) {
             py::array_t<double> copy(x.size());
             std::copy_n(x.data(), x.size(), copy.mutable_data());
             return std::make_shared<VertexNumbers>(copy, landmark);
           }),
           py::arg("x"), py::arg("landmark") = false)
      .def_static("on", &VectorOn, py::arg("x"), py::arg("landmark") = false,
                  "In the memory of an array, where solving leaves its result.");
  py::class_<ch5::VertexPose, ch5::Vertex, std::shared_ptr<ch5::VertexPose>>(module, "Pose",
                                                                             "T_W_B: p + dp, q * Exp(dtheta).")
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
          [](ch5::Edge& e, const ch5::MatXX& W) { e.SetInformation(W); }, "W, the inverse covariance.")
      .def(
          "set_loss", [](ch5::Edge& e, const std::string& name, double d) { e.SetLossFunction(MakeLoss(name, d)); },
          py::arg("name"), py::arg("threshold"),
          "A robust loss: huber, cauchy, tukey, pseudo-huber, geman-mcclure, ... The threshold is in sigmas; that of "
          "geman-mcclure and dcs in their squares.")
      .def_property_readonly(
          "chi2", [](ch5::Edge& e) { return e.ComputeResidual(), e.Chi2(); }, "r^T W r at the present states.")
      .def(
          "set_huber", [](ch5::Edge& e, double d) { e.SetLossFunction(std::make_shared<ch5::HuberLoss>(d)); },
          py::arg("threshold"), "set_loss('huber', threshold)")
      .def(
          "set_cauchy", [](ch5::Edge& e, double d) { e.SetLossFunction(std::make_shared<ch5::CauchyLoss>(d)); },
          py::arg("threshold"), "set_loss('cauchy', threshold)");
  module.def(
      "between",
      [](std::shared_ptr<ch5::VertexPose> i, std::shared_ptr<ch5::VertexPose> j, const ch5::Vec3& p,
         const Eigen::Vector4d& q) -> std::shared_ptr<ch5::Edge> {
        return std::make_shared<ch5::EdgeSE3Between>(std::move(i), std::move(j), ch5::Qd(q[3], q[0], q[1], q[2]), p);
      },
      py::arg("i"), py::arg("j"), py::arg("p"), py::arg("q"), "The measured pose of j as seen from i.");
}

void AddFormulas(Graph* graph, const Formula& formula, const std::vector<std::shared_ptr<ch5::Vertex>>& vertices,
                 const Rows& numbers, const std::optional<ch5::MatXX>& information,
                 const std::optional<std::pair<std::string, double>>& loss) {
  const auto lock = graph->Use();
  if (numbers.ndim() != 2 || numbers.shape(1) != formula.it->numbers)
    throw std::invalid_argument("add_formula: numbers, a row an edge: n x " + std::to_string(formula.it->numbers) +
                                " are wanted");
  const auto shared_loss = loss ? MakeLoss(loss->first, loss->second) : nullptr;
  for (py::ssize_t row = 0; row < numbers.shape(0); ++row) {
    const auto edge = std::make_shared<EdgeFormula>(formula, vertices, numbers, row);
    if (information) edge->SetInformation(*information);
    edge->SetLossFunction(shared_loss);
    graph->Get()->AddEdge(edge);
  }
}

ch5::MatXX CovarianceOf(Graph* graph, const std::vector<std::shared_ptr<ch5::Vertex>>& vertices) {
  const auto lock = graph->Use();
  const py::gil_scoped_release unlocked;
  ch5::Covariance covariance(graph->Get());
  return ch5::JointCovariance(vertices, &covariance);
}

void DefineGraph(py::module_& module) {
  py::class_<Formula>(module, "Formula",
                      "A residual compiled in C++ (graph/c_formula.h): no Python runs while solving.")
      .def(py::init<const std::string&, const std::string&>(), py::arg("path"), py::arg("name"));
  py::class_<Graph>(module, "Graph", "Unknowns and residuals; one thread at a time uses it.")
      .def(py::init<>())
      .def(
          "add", [](Graph& g, std::shared_ptr<ch5::Vertex> v) { return g.Use(), g.Get()->AddVertex(std::move(v)); },
          py::arg("vertex"), "Adds an unknown or an edge; returns its number.")
      .def(
          "add", [](Graph& g, std::shared_ptr<ch5::Edge> e) { return g.Use(), g.Get()->AddEdge(std::move(e)); },
          py::arg("edge"), py::keep_alive<1, 2>())
      .def("add_formula", &AddFormulas, py::arg("formula"), py::arg("vertices"), py::arg("numbers"),
           py::arg("information") = py::none(), py::arg("loss") = py::none(),
           "An edge for each row of numbers, which stay where they are.")
      .def(
          "cost", [](Graph& g) { return g.Use(), ch5::Cost(*g.Get()); }, "The sum of rho(r^T W r) / 2.")
      .def("solve", &Solve, py::arg("max_iterations") = 20, py::arg("threads") = 1, py::arg("callback") = py::none(),
           "Minimizes the cost; other threads of Python go on meanwhile. Options: algorithm, damping, cost_tolerance,\n"
           "gradient_tolerance, step_tolerance, tau, initial_radius, max_trials, landmark_steps.\n"
           "callback(iteration) gets a dict; False stops.")
      .def("covariance", &CovarianceOf, py::arg("vertices"), "Of these unknowns together, one below the other.")
      .def(
          "marginalize",
          [](Graph& g, const std::vector<std::shared_ptr<ch5::Vertex>>& drop) {
            const auto lock = g.Use();
            const auto prior = ch5::MarginalizeInto(g.Get(), drop);
            return prior ? py::object(py::make_tuple(prior->GetPrior().J, prior->GetPrior().r0)) : py::none();
          },
          py::arg("drop"), "Drops vertices; returns the prior's (J, r0), which is in the graph, or None.");
}

// The solved graph of a file.
py::dict SolvePoseGraph(const std::filesystem::path& path, const std::optional<std::string>& start, int max_iterations,
                        int threads, const py::object& callback, bool leave_out) {
  ch5::G2oOptions reading;
  reading.leave_out = leave_out;
  auto graph = std::make_shared<Graph>();
  graph->file = std::make_unique<ch5::G2oFile>(ch5::ReadG2o(path.string(), reading));
  ch5::SparseOptimizer gauge(graph->Get());
  if (gauge.GaugeFreedom()) gauge.FindGauge()->SetFixed();
  using Start = ch5::PoseGraphStart;
  std::vector<Start> starts = {Start::kSpanningTree, Start::kChordal};
  if (start) {
    starts = {Named<Start>("solve: start", *start,
                           {std::begin(ch5::kPoseGraphStartNames), std::end(ch5::kPoseGraphStartNames)})};
  } else if (graph->file->has_poses) {
    starts.push_back(Start::kGiven);
  }
  {
    const py::gil_scoped_release unlocked;
    ch5::InitializeAtLeastCost(starts, graph->Get(), threads);
  }
  py::dict result = Solve(graph.get(), max_iterations, threads, callback, py::kwargs());
  std::vector<int64_t> ids;
  std::vector<ch5::VecX> poses;
  for (const auto& vertex : graph->Get()->Vertices()) {
    const auto id = static_cast<size_t>(vertex->Id());
    if (vertex->GetRole() != ch5::Role::kPose || id >= graph->file->ids.size()) continue;
    ids.push_back(graph->file->ids[id]);
    poses.emplace_back(vertex->Parameters());
  }
  ch5::MatXX rows(poses.size(), poses.empty() ? 0 : poses.front().size());
  for (size_t k = 0; k < poses.size(); ++k) rows.row(static_cast<Eigen::Index>(k)) = poses[k];
  result["ids"] = py::array(py::cast(ids));
  result["poses"] = rows;
  result["g2o"] = ch5::FormatG2o(*graph->file);
  return result;
}

}  // namespace

void DefineErrors(py::module_& module) {
  py::register_exception<ch5::GraphError>(module, "GraphError", PyExc_ValueError);
  py::register_exception<ch5::OptionError>(module, "OptionError", PyExc_ValueError);
  py::register_exception<ch5::MeasurementError>(module, "MeasurementError", PyExc_ValueError);
  py::register_exception<ch5::CovarianceError>(module, "CovarianceError", PyExc_RuntimeError);
  py::register_exception<ch5::FileError>(module, "FileError", PyExc_RuntimeError);
}

PYBIND11_MODULE(ch5, module) {
  module.doc() =
      "Chapter 5's back end: graphs, priors and the visual-inertial estimator. Poses are [p, q_x, q_y, q_z, q_w].";
  module.attr("__version__") = py::str("{}.{}.{}").format(CH5_VERSION_MAJOR, CH5_VERSION_MINOR, CH5_VERSION_PATCH);
  DefineErrors(module);
  DefineVertices(module);
  DefineEdges(module);
  DefineGraph(module);
  DefineEstimator(module);
  auto pose_graph = module.def_submodule("pose_graph", "Pose graphs in g2o's and TORO's files.");
  pose_graph.def("solve", &SolvePoseGraph, py::arg("path"), py::arg("start") = py::none(),
                 py::arg("max_iterations") = 100, py::arg("threads") = 1, py::arg("callback") = py::none(),
                 py::arg("leave_out") = false,
                 "Reads a graph and solves it: what Graph.solve returns, with ids, poses (a row each) and g2o, the "
                 "file's new text. start: file, odometry, spanning-tree, chordal or incremental; the one of the file, "
                 "spanning-tree and chordal that has the least cost unless given.");
}
