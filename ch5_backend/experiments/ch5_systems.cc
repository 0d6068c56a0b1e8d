/// Experiments with what OKVIS, VINS-Mono and g2o do, a trial at a time: ch5_systems STUDY --trial K --out FILE [--data DIR]

#include "ch5_backend/experiments/studies/systems/system_studies.h"

int main(int argc, char** argv) {
  using namespace ch5;
  return RunTrialStudies("ch5_systems",
                         "What OKVIS, VINS-Mono and g2o do, as curves; ./course plots systems runs all trials.\n"
                         "Recordings and pose graphs are read from DIR.\n",
                         {{"ablation", AblationTable},
                          {"ablation_recording", AblationRecordingTable},
                          {"certainty", CertaintyTable},
                          {"consistency_recording", ConsistencyRecordingTable},
                          {"first_estimates", FirstEstimatesTable},
                          {"refuted_estimates", RefutedEstimatesTable},
                          {"walk_scale", WalkScaleTable},
                          {"back_ends", BackEndsTable},
                          {"calibration", CalibrationTable},
                          {"preintegration", PreintegrationTable},
                          {"distance", DistanceTable},
                          {"window_size", WindowSizeTable},
                          {"pose_graphs", PoseGraphsTable},
                          {"pose_graph_starts", PoseGraphStartsTable},
                          {"false_loops", FalseLoopsTable},
                          {"machine", MachineTable}},
                         argc, argv);
}
