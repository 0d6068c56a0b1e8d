/// Experiments with what OKVIS, VINS-Mono and g2o do, a trial at a time: ch5_systems STUDY --trial K --out FILE [--data DIR]

#include "ch5_backend/experiments/studies/systems/system_studies.h"

int main(int argc, char** argv) {
  return ch5::RunTrialStudies("ch5_systems",
                              "What OKVIS, VINS-Mono and g2o do, as curves; ./course plots systems runs all trials.\n"
                              "Recordings and pose graphs are read from DIR.\n",
                              ch5::SystemStudies(), argc, argv);
}
