#include <cmath>
#include <string>
#include <vector>

#include "ch5_backend/dense/problem.h"
#include "ch5_backend/evaluate/reconstruction.h"
#include "ch5_backend/experiments/studies/chapter_studies.h"
#include "ch5_backend/experiments/studies/matrices.h"

namespace ch5 {
namespace {

struct MonoBaCase {
  std::string name;
  MonoBaOptions scene;
  Gauge gauge;
  double prior_weight;
  double pixel_information;  // W = pixel_information·I₂
  Damping damping;
};

// "course": 3 frames × 20 points as the course sets it: poses start at the truth, two are fixed, W = I.
// "large": 10 × 300, poses start 20 cm and 3° (one σ, each axis) beside the truth, W = 1/σ², minimal gauge.
std::vector<MonoBaCase> MonoBaCases() {
  MonoBaOptions large{10, 300};
  large.position_sigma = 0.2;
  large.rotation_sigma = 3.0 * M_PI / 180.0;
  const double information = 1.0 / std::pow(large.pixel_sigma, 2);
  return {{"course", MonoBaOptions(), Gauge::kFixTwoFrames, 0.0, 1.0, Damping::kIdentity},
          {"large", large, Gauge::kPriorMinimal, information, information, Damping::kDiagonal}};
}

struct MonoBaTables {
  CsvTable summary{
      "scene,frames,points,unknowns,edges,initial_cost,final_cost,iterations,cost_evaluations,milliseconds,"
      "initial_rmse_position_m,initial_rmse_rotation_rad,initial_rmse_landmark_m,final_rmse_position_m,"
      "final_rmse_rotation_rad,final_rmse_landmark_m,termination"};
  CsvTable trace{"scene,iteration,cost,lambda,gain_ratio,step_norm,gradient_max,trials,seconds"};
  CsvTable frames{"scene,state,frame,x_m,y_m,z_m,qx,qy,qz,qw"};
  CsvTable points{"scene,state,point,x_m,y_m,z_m"};
  CsvTable iterations{"scene,iteration,point,x_m,y_m,z_m"};
  CsvTable hessian{"scene,matrix,row,column,value"};
  HessianBlockTables hessian_blocks;
  CsvTable spectrum{"gauge,index,eigenvalue"};
};

void AppendReconstruction(const std::string& scene, const std::string& state, const Reconstruction& world,
                          MonoBaTables* tables) {
  int i = 0;
  for (const Transform& T : world.frames) {
    tables->frames.Row(scene, state, i++, T.p.x(), T.p.y(), T.p.z(), T.q.x(), T.q.y(), T.q.z(), T.q.w());
  }
  int k = 0;
  for (const Vec3& p : world.points) tables->points.Row(scene, state, k++, p.x(), p.y(), p.z());
}

void AppendSummary(const MonoBaCase& study, const Summary& s, int unknowns, size_t edges, const Rmse& before,
                   const Rmse& after, MonoBaTables* tables) {
  tables->summary.Row(study.name, study.scene.frames, study.scene.points, unknowns, edges, s.initial_cost, s.final_cost,
                      s.iterations, s.cost_evaluations, 1e3 * s.seconds, before.position, before.rotation, before.point,
                      after.position, after.rotation, after.point, ToString(s.termination));
  for (const IterationInfo& info : s.trace) {
    tables->trace.Row(study.name, info.iteration, info.cost, info.lambda, info.gain_ratio, info.step_norm,
                      info.gradient_max, info.trials, info.seconds);
  }
}

// Appends H of the scene with a free gauge at the states of `ba`, its Schur complement on the poses, and what made their blocks.
void AppendFreeHessian(const MonoBaCase& study, const MonoBaScene& scene, const MonoBa& ba, MonoBaTables* tables) {
  MonoBa free = BuildMonoBa(scene, Gauge::kFree, study.pixel_information, /*prior_weight=*/0.0);
  for (size_t i = 0; i < free.poses.size(); ++i) free.poses[i]->SetEstimate(ba.poses[i]->GetEstimate());
  for (size_t k = 0; k < free.landmarks.size(); ++k) {
    free.landmarks[k]->SetEstimate(ba.landmarks[k]->GetEstimate());
  }
  Problem problem(&free.graph);
  problem.MakeHessian();
  VecX none;  // without damping the free system has no solution, but the Schur complement is made on the way
  problem.SolveLinearSystem(/*lambda=*/0.0, &none);
  AppendNonZeros(problem.Hessian(), &tables->hessian, study.name, "H");
  AppendNonZeros(problem.SchurComplement(), &tables->hessian, study.name, "S");
  AppendHessianBlocks(free.graph, study.name, &tables->hessian_blocks);
}

void RunCase(const MonoBaCase& study, MonoBaTables* tables) {
  const MonoBaScene scene = SimulateMonoBa(study.scene);
  MonoBa ba = BuildMonoBa(scene, study.gauge, study.pixel_information, study.prior_weight);
  const Reconstruction truth = TruthOf(scene), initial = EstimateOf(scene, ba);
  Problem problem(&ba.graph);
  problem.SetDamping(study.damping);
  SolveOptions options;
  options.callback = [&](const IterationInfo& info) {
    int k = 0;
    const Reconstruction aligned = AlignToTruth(EstimateOf(scene, ba), truth).value();
    for (const Vec3& p : aligned.points) {
      tables->iterations.Row(study.name, info.iteration, k++, p.x(), p.y(), p.z());
    }
    return true;
  };
  const Summary summary = problem.Solve(options);
  const Reconstruction estimate = EstimateOf(scene, ba), final_state = AlignToTruth(estimate, truth).value();

  AppendReconstruction(study.name, "truth", truth, tables);
  AppendReconstruction(study.name, "initial", initial, tables);
  AppendReconstruction(study.name, "final", final_state, tables);
  AppendSummary(study, summary, problem.Size(), ba.graph.Edges().size(), Compare(initial, truth),
                CompareAligned(estimate, truth).value(), tables);
  AppendFreeHessian(study, scene, ba, tables);
}

// The eigenvalues of H at the optimum of the small scene under each gauge: seven zeros, or none.
void AppendSpectra(MonoBaTables* tables) {
  const double information = 1.0 / std::pow(MonoBaOptions().pixel_sigma, 2);
  const MonoBaScene scene = SimulateMonoBa(MonoBaOptions());
  const std::pair<const char*, Gauge> gauges[] = {{"free", Gauge::kFree},
                                                  {"minimal prior", Gauge::kPriorMinimal},
                                                  {"prior on two frames", Gauge::kPriorTwoFrames},
                                                  {"two frames fixed", Gauge::kFixTwoFrames}};
  for (const auto& [name, gauge] : gauges) {
    MonoBa ba = BuildMonoBa(scene, gauge, information, /*prior_weight=*/information);
    Problem problem(&ba.graph);
    problem.SetDamping(Damping::kDiagonal);
    problem.Solve();
    problem.MakeHessian();
    const VecX eigenvalues = Eigenvalues(problem.Hessian());
    for (int i = 0; i < eigenvalues.size(); ++i) tables->spectrum.Row(name, i, eigenvalues[i]);
  }
}

}  // namespace

void RunMonoBaStudy(const std::filesystem::path& csv, const std::function<void(double)>& progress) {
  MonoBaTables tables;
  const auto cases = MonoBaCases();
  for (size_t i = 0; i < cases.size(); ++i) {
    RunCase(cases[i], &tables);
    progress(static_cast<double>(i + 1) / static_cast<double>(cases.size() + 1));
  }
  AppendSpectra(&tables);
  tables.summary.Write(csv / "mono_ba_summary.csv");
  tables.trace.Write(csv / "mono_ba_trace.csv");
  tables.frames.Write(csv / "mono_ba_frames.csv");
  tables.points.Write(csv / "mono_ba_points.csv");
  tables.iterations.Write(csv / "mono_ba_iterations.csv");
  tables.hessian.Write(csv / "hessian.csv");
  tables.hessian_blocks.vertices.Write(csv / "hessian_vertices.csv");
  tables.hessian_blocks.edges.Write(csv / "hessian_edges.csv");
  tables.hessian_blocks.blocks.Write(csv / "hessian_blocks.csv");
  tables.spectrum.Write(csv / "spectrum.csv");
  progress(1.0);
}

}  // namespace ch5
