#pragma once
/// Both policies on one recording, as tables for the report, and trajectories for other tools.

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "ch5_backend/apps/studies/odometry.h"
#include "ch5_backend/consistency/gauge_audit.h"

namespace ch5 {

/// The window at one image: H of its graph, and the prior that its slide left behind.
struct WindowPicture {
  double t = 0.0;
  MatXX H;            ///< frame by frame (pose, then speed and biases), landmarks last
  int pose_rows = 0;  ///< rows above the landmarks
  MatXX H_prior;      ///< JᵀJ in the order of the prior's vertices
};

/// What the prior of the window claims to know of position and yaw, which nothing measures.
struct PriorAudit {
  double t = 0.0;
  std::vector<GaugeLeak> leaks;
};

struct OdometryStudy {
  Recording recording;
  std::vector<OdometryRun> runs;                     ///< one a policy
  std::vector<std::vector<WindowPicture>> pictures;  ///< likewise
  std::vector<std::vector<PriorAudit>> audits;       ///< likewise; after every image, outside of the time measured
};

/// A hand-held camera in a room, standing still before it moves, with noise and 2 % of outliers.
Recording SimulatedOdometryRecording();

/// @param progress  which policy is at work, and how far it is, 0 … 1
OdometryStudy RunOdometryStudy(Recording recording,
                               const std::function<void(const std::string&, double)>& progress = nullptr);

/// Into `csv`: odometry_policies.csv, odometry_path.csv, odometry_windows.csv, odometry_matrices.csv,
/// odometry_spectrum.csv and odometry_gauge.csv; all or none.
/// @throws WriteError
void WriteOdometryTables(const OdometryStudy& study, const std::filesystem::path& csv);

/// POLICY.tum and POLICY.csv (EuRoC's format) for each policy.
/// @throws WriteError
void WriteOdometryTrajectories(const OdometryStudy& study, const std::filesystem::path& out);

}  // namespace ch5
