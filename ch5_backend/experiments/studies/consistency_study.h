#pragma once
/// Monte-Carlo experiment: do the estimators' covariances match their true errors?
///
/// The newest pose's NEES (evaluate/nees.h), averaged over runs that differ in their noise.
///
/// A window may be too certain in two ways besides its linearization: it counts an observation again that its prior
/// contains already, and it takes the host's bearing, which all residuals of a landmark share, for exact. Both are
/// varied, apart from each other.
///
/// Errors in position and yaw need a frame in which both are known, here that of the first state: each run starts from a
/// state drawn around the truth, its prior has the σ of that draw, and all later errors and covariances are in that W. No
/// gauge prior is needed in addition (Window::prior_fixes_gauge). Nothing measures yaw afterwards, so its information can
/// only decrease; where it increases, it is spurious. A second set of runs starts without position and yaw, as usual, and
/// the gauge auditor (consistency/gauge_audit.h) reads the spurious information off the prior itself: nᵀHn.
///
/// Sources: Huang, Mourikis, Roumeliotis, IJRR 2010; Zhang, Gallego, Scaramuzza, "On the comparison of gauge freedom
/// handling in optimization-based visual-inertial state estimation", RA-L 2018, for the gauge of a covariance.

#include <filesystem>
#include <functional>
#include <vector>

#include "ch5_backend/evaluate/nees.h"
#include "ch5_backend/experiments/studies/consistency_flight.h"

namespace ch5 {

/// One case at one time, over all runs.
struct ConsistencyRow {
  double t = 0.0;
  int runs = 0;                            ///< that have not failed
  double nees_pose = 0.0, nees_yaw = 0.0;  ///< means …
  ConfidenceBand pose_band, yaw_band;      ///< … and where 95 % of honest ones are
  double yaw_information = 0.0;            ///< mean of the claimed 1/σ² [rad⁻²]
  double yaw_rmse = 0.0;                   ///< of the true error [rad]
  double position_rmse = 0.0;              ///< of the true error [m]
  double yaw_leak = 0.0;       ///< spurious information on yaw in the prior of a run started without it [rad⁻²] …
  double position_leak = 0.0;  ///< … and on position, sum of the three directions [m⁻²]
};

struct ConsistencyResult : ConsistencyCase {
  std::vector<ConsistencyRow> rows;  ///< by time
  /// Means over the images of each run. Runs are independent of each other; the images of a run are not.
  std::vector<double> nees_pose_of_run, nees_yaw_of_run;
};

/// Each policy with each mode, and VINS-Mono's with observations used twice, all with hosts exact and noisy.
std::vector<ConsistencyResult> RunConsistencyStudy(const ConsistencyOptions& options,
                                                   const std::function<void(double)>& progress = nullptr);

/// Writes consistency.csv (a row per case and time, with the 95 % bands) and consistency_summary.csv, where the
/// standard errors of the mean NEES are over runs.
/// @throws WriteError
void WriteConsistencyTables(const std::vector<ConsistencyResult>& results, const std::filesystem::path& csv);

}  // namespace ch5
