/// The gauge paper's experiments, a trial at a time: ch5_gauge STUDY --trial K --out FILE [--data DIR]

#include "ch5_backend/experiments/studies/gauge/gauge_studies.h"

int main(int argc, char** argv) {
  using namespace ch5;
  return RunTrialStudies("ch5_gauge",
                         "The experiments of Zhang, Gallego and Scaramuzza (2018), and beyond; ./course plots gauge\n"
                         "runs all trials and draws them. recordings reads DIR/euroc_v1_01_easy and DIR/tango_walk.\n",
                         {{"methods", GaugeMethodsTable},
                          {"sweep", GaugeSweepTable},
                          {"convergence", GaugeConvergenceTable},
                          {"spectrum", GaugeSpectrumTable},
                          {"covariance", GaugeCovarianceTable},
                          {"deviations", GaugeDeviationsTable},
                          {"matrices", GaugeMatricesTable},
                          {"prior_choice", PriorChoiceTable},
                          {"recordings", GaugeRecordingsTable},
                          {"audit", WindowAuditTable},
                          {"near_start", GaugeNearStartTable},
                          {"variants", GaugeVariantsTable}},
                         argc, argv);
}
