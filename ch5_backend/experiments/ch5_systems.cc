/// Experiments with what OKVIS, VINS-Mono and g2o do, a trial at a time: ch5_systems STUDY --trial K --out FILE [--data DIR]

#include <stdexcept>
#include <string>

#include "ch5_backend/experiments/studies/command_line.h"
#include "ch5_backend/experiments/studies/systems/system_studies.h"

namespace {

constexpr char kUsage[] =
    "usage: ch5_systems STUDY --out FILE [--trial K] [--data DIR]\n"
    "Runs trial K (0 unless given) of STUDY, one of ablation, ablation_recording, back_ends, calibration,\n"
    "preintegration, distance, window_size, okvis_matrices, okvis_vertices and pose_graphs, and writes its rows to "
    "FILE,\n"
    "a CSV. Recordings and pose graphs are read from DIR. ./course plots systems runs all trials.\n";

const ch5::SystemStudy& Find(const std::string& name) {
  for (const ch5::SystemStudy& study : ch5::SystemStudies()) {
    if (study.name == name) return study;
  }
  throw std::invalid_argument("there is no study '" + name + "'; see --help");
}

}  // namespace

int main(int argc, char** argv) {
  std::string name, out, data = ".";
  int trial = 0;
  ch5::CommandLine line("ch5_systems", kUsage);
  line.Argument("STUDY", &name);
  line.Text("--out", &out);
  line.Text("--data", &data);
  line.Number("--trial", 0, 1000000, &trial);
  return line.Run(argc, argv, [&] { Find(name).run(trial, data).Write(out); });
}
