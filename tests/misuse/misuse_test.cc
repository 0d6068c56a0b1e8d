/// The library used wrongly: each case with what it says. Nothing may crash, and nothing may be silent.
#include <gtest/gtest.h>

#include <functional>
#include <limits>
#include <thread>

#include "ch5_backend/dense/blocks/plain_block_solver.h"
#include "ch5_backend/dense/problem.h"
#include "ch5_backend/experiments/studies/odometry.h"
#include "ch5_backend/experiments/studies/window/wrapped_policy.h"
#include "ch5_backend/files/recording_file.h"
#include "ch5_backend/files/tables/text_writer.h"
#include "ch5_backend/graph/sized_edge.h"
#include "ch5_backend/initialize/graduated.h"
#include "ch5_backend/initialize/initialize_pose_graph.h"
#include "ch5_backend/marginalize/edge_prior.h"
#include "ch5_backend/marginalize/marginalization_error.h"
#include "ch5_backend/marginalize/marginalization_info.h"
#include "ch5_backend/marginalize/marginalize.h"
#include "ch5_backend/marginalize/qr_elimination.h"
#include "ch5_backend/math/option_checks.h"
#include "ch5_backend/simulate/sensors/simulation.h"
#include "ch5_backend/sparse/sparse_optimizer.h"
#include "ch5_backend/types/edge_se3_prior.h"
#include "ch5_backend/types/pose_graph/edge_between.h"
#include "ch5_backend/types/vertices.h"
#include "ch5_backend/types/visual/edge_reprojection.h"
#include "ch5_backend/types/visual/edge_track.h"
#include "ch5_backend/window/start/dynamic_initialization.h"
#include "tests/temporary_folder.h"

namespace ch5 {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
using Scalar = VertexScalar::Estimate;

// ---- what goes into a graph ------------------------------------------------------------------------------------------

// r = x_1 − x_0 − 1, spoilt in one way.
enum class Spoilt { kNot, kNoJacobian, kWrongSign, kNaN, kThrows };
class EdgeStep : public SizedEdge<1, VertexScalar, VertexScalar> {
 public:
  EdgeStep(std::shared_ptr<VertexScalar> a, std::shared_ptr<VertexScalar> b, Spoilt spoilt = Spoilt::kNot)
      : SizedEdge(std::move(a), std::move(b)), spoilt_(spoilt) {}
  void ComputeResidual() override {
    r_ = GetVertex<1>().GetEstimate() - GetVertex<0>().GetEstimate() - Scalar(1.0);
    if (spoilt_ == Spoilt::kNaN) r_[0] = kNaN;
    if (spoilt_ == Spoilt::kThrows && GetVertex<0>().GetEstimate()[0] != 0.0) throw std::runtime_error("no such point");
  }
  void ComputeJacobians() override {
    if (spoilt_ != Spoilt::kNoJacobian) ComputeJacobiansNumerically();
    if (spoilt_ == Spoilt::kWrongSign) J<0>() *= -1.0, J<1>() *= -1.0;
  }
  std::string TypeInfo() const override { return "EdgeStep"; }

 private:
  Spoilt spoilt_;
};

struct TwoSteps {
  explicit TwoSteps(Spoilt spoilt = Spoilt::kNot) {
    for (const double x : {0.0, 1.5, 2.5}) x_.push_back(std::make_shared<VertexScalar>(Scalar(x)));
    for (const auto& vertex : x_) graph.AddVertex(vertex);
    for (const auto& edge :
         edges_ = {std::make_shared<EdgeStep>(x_[0], x_[1], spoilt), std::make_shared<EdgeStep>(x_[1], x_[2])}) {
      graph.AddEdge(edge);
    }
  }
  std::string Solve(const SolveOptions& options = {}) {
    x_[2]->SetFixed();
    return SparseOptimizer(&graph).Solve(options).message;
  }

