#include "ch5_backend/apps/studies/solve_tables.h"

#include <algorithm>

namespace ch5 {

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

std::string CsvWord(std::string text) {
  const auto is_special = [](char c) { return c == ',' || c == '"' || c == '\n'; };
  std::replace_if(text.begin(), text.end(), is_special, '_');
  return text;
}

}  // namespace ch5
