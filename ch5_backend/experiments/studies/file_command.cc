#include "ch5_backend/experiments/studies/file_command.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <iomanip>
#include <sstream>
#include <stdexcept>
#include <thread>

#include "ch5_backend/math/median.h"
#include "ch5_backend/sparse/sparse_optimizer.h"

namespace ch5 {
namespace {

// A number that is missing, such as the step that led to the start, is "-".
std::string Cell(int width, const char* format, double x) {
  char number[32] = "-", cell[32];
  if (!std::isnan(x)) std::snprintf(number, sizeof number, format, x);
  std::snprintf(cell, sizeof cell, "%*s", width, number);
  return cell;
}

void PrintIteration(const IterationInfo& info, double change) {
  if (info.iteration == 0)
    std::printf("iter           cost      change    gradient        step     gain    lambda  trials  seconds\n");
  std::printf("%4d  %13.6e  %10.2e  %10.2e  %s  %s  %s  %6d  %7.3f\n", info.iteration, info.cost, change,
              info.gradient_max, Cell(10, "%.2e", info.step_norm).c_str(), Cell(7, "%.3f", info.gain_ratio).c_str(),
              Cell(8, "%.1e", info.lambda).c_str(), info.trials, info.seconds);
  std::fflush(stdout);
}

// `text` with _ for what a cell cannot hold: commas, quotes and line ends.
std::string CsvWord(std::string text) {
  const auto is_special = [](char c) { return c == ',' || c == '"' || c == '\n'; };
  std::replace_if(text.begin(), text.end(), is_special, '_');
  return text;
}

}  // namespace

std::string FileSolveOptions::Name() const { return std::filesystem::path(input).stem().string(); }

int RunFileCommand(const char* program, const char* usage, int argc, char** argv, FileSolveOptions* options,
                   const std::function<void()>& run, const std::function<void(CommandLine*)>& declare) {
  options->threads = static_cast<int>(std::clamp(std::thread::hardware_concurrency(), 1u, 64u));
  options->solve.callback = [previous = 0.0](const IterationInfo& info) mutable {
    PrintIteration(info, info.iteration == 0 ? 0.0 : info.cost - previous);
    previous = info.cost;
    return true;
  };
  CommandLine line(program, usage);
  line.Argument("FILE", &options->input);
  line.Text("--out", &options->out);
  // A program accepts the options in its usage and no others.
  const auto is_named = [&](const char* option) { return std::strstr(usage, option) != nullptr; };
  if (is_named("--iterations")) line.Number("--iterations", 0, 1000000, &options->solve.max_iterations);
  if (is_named("--threads")) line.Number("--threads", 1, 256, &options->threads);
  if (is_named("--landmark-steps")) line.Number("--landmark-steps", 0, 1000, &options->solve.landmark_steps);
  if (is_named("--huber")) line.Number("--huber", 1e-6, 1e6, &options->huber);
  if (is_named("--solver"))
    line.Option("--solver", [&](const auto& word) { options->solver = OneOf(word, kReducedSolverNames); });
  if (declare) declare(&line);
  return line.Run(argc, argv, run);
}

void PrintSummary(const Summary& summary, const std::string& more) {
  std::printf("\ncost %.6e -> %.6e%s, %d iterations, %.3f s; %s\n", summary.initial_cost, summary.final_cost,
              more.c_str(), summary.iterations, summary.seconds, summary.message.c_str());
  const size_t last = summary.trace.size() - 1;
  if (summary.termination != Termination::kMaxIterations || summary.trace.size() < 2) return;
  std::printf(
      "not converged: the last iteration still lowered the cost by %.1e of itself; --iterations N allows more\n",
      (summary.trace[last - 1].cost - summary.trace[last].cost) / summary.trace[last].cost);
}

Summary SolveGraph(Graph* graph, const FileSolveOptions& options) {
  SparseOptimizer optimizer(graph, options.threads);
  optimizer.SetReducedSolver(options.solver);
  Summary summary = optimizer.Solve(options.solve);
  if (summary.termination == Termination::kNotFinite) throw std::invalid_argument(summary.message);
  return summary;
}

std::string HintAtHuber(const Graph& graph, const FileSolveOptions& options, const OutlierLimits& limits) {
  constexpr double kWidest = 3.0;  // pixels or standard deviations, where outliers have widened the median
  if (options.huber > 0.0) return "";
  std::vector<double> residuals;  // √(rᵀWr), of edges that can move
  for (const auto& edge : graph.Edges()) {
    const auto& ends = edge->Vertices();
    if (std::all_of(ends.begin(), ends.end(), [](const auto& vertex) { return vertex->IsFixed(); })) continue;
    edge->ComputeResidual();
    residuals.push_back(std::sqrt(edge->Chi2()));
  }
  if (residuals.empty()) return "";
  const double median = Median(residuals);
  double all = 0.0, of_far = 0.0;
  int far = 0;
  for (const double r : residuals) {
    const bool is_far = r > limits.far * median;
    all += r * r, of_far += is_far ? r * r : 0.0, far += is_far;
  }
  constexpr double kRounding = 1e-9;  // pixels or standard deviations, of which no measurement has so many digits
  if (median < kRounding || !(of_far > limits.cost * all) || far > limits.few * static_cast<double>(residuals.size()))
    return "";
  std::ostringstream hint;
  hint << std::setprecision(2) << far << " of " << residuals.size() << " residuals are more than " << limits.far
       << " times the median, " << median << ", and hold " << std::lround(100.0 * of_far / all)
       << " % of the cost; --huber " << std::min(3.0 * median, kWidest) << " limits how much such outliers pull";
  return hint.str();
}

CsvTable SummaryTable(const Summary& summary, const FileSolveOptions& options) {
  CsvTable table("key,value");
  table.Row("problem", CsvWord(options.Name()));
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
