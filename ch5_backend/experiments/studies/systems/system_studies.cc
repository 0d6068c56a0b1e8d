#include "ch5_backend/experiments/studies/systems/system_studies.h"

namespace ch5 {

const std::vector<TrialStudy>& SystemStudies() {
  static const std::vector<TrialStudy> studies = {
      {"ablation", AblationTable},
      {"ablation_recording", AblationRecordingTable},
      {"consistency_recording", ConsistencyRecordingTable},
      {"walk_scale", WalkScaleTable},
      {"back_ends", BackEndsTable},
      {"calibration", CalibrationTable},
      {"preintegration", PreintegrationTable},
      {"restart", RestartTable},
      {"distance", DistanceTable},
      {"window_size", WindowSizeTable},
      {"okvis_matrices", OkvisMatricesTable},
      {"okvis_vertices", OkvisVerticesTable},
      {"pose_graphs", PoseGraphsTable},
      {"pose_graph_starts", PoseGraphStartsTable},
      {"machine", MachineTable},
  };
  return studies;
}

}  // namespace ch5
