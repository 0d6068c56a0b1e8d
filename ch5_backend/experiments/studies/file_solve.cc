#include "ch5_backend/experiments/studies/file_solve.h"

#include <algorithm>
#include <stdexcept>

#include "ch5_backend/sparse/sparse_optimizer.h"

namespace ch5 {
namespace {

// `text` with _ for what a cell cannot hold: commas, quotes and line ends.
std::string CsvWord(std::string text) {
  const auto is_special = [](char c) { return c == ',' || c == '"' || c == '\n'; };
  std::replace_if(text.begin(), text.end(), is_special, '_');
  return text;
}

}  // namespace

int FirstInfiniteResidual(const Graph& graph) {
  const auto& edges = graph.Edges();
  const auto it = std::find_if(edges.begin(), edges.end(), [](const auto& edge) {
    edge->ComputeResidual();
    return !edge->Residual().allFinite();
  });
  return it == edges.end() ? -1 : static_cast<int>(it - edges.begin());
}

Summary SolveGraph(Graph* graph, const FileSolveOptions& options, const IterationCallback& listener,
                   SolveOptions solve) {
  if (const int k = FirstInfiniteResidual(*graph); k >= 0) {
    throw std::invalid_argument("residual " + std::to_string(k) + " (" + graph->Edges()[k]->TypeInfo() +
                                ") is not finite at the start");
  }
  SparseOptimizer optimizer(graph, options.threads);
  optimizer.SetDamping(Damping::kDiagonal);
  optimizer.SetReducedSolver(options.solver);
  solve.max_iterations = options.iterations;
  solve.landmark_steps = options.landmark_steps;
  solve.callback = [&](const IterationInfo& info) {
    if (listener) listener(info);
    return true;
  };
  return optimizer.Solve(solve);
}

CsvTable SummaryTable(const std::string& name, const Summary& summary, const FileSolveOptions& options) {
  CsvTable table("key,value");
  table.Row("problem", CsvWord(name));
  table.Row("initial_cost", summary.initial_cost);
  table.Row("final_cost", summary.final_cost);
  table.Row("iterations", summary.iterations);
  table.Row("cost_evaluations", summary.cost_evaluations);
  table.Row("seconds", summary.seconds);
  table.Row("termination", ToString(summary.termination));
  table.Row("threads", options.threads);
  return table;
}

CsvTable TraceTable(const Summary& summary) {
  CsvTable table("iteration,cost,change,gradient_max,step_norm,gain_ratio,lambda,trials,seconds");
  double previous = summary.initial_cost;
  for (const IterationInfo& info : summary.trace) {
    table.Row(info.iteration, info.cost, info.cost - previous, info.gradient_max, info.step_norm, info.gain_ratio,
              info.lambda, info.trials, info.seconds);
    previous = info.cost;
  }
  return table;
}

}  // namespace ch5
