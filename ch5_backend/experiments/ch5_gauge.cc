/// The gauge paper's experiments, a trial at a time: ch5_gauge STUDY --trial K --out FILE [--data DIR]

#include <algorithm>
#include <filesystem>
#include <stdexcept>
#include <string>

#include "ch5_backend/experiments/studies/command_line.h"
#include "ch5_backend/experiments/studies/gauge/gauge_studies.h"

namespace {

constexpr char kUsage[] =
    "usage: ch5_gauge STUDY --out FILE [--trial K] [--data DIR]\n"
    "Runs trial K (0 unless given) of STUDY, one of methods, sweep, near_start, variants, convergence, spectrum,\n"
    "covariance, deviations, matrices, prior_choice, audit and recordings, and writes its rows to FILE, a CSV.\n"
    "recordings reads DIR/euroc_v1_01_easy and DIR/tango_walk. ./course plots gauge runs all trials and draws them.\n";

const ch5::GaugeStudy& Find(const std::string& name) {
  for (const ch5::GaugeStudy& study : ch5::GaugeStudies()) {
    if (study.name == name) return study;
  }
  throw std::invalid_argument("there is no study '" + name + "'; see --help");
}

}  // namespace

int main(int argc, char** argv) {
  std::string name, out, data = ".";
  int trial = 0;
  ch5::CommandLine line("ch5_gauge", kUsage);
  line.Argument("STUDY", &name);
  line.Text("--out", &out);
  line.Text("--data", &data);
  line.Number("--trial", 0, 1000000, &trial);
  return line.Run(argc, argv, [&] { Find(name).run(trial, data).Write(out); });
}
