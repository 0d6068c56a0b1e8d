#include "ch5_backend/experiments/studies/trial_study.h"

#include <algorithm>
#include <stdexcept>

#include "ch5_backend/experiments/studies/command_line.h"

namespace ch5 {

int RunTrialStudies(const std::string& program, const std::string& about, const std::vector<TrialStudy>& studies,
                    int argc, char** argv) {
  std::string usage = "usage: " + program + " STUDY --out FILE [--trial K] [--data DIR]\n" + about +
                      "Writes the rows of trial K (0 unless given) to FILE, a CSV. STUDY is one of\n";
  for (const TrialStudy& study : studies) usage += "  " + study.name + "\n";
  std::string name, out, data = ".";
  int trial = 0;
  CommandLine line(program, usage);
  line.Argument("STUDY", &name);
  line.Text("--out", &out);
  line.Text("--data", &data);
  line.Number("--trial", 0, 1000000, &trial);
  return line.Run(argc, argv, [&] {
    const auto study =
        std::find_if(studies.begin(), studies.end(), [&](const TrialStudy& one) { return one.name == name; });
    if (study == studies.end()) throw std::invalid_argument("there is no study '" + name + "'; see --help");
    study->run(trial, data).Write(out);
  });
}

}  // namespace ch5
