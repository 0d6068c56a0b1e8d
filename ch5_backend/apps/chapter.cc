/// The chapter's experiments on simulated scenes, as tables: ch5_chapter [--out DIR] writes DIR/csv/*.csv.

#include <cstdio>
#include <exception>
#include <filesystem>
#include <string>

#include "ch5_backend/apps/studies/consistency_study.h"
#include "ch5_backend/apps/studies/marginalize_study.h"
#include "ch5_backend/apps/studies/mono_ba_study.h"
#include "ch5_backend/apps/studies/odometry_study.h"
#include "ch5_backend/apps/studies/prior_study.h"
#include "ch5_backend/apps/studies/progress.h"

namespace {

constexpr char kUsage[] =
    "usage: ch5_chapter [--out DIR]\n"
    "Runs bundle adjustment on simulated scenes, the marginalisation example, the prior-weight experiment,\n"
    "odometry on a simulated recording and its consistency, and writes their tables to DIR/csv (DIR is out/ unless "
    "given).\n";

void RunStudies(const std::filesystem::path& csv, const ch5::Progress& progress) {
  using Show = std::function<void(double)>;
  const auto show = [&](const char* study) -> Show {
    return [&progress, study](double fraction) { progress.Show(study, fraction); };
  };
  ch5::RunMonoBaStudy(csv, show("bundle adjustment"));
  ch5::RunMarginalizeStudy(csv, show("marginalisation"));
  ch5::RunPriorStudy(csv, show("prior weights"));
  const auto show_policy = [&](const std::string& policy, double fraction) { progress.Show(policy, fraction); };
  ch5::WriteOdometryTables(ch5::RunOdometryStudy(ch5::SimulatedOdometryRecording(), show_policy), csv);
  ch5::ConsistencyOptions consistency;  // the short form; ch5_nees runs it in full
  consistency.runs = 4;
  consistency.seconds = 6.0;
  ch5::WriteConsistencyTables(ch5::RunConsistencyStudy(consistency, show("consistency")), csv);
}

int Fail(const std::string& what) {
  std::fprintf(stderr, "ch5_chapter: %s\n", what.c_str());
  return 2;
}

}  // namespace

int main(int argc, char** argv) {
  std::filesystem::path out = "out";
  for (int i = 1; i < argc; ++i) {
    const std::string argument = argv[i];
    if (argument == "--help" || argument == "-h") return std::fputs(kUsage, stdout) < 0 ? 2 : 0;
    if (argument != "--out") return Fail("unknown argument '" + argument + "'; see --help");
    if (++i == argc) return Fail("--out needs a directory");
    out = argv[i];
  }
  const ch5::Progress progress;
  try {
    RunStudies(out / "csv", progress);
  } catch (const std::exception& error) {  // a disk that is full, homework that is missing or finds no finite answer
    progress.Clear();
    return Fail(error.what());
  }
  return 0;
}
