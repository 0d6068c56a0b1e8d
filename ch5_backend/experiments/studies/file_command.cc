#include "ch5_backend/experiments/studies/file_command.h"

#include <algorithm>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <thread>

namespace ch5 {

std::string FileCommand::Name() const { return std::filesystem::path(file).stem().string(); }

int RunFileCommand(const char* program, const char* usage, int argc, char** argv,
                   const std::function<void(const FileCommand&)>& run,
                   const std::function<void(CommandLine*, FileSolveOptions*)>& declare) {
  FileCommand command;
  FileSolveOptions& options = command.options;
  options.threads = static_cast<int>(std::clamp(std::thread::hardware_concurrency(), 1u, 64u));
  CommandLine line(program, usage);
  line.Argument("FILE", &command.file);
  line.Text("--out", &command.out);
  // A program accepts the options in its usage and no others.
  const auto is_named = [&](const char* option) { return std::strstr(usage, option) != nullptr; };
  if (is_named("--iterations")) line.Number("--iterations", 0, 1000000, &options.iterations);
  if (is_named("--threads")) line.Number("--threads", 1, 256, &options.threads);
  if (is_named("--landmark-steps")) line.Number("--landmark-steps", 0, 1000, &options.landmark_steps);
  if (is_named("--huber")) line.Number("--huber", 1e-6, 1e6, &options.huber);
  if (is_named("--solver"))
    line.Option("--solver", [&](const auto& word) { options.solver = OneOf(word, kReducedSolverNames); });
  if (declare) declare(&line, &options);
  return line.Run(argc, argv, [&] {
    options.input = command.file;
    run(command);
  });
}

IterationTable::IterationTable() {
  std::printf("iter           cost      change    gradient        step     gain    lambda  trials  seconds\n");
}

void IterationTable::Print(const IterationInfo& info) {
  const double change = info.iteration == 0 ? 0.0 : info.cost - previous_cost_;
  previous_cost_ = info.cost;
  std::printf("%4d  %13.6e  %10.2e  %10.2e  %10.2e  %7.3f  %8.1e  %6d  %7.3f\n", info.iteration, info.cost, change,
              info.gradient_max, info.step_norm, info.gain_ratio, info.lambda, info.trials, info.seconds);
  std::fflush(stdout);
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

}  // namespace ch5
