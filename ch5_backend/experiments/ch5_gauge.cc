/// The gauge paper's experiments, a trial at a time: ch5_gauge STUDY --trial K --out FILE [--data DIR]

#include "ch5_backend/experiments/studies/gauge/gauge_studies.h"

int main(int argc, char** argv) {
  return ch5::RunTrialStudies(
      "ch5_gauge",
      "The experiments of Zhang, Gallego and Scaramuzza (2018), and beyond; ./course plots gauge\n"
      "runs all trials and draws them. recordings reads DIR/euroc_v1_01_easy and DIR/tango_walk.\n",
      ch5::GaugeStudies(), argc, argv);
}
