/// Where an iteration's time goes: measure_steps PROBLEM [--solver WORD] [--repeat N].

#include <cstdio>
#include <functional>
#include <stdexcept>

#include "ch5_backend/dense/blocks/plain_block_solver.h"
#include "ch5_backend/dense/problem.h"
#include "ch5_backend/experiments/studies/command_line.h"
#include "ch5_backend/experiments/studies/pose_graph_study.h"
#include "ch5_backend/experiments/studies/window_graph.h"
#include "ch5_backend/math/median.h"
#include "ch5_backend/sparse/sparse_solver.h"
#include "tests/bench/measure.h"
#include "tests/bench/measure_machine.h"
#include "tests/bench/process.h"

namespace ch5::bench {
namespace {

constexpr char kUsage[] =
    "usage: measure_steps PROBLEM [--solver sparse|plain|dense] [--repeat N]\n"
    "Times each step of an iteration at the start of PROBLEM (a BAL file, a window, scene:FRAMESxPOINTS, or "
    "city:CAMERAS), the "
    "median\n"
    "of N; prints step,milliseconds,flop,bytes. The last two are counted, 0 where they are not. PROBLEM may be\n"
    "'machine': prints peak,GFLOP/s and read,megabytes,GB/s.\n";

constexpr double kLambda = 1e-4;

struct Options {
  std::string problem, solver = "sparse";
  int repeat = 15;
};

// Of the processor's time, which other programs do not disturb as much as the clock's.
double Milliseconds(const std::function<void()>& work) {
  const Stopwatch watch(/*wall=*/false);
  work();
  return 1e3 * watch.Seconds();
}

// The steps of an iteration in turn, `repeat` times after one to warm up; prints each one's median.
struct Step {
  const char* name;
  std::function<void()> work;
  double flop = 0.0, bytes = 0.0;
  std::vector<double> times = {};
};

void MeasureAll(std::vector<bench::Step> steps, int repeat) {
  for (int turn = 0; turn <= repeat; ++turn) {
    for (bench::Step& step : steps) {
      const double time = Milliseconds(step.work);
      if (turn > 0) step.times.push_back(time);
    }
  }
  for (bench::Step& step : steps) {
    std::printf("%s,%.6g,%.6g,%.6g\n", step.name, Median(step.times), step.flop, step.bytes);
  }
}

// Products alone: those of an edge's Jacobians (2 rows), G⁻¹ and S of the landmarks, Cholesky, back-substitution. Bytes
// are those of H_pl and of the measurements, which no cache holds in a large problem. Only for blocks of one size.
struct Counts {
  double linearize_flop = 0.0, invert_flop = 0.0, schur_flop = 0.0, poses_flop = 0.0, back_flop = 0.0;
  double H_pl_bytes = 0.0, measurement_bytes = 0.0;
};

Counts Count(const Structure& s) {
  Counts counts;
  if (!s.sizes.AreFixed() || !s.OneEdgePerSlot()) return counts;
  const double P = s.sizes.rows, L = s.sizes.columns, slots = static_cast<double>(s.slot_pose.size());
  counts.linearize_flop = 4.0 * slots * (P * (P + 1) / 2 + P * L + L * (L + 1) / 2 + P + L);
  counts.invert_flop = s.NumLandmarks() * L * L * L;
  for (int l = 0; l < s.NumLandmarks(); ++l) {
    const double k = s.landmark_slots[l + 1] - s.landmark_slots[l];
    counts.schur_flop += k * P * L * (L + 1) + k * (k + 1) / 2 * 2.0 * P * P * L;
  }
  const double n = s.ordering.dim_poses;
  counts.poses_flop = n * n * n / 3.0;
  counts.back_flop = slots * 2.0 * P * L + s.NumLandmarks() * 4.0 * L * L;
  counts.H_pl_bytes = slots * P * L * 8.0;
  counts.measurement_bytes = slots * 16.0;
  return counts;
}

void MeasureSparse(Graph* graph, const Options& options) {
  SparseSolver solver(graph);
  solver.SetReducedSolver(ReducedSolverType::kSparseCholesky);  // S is formed, however many poses there are
  solver.SetDamping(Damping::kDiagonal);
  solver.SetOrdering();
  solver.MakeHessian();
  const Structure& s = solver.GetStructure();
  const DampingRule rule{kLambda, Damping::kDiagonal};
  ThreadPool pool(1);
  Eliminated eliminated;
  eliminated.Resize(s);
  eliminated.S.SetPattern(s.pose_dim, SchurPattern(s));
  SchurGroups groups = PrepareSchurGroups(s, eliminated.S, /*threads=*/1);
  const std::unique_ptr<ReducedSolver> reduced = MakeReducedSolver(ReducedSolverType::kAutomatic);
  reduced->Prepare(eliminated.S, &pool);
  ch5::Step step;
  step.delta_x.setZero(s.Size());
  step.H_pp_delta.setZero(s.ordering.dim_poses);
  VecX poses = VecX::Zero(s.ordering.dim_poses);
  const Counts c = Count(s);
  MeasureAll({{"linearize", [&] { solver.MakeHessian(); }, c.linearize_flop, c.H_pl_bytes + c.measurement_bytes},
              {"invert", [&] { InvertLandmarks(s, solver.GetLinearized(), rule, &pool, &eliminated); }, c.invert_flop},
              {"schur", [&] { FormSchurComplement(s, solver.GetLinearized(), rule, &groups, &pool, &eliminated); },
               c.schur_flop, c.H_pl_bytes},
              {"poses", [&] { reduced->Solve(eliminated.S, eliminated.b_S, eliminated.damped_diagonal, &poses); },
               c.poses_flop},
              {"back",
               [&] {
                 step.delta_x.head(poses.size()) = poses;
                 BackSubstitute(s, solver.GetLinearized(), eliminated, &pool, &step);
               },
               c.back_flop, c.H_pl_bytes},
              {"update", [&] { solver.UpdateStates(step.delta_x); }},
              {"rollback", [&] { solver.RollbackStates(); }},
              {"cost", [&] { solver.Cost(); }, 0.0, c.measurement_bytes}},
             options.repeat);
}

// A solver that is one piece.
void MeasureWhole(NormalEquations* system, int repeat) {
  system->SetDamping(Damping::kDiagonal);
  system->SetOrdering();
  VecX delta_x;
  MeasureAll({{"linearize", [&] { system->MakeHessian(); }},
              {"solve", [&] { system->SolveLinearSystem(kLambda, &delta_x); }},
              {"update", [&] { system->UpdateStates(delta_x); }},
              {"rollback", [&] { system->RollbackStates(); }},
              {"cost", [&] { system->Cost(); }}},
             repeat);
}

void Measure(Graph* graph, const Options& options) {
  if (options.solver == "sparse") return MeasureSparse(graph, options);
  if (options.solver == "plain") {
    PlainBlockSolver solver(graph);
    return MeasureWhole(&solver, options.repeat);
  }
  if (options.solver != "dense")
    throw std::invalid_argument("--solver is sparse, plain or dense, got '" + options.solver + "'");
  ch5::Problem problem(graph);
  MeasureWhole(&problem, options.repeat);
}

void MeasureMachine() {
  std::printf("peak,%.6g\n", PeakGflops());
  for (const double megabytes : {0.25, 8.0, 256.0}) std::printf("read,%g,%.6g\n", megabytes, ReadBandwidth(megabytes));
}

void Run(const Options& options) {
  if (options.problem == "machine") return MeasureMachine();
  const Problem problem = ReadProblem(options.problem);
  if (problem.kind == Problem::Kind::kWindow) {
    WindowGraph window = BuildWindowGraph(problem.window);
    return Measure(&window.graph, options);
  }
  if (problem.kind != Problem::Kind::kBal) throw std::invalid_argument("a pose graph has no landmarks");
  BalGraph bal = BuildBal(problem.bal, nullptr);
  Measure(&bal.graph, options);
}

}  // namespace
}  // namespace ch5::bench

int main(int argc, char** argv) {
  ch5::bench::Options options;
  ch5::CommandLine line("measure_steps", ch5::bench::kUsage);
  line.Argument("PROBLEM", &options.problem);
  line.Text("--solver", &options.solver);
  line.Number("--repeat", 1, 1000, &options.repeat);
  return line.Run(argc, argv, [&] { ch5::bench::Run(options); });
}
