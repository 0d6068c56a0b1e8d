#pragma once
/// Monte-Carlo: are the estimators as certain as they have a right to be?
///
///   NEES = eᵀ P⁻¹ e,   e = [p − p*; Log(R*ᵀR)] of the newest pose against the truth *, P what the estimator claims
///
/// Over N runs of a consistent estimator its mean is distributed as χ²_6N/N.
///
/// Position and yaw mean something only against a frame where they are known, and here that is the first one: each run
/// starts from a state drawn around the truth, its prior says with which σ, and all later errors and covariances are in
/// that W. No anchor is held besides, since the prior knows its place (Window::knows_place). From there on nothing measures
/// yaw, so its information can only fall; where it rises, it has leaked in. A second set of runs starts without place, as
/// in life, and the gauge auditor reads the leak off the prior itself: nᵀHn, zero for who keeps its null space.
///
/// Sources: Bar-Shalom, Li, Kirubarajan, "Estimation with Applications to Tracking and Navigation", §5.4; Huang,
/// Mourikis, Roumeliotis, IJRR 2010; Zhang, Gallego, Scaramuzza, RA-L 2018, for the gauge of a covariance.

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

namespace ch5 {

struct ConsistencyOptions {
  int runs = 50;
  double seconds = 20.0;
  double frame_rate = 5.0;  ///< [Hz]
  double pixel_sigma = 1.0;
  int max_tracks = 24;
  double lose_track = 0.05;  ///< probability at every image
  int audited_runs = 2;      ///< of the runs, are also made without place
  int threads = 0;           ///< 0: as many as the machine has; the result does not depend on it
};

/// One policy with one mode of first estimates at one time, over all runs.
struct ConsistencyRow {
  std::string policy;  ///< "vins", "okvis"; "vins twice" uses observations twice, as VINS-Mono does
  std::string mode;    ///< "none", "prior_only", "full"
  double t = 0.0;
  int runs = 0;                            ///< that still follow the camera
  double nees_pose = 0.0, nees_yaw = 0.0;  ///< means
  double yaw_information = 0.0;            ///< mean of 1/σ² that is claimed [rad⁻²]
  double yaw_rmse = 0.0;                   ///< true error [rad]
  double position_rmse = 0.0;              ///< [m]
  double yaw_leak = 0.0;                   ///< what the prior of a run without place knows of yaw [rad⁻²] …
  double position_leak = 0.0;              ///< … and of position, its three directions together [m⁻²]
};

/// The middle `share` of χ²_(dof·runs)/runs, by Wilson and Hilferty's approximation (1931).
struct Band {
  double low = 0.0, high = 0.0;
};
Band ChiSquaredBand(int dof, int runs, double normal_quantile = 1.959964);

/// Each policy with each mode.
std::vector<ConsistencyRow> RunConsistencyStudy(const ConsistencyOptions& options,
                                                const std::function<void(double)>& progress = nullptr);

/// consistency.csv (one row a policy, mode and time, with the 95 % bands) and consistency_summary.csv.
/// @throws WriteError
void WriteConsistencyTables(const std::vector<ConsistencyRow>& rows, const std::filesystem::path& csv);

}  // namespace ch5
