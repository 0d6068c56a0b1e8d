#include "ch5_backend/experiments/studies/bal_study.h"

#include <filesystem>
#include <stdexcept>

namespace ch5 {
namespace {

CsvTable SummaryOf(const BalStudy& study, const FileSolveOptions& options) {
  CsvTable table = SummaryTable(study.summary, options);
  table.Row("cameras", study.after.cameras.size());
  table.Row("points", study.after.points.size());
  table.Row("observations", study.after.observations.size());
  table.Row("mean_error_before_px", study.mean_error_before);
  table.Row("mean_error_after_px", study.mean_error_after);
  table.Row("observations_behind_camera", study.behind_camera);
  table.Row("huber_px", options.huber);
  table.Row("repeated_observations", study.left_out.empty() ? 0 : study.left_out[0].count);
  table.Row("first_repeated", study.left_out.empty() ? "" : study.left_out[0].first);
  table.Row("last_line_unended", study.before.unended.empty() ? 0 : 1);
  return table;
}

CsvTable PointTable(const BalStudy& study) {
  CsvTable table("x_before,y_before,z_before,x_after,y_after,z_after");
  for (size_t i = 0; i < study.after.points.size(); ++i) {
    const Vec3 &p = study.before.points[i], &q = study.after.points[i];
    table.Row(p.x(), p.y(), p.z(), q.x(), q.y(), q.z());
  }
  return table;
}

// Position and axes of each camera in the world: x to the right, y up, d into the picture.
CsvTable CameraTable(const BalStudy& study) {
  CsvTable table("state,camera,x,y,z,right_x,right_y,right_z,up_x,up_y,up_z,d_x,d_y,d_z");
  for (const auto& [state, problem] : {std::pair("before", &study.before), {"after", &study.after}}) {
    for (size_t i = 0; i < problem->cameras.size(); ++i) {
      const Vec9& camera = problem->cameras[i];
      const Vec3 c = CameraCenter(camera);
      const Mat33 R = CameraAxes(camera);
      table.Row(state, i, c.x(), c.y(), c.z(), R(0, 0), R(1, 0), R(2, 0), R(0, 1), R(1, 1), R(2, 1), R(0, 2), R(1, 2),
                R(2, 2));
    }
  }
  return table;
}

}  // namespace

BalStudy SolveBal(const BalProblem& problem, const FileSolveOptions& options, BalPoints move) {
  BalStudy study;
  study.before = study.after = problem;
  BalGraph bal =
      BuildBal(study.after, options.huber > 0.0 ? std::make_shared<HuberLoss>(options.huber) : nullptr, move);
  for (size_t i = 0; i < problem.observations.size(); ++i) {
    bal.graph.Edges()[i]->ComputeResidual();
    if (bal.graph.Edges()[i]->Residual().allFinite()) continue;
    const BalObservation& observation = problem.observations[i];
    throw std::invalid_argument("observation " + std::to_string(i) + ": point " + std::to_string(observation.point) +
                                " cannot be projected into camera " + std::to_string(observation.camera) +
                                ": the residual is not finite");
  }
  study.mean_error_before = MeanReprojectionError(bal.graph);
  study.behind_before = static_cast<int>(EdgesOutOfDomain(bal.graph).size());

  FileSolveOptions suited = options;
  suited.solve.tau = bal.tau;
  suited.solve.rescue_steps = bal.rescue_steps;
  study.summary = SolveGraph(&bal.graph, suited);
  study.mean_error_after = MeanReprojectionError(bal.graph);
  study.behind_camera = static_cast<int>(EdgesOutOfDomain(bal.graph).size());
  if (IsConverged(study.summary.termination) || study.summary.termination == Termination::kMaxIterations)
    study.hint = HintAtHuber(bal.graph, options, {5.0, 0.65, 1.0});  // public files have at most 0.55 of the cost there
  ReadBack(bal, &study.after);
  return study;
}

void WriteBalStudy(const BalStudy& study, const FileSolveOptions& options) {
  const std::filesystem::path out = options.out;
  const std::string name = options.Name();
  FileBatch files(options.input);
  files.Add(out / (name + "-result.txt"), FormatBal(study.after));
  files.Add(out / (name + "-before.ply"), FormatBalPly(study.before));
  files.Add(out / (name + "-after.ply"), FormatBalPly(study.after));
  files.Add(out / "points.csv", PointTable(study).Text());
  files.Add(out / "cameras.csv", CameraTable(study).Text());
  files.Add(out / "trace.csv", TraceTable(study.summary).Text());
  files.Add(out / "summary.csv", SummaryOf(study, options).Text());
  files.Commit();
}

}  // namespace ch5
