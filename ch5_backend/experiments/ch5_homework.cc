/// The homework's functions at work: ch5_homework EXPERIMENT --out DIR [--data PATH]

#include <stdexcept>
#include <string>

#include "ch5_backend/experiments/studies/command_line.h"
#include "ch5_backend/experiments/studies/homework/homework_study.h"
#include "ch5_backend/files/tables/text_writer.h"

namespace {

constexpr char kUsage[] =
    "usage: ch5_homework EXPERIMENT --out DIR [--data PATH]\n"
    "Runs one of hessian, marginal, weights, gauge, okvis, vins, blocks and beacons, and writes its tables into DIR.\n"
    "okvis and vins fly a recording's folder, blocks adjusts a BAL file; both are simulated where no PATH is given.\n"
    "./course run --mine runs it with the solutions and with a student's files, and compares.\n";

const ch5::HomeworkExperiment& Find(const std::string& name) {
  for (const ch5::HomeworkExperiment& experiment : ch5::HomeworkExperiments()) {
    if (experiment.name == name) return experiment;
  }
  throw std::invalid_argument("there is no experiment '" + name + "'; see --help");
}

}  // namespace

int main(int argc, char** argv) {
  std::string name, out, data;
  ch5::CommandLine line("ch5_homework", kUsage);
  line.Argument("EXPERIMENT", &name);
  line.Text("--out", &out);
  line.Option("--data", [&](const std::string& word) { data = word; });
  return line.Run(argc, argv, [&] {
    const ch5::Progress progress;
    const ch5::OutputFolder made(out);
    Find(name).run(out, data, [&](double fraction) { progress.Show(name, fraction); });
  });
}