  Graph graph;
  std::vector<std::shared_ptr<VertexScalar>> x_;
  std::vector<std::shared_ptr<Edge>> edges_;
};

template <typename System>
std::string SolvePlainly(Spoilt spoilt) {
  TwoSteps g(spoilt);
  System system(&g.graph);
  return Minimize(&system, {}).message;
}

// Changes the graph before the first step.
template <typename System>
void SolveChanging(void (*change)(TwoSteps*)) {
  TwoSteps g;
  SolveOptions options;
  options.callback = [&](const IterationInfo& info) {
    if (info.iteration == 0) change(&g);
    return true;
  };
  System(&g.graph).Solve(options);
}

// Nobody has given it memory for its parameters.
class VertexWithoutMemory : public Vertex {
 public:
  VertexWithoutMemory() : Vertex(2, 2, nullptr, nullptr, Role::kPose) {}
  void Plus(const double*) override {}
  VecX Minus(const VecX&) const override { return VecX(); }
  std::string TypeInfo() const override { return "VertexWithoutMemory"; }
};

// Its residual has memory, perhaps; its Jacobians have none.
class EdgeWithoutMemory : public Edge {
 public:
  explicit EdgeWithoutMemory(std::shared_ptr<VertexScalar> x, bool has_residual = true)
      : Edge(1, std::vector<std::shared_ptr<Vertex>>{std::move(x)}, nullptr, nullptr) {
    if (has_residual) SetMemory(&r_, &W_);
  }
  void ComputeResidual() override { r_ = Vertices()[0]->Parameters()[0]; }
  std::string TypeInfo() const override { return "EdgeWithoutMemory"; }

 private:
  double r_ = 0.0, W_ = 1.0;
};

// At each evaluation there is one edge more.
class EdgeThatAdds : public SizedEdge<1, VertexScalar> {
 public:
  EdgeThatAdds(Graph* graph, std::shared_ptr<VertexScalar> x) : SizedEdge(x), graph_(graph), x_(std::move(x)) {}
  void ComputeResidual() override {
    graph_->AddEdge(std::make_shared<EdgeWithoutMemory>(x_));
    r_ = x_->GetEstimate();
  }
  std::string TypeInfo() const override { return "EdgeThatAdds"; }

