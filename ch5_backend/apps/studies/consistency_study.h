#pragma once
/// Monte-Carlo: is an estimator as certain as it has a right to be?
///
///   NEES = eᵀ P⁻¹ e of the newest pose; over N runs of a consistent estimator its mean is χ²_6N/N.
///
/// Nothing measures yaw, so the information on it can only fall from what the start was given; where it rises, it has
/// leaked in. Source: Bar-Shalom, Li, Kirubarajan, "Estimation with Applications to Tracking and Navigation", §5.4.

#include <filesystem>
#include <functional>
#include <string>

#include "ch5_backend/apps/studies/consistency_window.h"

namespace ch5 {

struct ConsistencyOptions {
  int runs = 50;
  double seconds = 20.0;
  double frame_rate = 5.0;  ///< [Hz]
  size_t window = 6;        ///< frames
  double pixel_sigma = 2.0;
  int max_tracks = 20;
  int threads = 0;  ///< 0: as many as the machine has; the result does not depend on it
};

/// One policy at one time, over all runs.
struct ConsistencyRow {
  std::string policy;
  double t = 0.0;
  double nees_pose = 0.0, nees_yaw = 0.0;  ///< means
  double yaw_information = 0.0;            ///< mean of 1/σ² that is claimed [rad⁻²]
  double yaw_rmse = 0.0;                   ///< true error [rad]
  double position_rmse = 0.0;              ///< [m]
};

/// The middle `share` of χ²_(dof·runs)/runs, by Wilson and Hilferty's approximation (1931).
struct Band {
  double low = 0.0, high = 0.0;
};
Band ChiSquaredBand(int dof, int runs, double normal_quantile = 1.959964);

/// Policies "vins" (observations used twice, no first estimates), "none", "prior_only" and "full".
std::vector<ConsistencyRow> RunConsistencyStudy(const ConsistencyOptions& options,
                                                const std::function<void(double)>& progress = nullptr);

/// consistency.csv (one row a policy and time, with the 95 % bands) and consistency_summary.csv.
/// @throws WriteError
void WriteConsistencyTables(const std::vector<ConsistencyRow>& rows, const ConsistencyOptions& options,
                            const std::filesystem::path& csv);

}  // namespace ch5
