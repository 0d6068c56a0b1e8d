#include "ch5_backend/experiments/studies/homework/homework_study.h"

#include <cmath>

#include "ch5_backend/dense/blocks/plain_block_solver.h"
#include "ch5_backend/dense/problem.h"
#include "ch5_backend/experiments/studies/gauge/gauge_studies.h"
#include "ch5_backend/experiments/studies/homework/graded_priors.h"
#include "ch5_backend/experiments/studies/matrices.h"
#include "ch5_backend/experiments/studies/odometry_study.h"
#include "ch5_backend/experiments/studies/prior_study.h"
#include "ch5_backend/files/bal.h"
#include "ch5_backend/files/recording_file.h"
#include "ch5_backend/sparse/sparse_solver.h"

namespace ch5 {
namespace {

using Path = std::filesystem::path;
using Show = std::function<void(double)>;

MonoBaOptions Scene(int frames, int points) {
  MonoBaOptions options{frames, points};
  options.position_sigma = 0.1;
  options.rotation_sigma = 2.0 * M_PI / 180.0;
  return options;
}

// The gauge is free or fixed: a prior would be stage 3's.
MonoBa Build(const MonoBaOptions& options, Gauge gauge) {
  const double information = 1.0 / std::pow(options.pixel_sigma, 2);
  return BuildMonoBa(SimulateMonoBa(options), gauge, information, /*prior_weight=*/0.0);
}

CsvTable ConvergenceTable(const Summary& summary) {
  CsvTable table("iteration,cost,lambda");
  for (const IterationInfo& info : summary.trace) table.Row(info.iteration, info.cost, info.lambda);
  return table;
}

// ---- Stages 1 to 4, and 7 -----------------------------------------------------------------------------------------

void RunHessian(const Path& csv, const std::string&, const Show&) {
  MonoBa ba = Build(MonoBaOptions(), Gauge::kFixTwoFrames);
  Problem problem(&ba.graph);
  problem.SetDamping(Damping::kDiagonal);
  problem.SetOrdering();
  problem.MakeHessian();
  CsvTable matrices("matrix,row,column,value");
  AppendNonZeros(problem.Hessian(), &matrices, "H");
  AppendNonZeros(problem.RightHandSide(), &matrices, "b");
  matrices.Write(csv / "matrices.csv");  // stage 1.1 can be told even if 1.2 breaks off
  VecX delta_x = VecX::Zero(problem.Size());
  problem.SolveLinearSystem(/*lambda=*/1e-3, &delta_x);
  AppendNonZeros(problem.SchurComplement(), &matrices, "S");
  AppendNonZeros(delta_x, &matrices, "Δx");
  matrices.Write(csv / "matrices.csv");

  MonoBa large = Build(Scene(10, 100), Gauge::kFixTwoFrames);
  Problem solved(&large.graph);
  solved.SetDamping(Damping::kDiagonal);
  ConvergenceTable(solved.Solve()).Write(csv / "convergence.csv");
}

void RunMarginal(const Path& csv, const std::string&, const Show&) {
  CsvTable matrices("matrix,row,column,value");
  const MarginalizeResult chain = Problem::TestMarginalize(SlidesChain(), VecX::Ones(3), /*idx=*/1, /*dim=*/1);
  AppendNonZeros(chain.H_moved, &matrices, "moved chain");
  AppendNonZeros(chain.H_prior, &matrices, "prior of the chain");
  AppendNonZeros(chain.b_prior, &matrices, "b of the chain");

  // H and b by the sparse solver, so that nothing but this stage is tried.
  const int frames = 5, points = 12;
  MonoBa ba = Build(Scene(frames, points), Gauge::kFree);
  SparseSolver solver(&ba.graph);
  solver.SetOrdering();
  solver.MakeHessian();
  const auto without_points =
      Problem::TestMarginalize(solver.DenseHessian(), solver.RightHandSide(), /*idx=*/6 * frames, /*dim=*/points);
  const auto without_frame =
      Problem::TestMarginalize(without_points.H_prior, without_points.b_prior, /*idx=*/6, /*dim=*/6);
  AppendNonZeros(without_points.H_prior, &matrices, "without points");
  AppendNonZeros(without_frame.H_prior, &matrices, "without frame 1");
  AppendNonZeros(without_frame.b_prior, &matrices, "b without frame 1");
  matrices.Write(csv / "matrices.csv");
}

void RunWeights(const Path& csv, const std::string&, const Show& progress) {
  CsvTable table("variant,weight,iterations,cost,drift_m");
  const std::vector<double> weights = PriorWeights();
  double done = 0.0;
  for (const PriorVariant& variant : PriorVariants()) {
    if (variant.gauge != Gauge::kPriorTwoFrames) continue;  // that prior is not the homework's
    const MonoBaScene scene = SimulateMonoBa(variant.scene);
    for (const double weight : weights) {
      if (weight == 0.0) continue;
      MonoBa ba = BuildMonoBa(scene, variant.gauge, variant.pixel_information, weight);
      Problem problem(&ba.graph);
      problem.SetDamping(variant.damping);
      const Summary summary = problem.Solve(UsualOptions());
      table.Row(variant.name, weight, summary.iterations, summary.final_cost,
                (ba.poses[0]->p() - scene.frames[0].p).norm());
      progress(++done / (2.0 * static_cast<double>(weights.size())));
    }
  }
  table.Write(csv / "weights.csv");
}

// A scene, or a BAL problem; each solver begins at the same start.
void Adjust(const std::string& data, const std::function<void(Graph*)>& solve) {
  if (data.empty()) {
    MonoBa ba = Build(Scene(20, 300), Gauge::kFixTwoFrames);
    return solve(&ba.graph);
  }
  BalGraph bal = BuildBal(ReadBal(data), nullptr);
  solve(&bal.graph);
}

template <typename Solver>
Summary TimedSolve(const std::string& data, const char* name, CsvTable* times) {
  Summary summary;
  Adjust(data, [&](Graph* graph) {
    Solver solver(graph);
    solver.SetDamping(Damping::kDiagonal);
    summary = Minimize(&solver);
  });
  times->Row(name, 1e3 * summary.seconds / std::max(1, summary.iterations));
  return summary;
}

void RunBlocks(const Path& csv, const std::string& data, const Show&) {
  CsvTable times("solver,milliseconds");
  ConvergenceTable(TimedSolve<PlainBlockSolver>(data, "PlainBlockSolver", &times)).Write(csv / "convergence.csv");
  if (data.empty()) TimedSolve<Problem>(data, "Problem", &times);  // a dense H of a file would not fit into memory
  TimedSolve<SparseSolver>(data, "SparseSolver", &times);
  times.Write(csv / "times.csv");
}

// ---- Stages 5 and 6 -----------------------------------------------------------------------------------------------

void Fly(const std::string& policy, const Marginalizer& marginalizer, const Path& csv, const std::string& data,
         const Show& progress) {
  const Recording recording = data.empty() ? SimulatedOdometryRecording() : ReadRecording(data);
  EstimatorOptions options{recording.calibration};
  options.marginalizer = marginalizer;
  auto policies = AllPolicies();
  const auto chosen =
      std::find_if(policies.begin(), policies.end(), [&](const auto& p) { return p->Name() == policy; });

  CsvTable path("image,t_s,x_m,y_m,z_m"), truth("t_s,x_m,y_m,z_m"), summary("ate_m,yaw_rad,x_m,y_m,z_m,restarts");
  for (const StampedState& state : recording.truth) {
    truth.Row(state.t, state.T_W_B.p.x(), state.T_W_B.p.y(), state.T_W_B.p.z());
  }
  truth.Write(csv / "truth.csv");
  Estimator estimator(options, std::move(*chosen));
  std::vector<StampedState> states;
  int image = 0;
  const auto note = [&](const Estimator&, const ImageResult& row) {
    if (row.report.state) {
      const Vec3 p = row.report.state->T_W_B.p;
      path.Row(image, row.t, p.x(), p.y(), p.z());
      states.push_back(*row.report.state);
    }
    progress(static_cast<double>(++image) / static_cast<double>(recording.images.size()));
  };
  try {
    FeedRecording(recording, &estimator, note);
  } catch (...) {  // the picture shows how far it came
    path.Write(csv / "path.csv");
    throw;
  }
  path.Write(csv / "path.csv");
  const auto error = CompareTrajectories(states, recording.truth);
  const Vec3 p = error ? error->alignment.p : Vec3::Constant(NAN);
  summary.Row(error ? error->position_rmse : NAN, error ? error->alignment.yaw : NAN, p.x(), p.y(), p.z(),
              estimator.Restarts());
  summary.Write(csv / "summary.csv");
}

}  // namespace

const std::vector<HomeworkExperiment>& HomeworkExperiments() {
  static const std::vector<HomeworkExperiment> experiments = {
      {"hessian", RunHessian},
      {"marginal", RunMarginal},
      {"weights", RunWeights},
      {"gauge", [](const Path& csv, const std::string&,
                   const Show&) { GaugeDeviationsTable(/*trial=*/0, {}).Write(csv / "deviations.csv"); }},
      {"okvis", [](const auto&... where) { Fly("okvis", PriorByMarginalizationError, where...); }},
      {"vins", [](const auto&... where) { Fly("vins", PriorByMarginalizationInfo, where...); }},
      {"blocks", RunBlocks},
      {"beacons", [](const Path& csv, const std::string&, const Show&) { RunBeacons(csv); }}};
  return experiments;
}

}  // namespace ch5