 private:
  Graph* graph_;
  std::shared_ptr<VertexScalar> x_;
};

// On a sphere, it should be; but nobody says how.
class VertexWithoutPlus : public SizedVertex<4, 3> {
 public:
  VertexWithoutPlus() : SizedVertex(Estimate::UnitX(), Role::kPose) {}
  std::string TypeInfo() const override { return "VertexWithoutPlus"; }
};
class EdgeOnIt : public SizedEdge<4, VertexWithoutPlus> {
 public:
  explicit EdgeOnIt(std::shared_ptr<VertexWithoutPlus> vertex) : SizedEdge(std::move(vertex)) {}
  void ComputeResidual() override { r_ = GetVertex<0>().GetEstimate(); }
  std::string TypeInfo() const override { return "EdgeOnIt"; }
};

template <typename Change>
std::string SolveWith(const Change& change) {
  SolveOptions options;
  change(&options);
  return TwoSteps().Solve(options);
}

// ---- what goes into an estimator -------------------------------------------------------------------------------------

const Recording& Flight() {
  static const Recording flight = [] {
    HandheldOptions path;
    path.duration = 4.0;
    path.standstill_seconds = 1.5;
    SimulationOptions options;
    options.camera.max_tracks = 30;
    return SimulateInRoom(path, 1000, options);
  }();
  return flight;
}

// What the estimator says of the last image of the flight, changed, under changed options, or of the first restart.
std::string Follow(const std::function<void(Recording*)>& change_flight,
                   const std::function<void(EstimatorOptions*)>& change_options = nullptr) {
  Recording recording = Flight();
  change_flight(&recording);
  EstimatorOptions options;
  options.calibration = recording.calibration;
  if (change_options) change_options(&options);
  OkvisOptions okvis;
  okvis.temporal_frames = 5;
  Estimator estimator(options, MakeOkvisPolicy(okvis));
  std::string last, restart;
  FeedRecording(recording, &estimator, [&](const Estimator&, const ImageResult& row) {
    const FrameReport& report = row.report;
    EXPECT_EQ(report.message.empty(), report.status == FrameReport::Status::kTracking) << report.message;
    last = report.message;
    if (restart.empty() && report.status == FrameReport::Status::kRestarted) restart = last;
  });
  return restart.empty() ? last : restart;
}

template <typename Change>
std::string ChangeEach(const Change& change) {
  return Follow([&](Recording* recording) {
    for (ImuMeasurement& measurement : recording->imu) change(&measurement);
  });
}

template <typename Change>
void Estimate(const Change& change) {
  EstimatorOptions options;
  change(&options);
  Estimator(options, MakeVinsPolicy());
}

template <typename Options, typename Change>
Options With(const Change& change) {
  Options options;
  change(&options);
  return options;
}

// VINS-Mono's window, whose gauge is free, by a method that cannot do with a free gauge.
class SingularPolicy : public WrappedPolicy {
 public:
  SingularPolicy() : WrappedPolicy(MakeVinsPolicy()) {}
  SolveOptions Options() const override {
    SolveOptions options;
    options.algorithm = Algorithm::kGaussNewton;
    return options;
  }
};

// StartFrom, and images until the estimator says something.
std::string StartFrom(const StampedState& state, const MatXX& J,
                      std::unique_ptr<WindowPolicy> policy = MakeVinsPolicy()) {
  EstimatorOptions options;
  options.calibration = Flight().calibration;
  Estimator estimator(options, std::move(policy));
  estimator.StartFrom(state, J);
  for (const ImuMeasurement& measurement : Flight().imu) estimator.AddImu(measurement);
  std::string message;
  for (size_t k = 0; message.empty() && k < Flight().images.size(); ++k) {
    message = estimator.AddFrame(Flight().images[k]).message;
  }
  return message;
}

// ---- what goes into a file -------------------------------------------------------------------------------------------

// The flight's folder with one file changed, read.
std::string ReadChanged(const std::string& name, const std::function<void(std::string*)>& change) {
  const test::TemporaryFolder folder;
  WriteRecording(Flight(), folder.Path());
  std::string text = test::ReadText(folder / name);
  change(&text);
  WriteFileAtomically(folder / name, text);
  return test::Refusal<FileError>([&] { ReadRecording(folder.Path()); });
}

// ---- the table -------------------------------------------------------------------------------------------------------

// What a function returns; one that returns nothing throws or else says nothing.
template <typename Function, typename... Arguments>
std::string Said(const Function& function, Arguments... arguments) {
  if constexpr (std::is_void_v<std::invoke_result_t<Function, Arguments...>>)
    return function(arguments...), "";
  else
    return function(arguments...);
}

// The function is called as it is, with a small graph, or with the flight to change for the estimator.
struct Case {
  template <typename Function>
  Case(const char* name, const char* expected, const Function& function) : name(name), expected(expected) {
    if constexpr (std::is_invocable_v<Function, TwoSteps*>) {
      said = [function] {
        TwoSteps g;
        return Said(function, &g);
      };
    } else if constexpr (std::is_invocable_v<Function, Recording*>) {
      said = [function] { return Follow(function); };
    } else {
      said = [function] { return Said(function); };
    }
  }
  const char *name, *expected;        // a part of what it says
  std::function<std::string()> said;  // or thrown
};

// Who may not come into a graph: ../graph/, ../g2o/graph_conformance_test.cc; what is empty: ../dense/problem_test.cc.
const std::vector<Case> kGraphs = {
    {"an infinite information", "EdgeStep: the information matrix",
     [] { TwoSteps().edges_[0]->SetInformation(MatXX::Constant(1, 1, 1.0 / 0.0)); }},
    {"no graph", "the solver's graph is null", [] { SparseOptimizer(nullptr); }},
    {"a graph that has been destroyed", "the solver's graph has been destroyed",
     [] {
       auto g = std::make_unique<TwoSteps>();
       SparseOptimizer optimizer(&g->graph);
       g.reset();
       optimizer.Solve();
     }},
    {"a free gauge", "H is singular; is a gauge free?", [](TwoSteps* g) { Covariance{&g->graph}; }},
    {"a residual of NaN", "the cost of the initial states is not finite; EdgeStep 0 has",
     [] { return TwoSteps(Spoilt::kNaN).Solve(); }},
    {"a Jacobian that is never filled", "the gradient is not finite: a Jacobian holds NaN or infinity; EdgeStep 0 has",
     [] { return TwoSteps(Spoilt::kNoJacobian).Solve(); }},
    {"a residual whose square is infinite", "; EdgeStep 0 has a cost that is not finite",
     [](TwoSteps* g) {
       g->x_[1]->SetEstimate(Scalar(1e200));
       return g->Solve();
     }},
    {"a residual of NaN in a dense problem", "; EdgeStep 0 has", [] { return SolvePlainly<Problem>(Spoilt::kNaN); }},
    {"a Jacobian that is never filled, of plain blocks", "; EdgeStep 0 has",
     [] { return SolvePlainly<PlainBlockSolver>(Spoilt::kNoJacobian); }},
    {"Jacobians of the wrong sign", "CheckJacobians tells which", [] { return TwoSteps(Spoilt::kWrongSign).Solve(); }},
    {"a residual of NaN, its covariance", "Covariance: EdgeStep 0 has a residual or a Jacobian that is not finite",
     [] {
       TwoSteps g(Spoilt::kNaN);
       Covariance{&g.graph};
     }},
    {"a vertex removed while solving", "VertexVector1 has left the graph while it was being solved",
     [] { SolveChanging<SparseOptimizer>([](TwoSteps* g) { g->graph.RemoveVertex(g->x_[2]); }); }},
    {"an edge removed while solving", "EdgeStep has left the graph while it was being solved",
     [] { SolveChanging<Problem>([](TwoSteps* g) { g->graph.RemoveEdge(g->edges_[0]); }); }},
    {"a vertex fixed and all numbered anew while solving",
     "VertexVector1 0 has been numbered anew while it was being solved",
     [] {
       SolveChanging<SparseOptimizer>([](TwoSteps* g) {
         g->x_[0]->SetFixed();
         MakeOrdering(g->graph);
       });
     }},
    {"two threads that solve one graph", "two threads solve one graph at once",
     [](TwoSteps* g) {
       SolveOptions options;
       std::string said;
       options.callback = [&](const IterationInfo&) {
         std::thread([&] {
           said = test::Refusal<std::logic_error>([&] { SparseOptimizer(&g->graph).Solve(); });
         }).join();
         return false;
       };
       g->Solve(options);
       return said + g->Solve();  // and then it is free again
     }},
    {"no information", "H is zero; is all information zero",
     [](TwoSteps* g) {
       for (const auto& edge : g->edges_) edge->SetIsotropicInformation(0.0);
       return g->Solve();
     }},
    {"no preintegration", "EdgeImu: the preintegration is null",
     [] {
       const auto pose = std::make_shared<VertexPose>();
       const auto speed = std::make_shared<VertexSpeedBias>();
       EdgeImu(pose, speed, pose, speed, nullptr);
     }},
    {"a preintegration of no sample", "Preintegration: there is no IMU sample",
     [] { Preintegration(std::vector<ImuSample>(), Vec3::Zero(), Vec3::Zero(), {}); }},
    {"a preintegration of one step", "singular (2 samples over 0.100000 s): it takes three samples",
     [] {
       const std::vector<ImuSample> samples(2, {0.1, Vec3(0, 0, 9.81), Vec3::Zero()});
       EdgeImu(nullptr, nullptr, nullptr, nullptr,
               std::make_shared<Preintegration>(samples, Vec3::Zero(), Vec3::Zero(), ImuNoise()));
     }},
    {"a camera's place with a rotation of zero", "T_B_C: the quaternion is zero",
     [] {
       EdgeReprojectionPoseOnly(nullptr, Vec3::UnitZ(), Vec2::Zero(), {Qd(0, 0, 0, 0), Vec3::Zero()});
     }},
    {"a track of no poses", "EdgeTrack: a vertex is null",
     [] { EdgeTrack(std::make_shared<VertexInverseDepth>(1.0), std::vector<EdgeTrack::View>(2), {}, 1.0); }},
    {"a singular covariance", "EdgeSE3Prior: the covariance is singular",
     [] { EdgeSE3Prior(std::make_shared<VertexPose>(), Qd::Identity(), Vec3::Zero()).SetCovariance(Mat66::Zero()); }},
    {"directions of no vertex", "HeldDirections: the vertex or its rows are missing (null)",
     [](TwoSteps* g) {
       SparseOptimizer optimizer(&g->graph);
       optimizer.Hold({{nullptr, [] { return MatXX::Identity(1, 1); }}});
       optimizer.Solve();
     }},
    {"directions of a vertex of another graph", "HeldDirections: VertexVector1 0 is not in the solver's graph",
     [](TwoSteps* g) {
       TwoSteps other;
       SparseOptimizer optimizer(&g->graph);
       optimizer.Hold({{other.x_[0], [] { return MatXX::Identity(1, 1); }}});
       optimizer.Solve();
     }},
    {"directions of a landmark", "cannot be held: it is a landmark; give it the role of a pose",
     [](TwoSteps* g) {
       g->x_[0]->SetRole(Role::kLandmark);
       SparseOptimizer optimizer(&g->graph);
       optimizer.Hold({{g->x_[0], [] { return MatXX::Identity(1, 1); }}});
       optimizer.Solve();
     }},
    {"directions that are not numbers", "HeldDirections: the rows of VertexVector1 0 are not finite",
     [](TwoSteps* g) {
       SparseOptimizer optimizer(&g->graph);
       optimizer.Hold({{g->x_[0], [] { return MatXX::Constant(1, 1, std::nan("")); }}});
       optimizer.Solve();
     }},
    {"a residual of NaN, marginalized", "marginalizing: EdgeStep 0 has a residual or a Jacobian that is not finite",
     [] {
       TwoSteps g(Spoilt::kNaN);
       MarginalizeInto(&g.graph, {g.x_[0]});
     }},
    {"states so large that differences vanish", "every edge an outlier, or no residual changed by its vertices?",
     [](TwoSteps* g) {
       for (const auto& x : g->x_) x->SetEstimate(Scalar(1e150));
       return g->Solve();
     }},
    {"damping that lets nothing move", "is too short to change the cost; is SolveOptions::tau too large",
     [] { return SolveWith([](auto* o) { o->algorithm = Algorithm::kLevenbergMarquardt, o->tau = 1e20; }); }},
    {"a loss of negative slope", "the cost is negative",
     [](TwoSteps* g) {
       struct Falling : LossFunction {
         Rho Evaluate(double s) const override { return {-s, -1.0, 0.0}; }
       };
       for (const auto& edge : g->edges_) edge->SetLossFunction(std::make_shared<Falling>());
       return g->Solve();
     }},
    {"a callback that moves a vertex", "the callback has moved a vertex",
     [](TwoSteps* g) {
       SolveOptions options;
       options.callback = [&](const IterationInfo&) { return g->x_[1]->SetEstimate(Scalar(1e5)), true; };
       return g->Solve(options);
     }},
    {"directions of rank 0", "VertexVector1 0 cannot be held along no direction: its rows are missing or zero",
     [](TwoSteps* g) {
       SparseOptimizer optimizer(&g->graph);
       optimizer.Hold({{g->x_[0], [] { return MatXX::Zero(1, 1); }}});
       optimizer.Solve();
     }},
    {"a null vertex to optimize", "InitializeOptimization: a vertex is missing (null)",
     [](TwoSteps* g) {
       SparseOptimizer(&g->graph).InitializeOptimization({g->x_[0], nullptr});
     }},
    {"a vertex of another graph to optimize", "InitializeOptimization: VertexVector1 0 is not in the solver's graph",
     [](TwoSteps* g) { SparseOptimizer(&g->graph).InitializeOptimization({TwoSteps().x_[0]}); }},
    {"a null solver of one's own", "SetReducedSolver: the solver is null",
     [](TwoSteps* g) { SparseOptimizer(&g->graph).SetReducedSolver(std::unique_ptr<ReducedSolver>()); }},
    {"an edge that adds edges while it is evaluated", "an edge has changed the graph's edges while it was evaluated",
     [](TwoSteps* g) {
       g->graph.AddEdge(std::make_shared<EdgeThatAdds>(&g->graph, g->x_[1]));
       g->Solve();
     }},
    {"the cost of a graph to which an edge adds", "EdgeThatAdds 2 has changed the graph's edges while it was evaluated",
     [](TwoSteps* g) {
       g->graph.AddEdge(std::make_shared<EdgeThatAdds>(&g->graph, g->x_[1]));
       Cost(g->graph);
     }},
    {"no pose graph to initialize", "InitializePoseGraph: the graph is null",
     [] { InitializePoseGraph(PoseGraphStart::kChordal, nullptr); }},
    {"no pose graph to choose a start for", "InitializeAtLeastCost: the graph is null",
     [] { InitializeAtLeastCost({PoseGraphStart::kOdometry}, nullptr); }},
    {"no pose graph to find false loops in", "GiveUpFalseLoops: the graph is null",
     [] { GiveUpFalseLoops({}, nullptr, [] {}); }},
    {"nothing to solve with, of false loops", "GiveUpFalseLoops: what solves the graph is missing",
     [](TwoSteps* g) { GiveUpFalseLoops({}, &g->graph, nullptr); }},
    {"a scale of NaN, of false loops", "GraduatedOptions::scale = nan",
     [](TwoSteps* g) {
       GiveUpFalseLoops({Surrogate::kTruncated, kNaN}, &g->graph, [] {});
     }},
    {"no graph to marginalize in", "MarginalizeInto: the graph is null", [] { MarginalizeInto(nullptr, {}); }},
    {"an edge of sizes known at run time alone, without their memory",
     "EdgeWithoutMemory: an edge whose sizes are known at run time only needs a TakeJacobians",
     [](TwoSteps* g) {
       g->graph.AddEdge(std::make_shared<EdgeWithoutMemory>(g->x_[0]));
       return g->Solve();
     }},
    {"a vertex without memory", "AddVertex: VertexWithoutMemory has no memory for its parameters",
     [] { Graph().AddVertex(std::make_shared<VertexWithoutMemory>()); }},
    {"an edge without any memory", "AddEdge: EdgeWithoutMemory has no memory for its residual and information",
     [](TwoSteps* g) { g->graph.AddEdge(std::make_shared<EdgeWithoutMemory>(g->x_[0], false)); }},
    {"a measured rotation of zero", "EdgeSE3Between: the quaternion is zero",
     [] {
       const auto pose = std::make_shared<VertexPose>();
       EdgeSE3Between(pose, pose, Qd(0, 0, 0, 0), Vec3::Zero());
     }},
    {"a prior's rotation of NaN", "EdgeSE3Prior: the quaternion is not finite",
     [] { EdgeSE3Prior(std::make_shared<VertexPose>(), Qd(kNaN, 0, 0, 0), Vec3::Zero()); }},
    {"an exception while differentiating", "no such point, and x = 0.000000",
     [] {
       TwoSteps g(Spoilt::kThrows);
       try {
         g.Solve();
       } catch (const std::runtime_error& error) {
         return error.what() + std::string(", and x = ") + std::to_string(g.x_[0]->GetEstimate()[0]);
       }
       return std::string();
     }},
    {"a vertex without Plus",
     "VertexWithoutPlus has 4 parameters and 3 degrees of freedom, so it needs a Plus of its own",
     [] {
       Graph graph;
       const auto vertex = std::make_shared<VertexWithoutPlus>();
       graph.AddVertex(vertex);
       graph.AddEdge(std::make_shared<EdgeOnIt>(vertex));
       SparseOptimizer(&graph).Solve();
     }},
    {"a prior on a vertex without Minus", "so it needs a Minus of its own",
     [] {
       const auto vertex = std::make_shared<VertexWithoutPlus>();
       EdgePrior({{vertex}, {vertex->Parameters()}, MatXX::Identity(3, 3), VecX::Zero(3)}).ComputeResidual();
     }},
    {"an edge marginalized twice", "EdgeStep 0 stands twice",
     [](TwoSteps* g) {
       Marginalize({g->edges_[0], g->edges_[0]}, {g->x_[0]});
     }},
    {"a vertex marginalized without its edge", "VertexVector1 2 is to be dropped, but none of the edges has it",
     [](TwoSteps* g) { Marginalize({g->edges_[0]}, {g->x_[2]}); }},
    {"OKVIS's marginalization of no edge", "MarginalizationError: the edge is null",
     [] { MarginalizationError().AddResidualBlock(nullptr); }},
    {"VINS-Mono's marginalization of no edge", "MarginalizationInfo: the edge is null",
     [] {
       MarginalizationInfo().AddResidualBlockInfo({nullptr, {}});
     }},
    {"VINS-Mono's marginalization of a vertex in no graph",
     "MarginalizationInfo: a VertexPose of EdgeSE3Prior is in no graph",
     [] {
       const auto pose = std::make_shared<VertexPose>();
       MarginalizationInfo().AddResidualBlockInfo(
           {std::make_shared<EdgeSE3Prior>(pose, Qd::Identity(), Vec3::Zero()), {0}});
     }},
    {"a marginalization of no edge by QR", "Marginalize: an edge is null",
     [] { MarginalizeQr<double>({nullptr}, {}); }},
    {"a marginalization of nothing", "no edges", [](TwoSteps* g) { Marginalize({}, {g->x_[0]}); }},
};

const std::vector<Case> kOptions = {
    {"iterations", "SolveOptions::max_iterations = -5",
     [] { return SolveWith([](auto* o) { o->max_iterations = -5; }); }},
    {"a tolerance of NaN", "SolveOptions::cost_tolerance = nan: must be at least 0",
     [] { return SolveWith([](auto* o) { o->cost_tolerance = kNaN; }); }},
    {"damping without end", "SolveOptions::tau = inf", [] { return SolveWith([](auto* o) { o->tau = 1.0 / 0.0; }); }},
    {"trials", "SolveOptions::max_trials = 0", [] { return SolveWith([](auto* o) { o->max_trials = 0; }); }},
    {"100,000 threads", "threads = 100000: must be 1 to 1024", [](TwoSteps* g) { SparseOptimizer(&g->graph, 100000); }},
    {"an iterative solver's tolerance", "IterativeOptions::tolerance = -1",
     [](TwoSteps* g) { SparseOptimizer(&g->graph).SetReducedSolver(ReducedSolverType::kImplicitPcg, {-1.0}); }},
    {"a window in which nothing starts", "VinsOptions::window_size = 3: must be at least 4",
     [] { MakeVinsPolicy(With<VinsOptions>([](auto* o) { o->window_size = 3; })); }},
    {"seconds for a solve", "VinsOptions::max_solve_seconds = -1: must be at least 0",
     [] { MakeVinsPolicy(With<VinsOptions>([](auto* o) { o->max_solve_seconds = -1; })); }},
    {"keyframes", "OkvisOptions::keyframes = -3",
     [] { MakeOkvisPolicy(With<OkvisOptions>([](auto* o) { o->keyframes = -3; })); }},
    {"no policy", "the policy is null", [] { Estimator({}, nullptr); }},
    {"a focal length", "Calibration::fx = -460: must be greater than 0",
     [] { Estimate([](auto* o) { o->calibration.fx = -460; }); }},
    {"gravity", "Calibration::gravity = nan", [] { Estimate([](auto* o) { o->calibration.gravity = kNaN; }); }},
    {"an extrinsic rotation", "T_B_C.q.norm() = 2",
     [] { Estimate([](auto* o) { o->calibration.T_B_C.q.coeffs() *= 2.0; }); }},
    {"noise", "ImuNoise::gyroscope = 0", [] { Estimate([](auto* o) { o->calibration.noise.gyroscope = 0; }); }},
};

const std::vector<Case> kMeasurements = {
    {"measurements out of order", "the IMU measurement at t = 0.500000 s is before the one at t = 1.000000 s",
     [] {
       Estimator estimator({}, MakeVinsPolicy());
       estimator.AddImu({1.0, Vec3(0, 0, 9.81), Vec3::Zero()});
       estimator.AddImu({0.5, Vec3(0, 0, 9.81), Vec3::Zero()});
     }},
    {"a track twice", "stands twice in the image",
     [](Recording* r) { r->images[3].tracks.push_back(r->images[3].tracks[0]); }},
    {"a track of NaN", "is not finite", [](Recording* r) { r->images[3].tracks[0].x[0] = kNaN; }},
    {"a track at 1e160", "of the normalized plane, where no lens sees",
     [](Recording* r) { r->images[3].tracks[0].x[0] = 1e160; }},
    {"pixels", "are they pixels?",
     [](Recording* r) {
       for (Image& image : r->images) {
         for (TrackedPoint& point : image.tracks) point.x = r->calibration.Pixel(point.x);
       }
     }},
    {"tracks seen once", "no point of an image has the id of one in the image before",
     [id = 0](Recording* r) mutable {
       for (Image& image : r->images) {
         for (TrackedPoint& point : image.tracks) point.id = id++;
       }
     }},
    {"no IMU", "no IMU for too long", [](Recording* r) { r->imu.clear(); }},
    {"acceleration in g", "is it in units of g?",
     [] { return ChangeEach([](ImuMeasurement* m) { m->acceleration /= 9.81; }); }},
    {"rates in degrees", "are its rates in rad/s",
     [] { return ChangeEach([](ImuMeasurement* m) { m->gyroscope *= 180.0 / M_PI; }); }},
    {"columns swapped", "are their columns swapped?",
     [] { return ChangeEach([](ImuMeasurement* m) { std::swap(m->acceleration, m->gyroscope); }); }},
    {"densities for deviations", "if it is a density, set ImuNoise::continuous",
     [] {
       return Follow([](Recording* r) { r->images.resize(20); },
                     [](EstimatorOptions* o) { o->calibration.noise.continuous = false; });
     }},
    {"a start with information of NaN", "StartFrom: J holds a number that is not finite",
     [] { return StartFrom({}, MatXX::Constant(15, 15, kNaN)); }},
    {"a start without biases", "J must have 15 columns, got 9", [] { return StartFrom({}, MatXX::Identity(9, 9)); }},
    {"a start at NaN", "the state holds a number that is not finite",
     [] {
       StampedState state;
       state.v_W[0] = kNaN;
       return StartFrom(state, MatXX::Identity(15, 15));
     }},
    {"a solve that fails", "the window's solve failed",
     [] {
       return StartFrom(Flight().truth.front(), MatXX::Identity(15, 15).bottomRows(9),
                        std::make_unique<SingularPolicy>());
     }},
    {"measurements for an hour and no image", "feed images and measurements in order of time",
     [] {
       Estimator estimator({}, MakeVinsPolicy());
       for (int k = 0; k < 360'000; ++k) estimator.AddImu({0.01 * k, Vec3(0, 0, 9.81), Vec3::Zero()});
       estimator.AddFrame({1.0, {}});
     }},
    {"a file that is cut", "the file ends in the middle of a line; is it cut?",
     [] { return ReadChanged("tracks.csv", [](std::string* text) { text->resize(text->size() - 4); }); }},
    {"quaternions with the scalar last", "these agree with the gyroscope in the order x, y, z, w",
     [] {
       return ReadChanged("groundtruth.csv", [](std::string* text) {
         std::istringstream lines(*text);
         std::string line, changed;
         for (int k = 0; std::getline(lines, line); ++k) {
           std::vector<std::string_view> cells = SplitAt(',', line);
           if (k > 0) std::rotate(cells.begin() + 4, cells.begin() + 5, cells.begin() + 8);
           for (size_t c = 0; c < cells.size(); ++c) changed += (c > 0 ? "," : "") + std::string(cells[c]);
           changed += "\n";
         }
         *text = changed;
       });
     }},
    {"TUM's format with the scalar first",
     "must stand in the order x, y, z, w; these agree with the gyroscope in the order w, x, y, z",
     [] {
       return ReadChanged("groundtruth.csv", [](std::string* text) {
         std::istringstream lines(*text);
         std::string line, changed;
         for (std::getline(lines, line); std::getline(lines, line);) {
           const std::vector<std::string_view> cells = SplitAt(',', line);
           changed += std::to_string(1e-9 * std::stod(std::string(cells[0])));
           for (size_t c = 1; c < 8; ++c) changed += " " + std::string(cells[c]);
           changed += "\n";
         }
         *text = changed;
       });
     }},
};

void Check(const std::vector<Case>& cases) {
  for (const Case& one : cases) {
    std::string said;
    try {
      said = one.said();
    } catch (const std::exception& error) {
      said = error.what();
    }
    EXPECT_NE(said.find(one.expected), std::string::npos) << one.name << " says \"" << said << "\"";
  }
}

TEST(Misuse, OfAGraph) { Check(kGraphs); }
TEST(Misuse, OfOptions) { Check(kOptions); }
// Those beside the rows of the table: a field that nobody checks would be silent.
template <typename Options>
void ExpectEachIsChecked(const std::vector<double Options::*>& fields) {
  for (size_t k = 0; k < fields.size(); ++k) {
    for (const double wrong : {kNaN, -20.0}) {
      Options options;
      options.*fields[k] = wrong;
      EXPECT_THROW(options.Validate(), OptionError) << "field " << k << " = " << wrong;
    }
  }
}
TEST(Misuse, EachNumberOfTheOptionsIsChecked) {
  using S = SolveOptions;
  ExpectEachIsChecked<S>({&S::cost_tolerance, &S::gradient_tolerance, &S::step_tolerance, &S::tau, &S::initial_radius});
  using N = ImuNoise;
  ExpectEachIsChecked<N>({&N::accelerometer, &N::gyroscope, &N::accelerometer_walk, &N::gyroscope_walk});
  using E = EstimatorOptions;
  ExpectEachIsChecked<E>({&E::time_offset, &E::max_outlier_pixels, &E::max_imu_gap, &E::max_bridged_gap,
                          &E::max_rejecting, &E::reintegrate_gyroscope, &E::start_pixels, &E::start_speed,
                          &E::moving_start_speed, &E::start_bias_accelerometer, &E::start_bias_gyroscope,
                          &E::start_extrinsic_position, &E::start_extrinsic_rotation, &E::start_time_offset});
  using D = DynamicInitializationOptions;
  ExpectEachIsChecked<D>({&D::focal_length, &D::pixel_sigma, &D::gravity, &D::b_a_sigma, &D::least_parallax,
                          &D::largest_scale_sigma, &D::largest_gravity_sigma, &D::least_inliers});
  ExpectEachIsChecked<StandstillOptions>({&StandstillOptions::seconds, &StandstillOptions::pixels,
                                          &StandstillOptions::acceleration, &StandstillOptions::change});
  using F = FailureLimits;
  ExpectEachIsChecked<F>({&F::accelerometer_bias, &F::gyroscope_bias, &F::step, &F::climb});
  using W = WindowWeights;
  ExpectEachIsChecked<W>({&W::pixel_sigma, &W::cauchy, &W::max_imu_seconds});
  using V = VinsOptions;
  ExpectEachIsChecked<V>({&V::parallax_pixels, &V::keyframe_seconds, &V::slow_seconds, &V::cost_tolerance});
  using O = OkvisOptions;
  ExpectEachIsChecked<O>({&O::hull_ratio, &O::match_ratio, &O::view_angle, &O::gauge_information,
                          &O::later_gauge_information, &O::cost_tolerance});
  ExpectEachIsChecked<IterativeOptions>({&IterativeOptions::tolerance, &IterativeOptions::model_tolerance});
}

TEST(Misuse, OfMeasurements) { Check(kMeasurements); }
TEST(Misuse, NothingIsSaidWhereNothingIsWrong) {
  EXPECT_EQ(Follow([](Recording*) {}), "");
}

}  // namespace
}  // namespace ch5
