// Another project uses the installed package: the course's scene, solved with its gauge fixed.
#include <cstdio>

#include "ch5_backend/dense/problem.h"
#include "ch5_backend/simulate/mono_ba.h"

int main() {
  ch5::MonoBa ba;
  ch5::BuildMonoBa(ch5::SimulateMonoBa({}), ch5::Gauge::kFixTwoFrames, 1.0, 0.0, &ba);
  const ch5::Summary summary = ch5::Problem(&ba.graph).Solve();
  std::printf("%.6e -> %.6e, %s\n", summary.initial_cost, summary.final_cost, summary.message.c_str());
  return ch5::IsConverged(summary.termination) && summary.final_cost < 1e-3 * summary.initial_cost ? 0 : 1;
}
