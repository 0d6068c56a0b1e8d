#pragma once
/// Both policies on one recording, as tables for the report, and trajectories for other tools.

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "ch5_backend/experiments/studies/odometry.h"
#include "ch5_backend/experiments/studies/odometry_settings.h"
#include "ch5_backend/experiments/studies/window/film.h"
#include "ch5_backend/files/tables/csv.h"

namespace ch5 {

/// What is doubtful in a recording that can be followed all the same.
struct RecordingWarning {
  std::string name;         ///< the report's sentence is warning.NAME in figures/words/
  double value, other;      ///< the numbers in it; NaN if there is none
  std::string words;        ///< the terminal's sentence
  std::string detail = "";  ///< an axis or a line of a file, if it is about one
  double t = kNoNumber;     ///< when, if it is about a time [s]
};
using RecordingWarnings = std::vector<RecordingWarning>;

struct OdometryStudy {
  Recording recording;
  RecordingWarnings warnings;         ///< recording_warnings.h
  std::vector<OdometryRun> runs;      ///< one per policy
  std::optional<double> clock_sigma;  ///< OdometrySettings::clock_sigma
  /// Filled while the policies run, outside of the measured time: the prior's eigenvalues at a few images, and after each image
  /// the information on position and yaw in it, which is spurious; and the slides after some images, if they are wanted.
  CsvTable spectrum{"policy,t_s,index,eigenvalue,scaled"};
  CsvTable gauge{"policy,t_s,direction,information,relative"};
  /// The newest frame's motion against the window's oldest, compared with the truth (motion_nees.h), every tenth window.
  CsvTable consistency{"policy,t_s,error_m,sigma_m,rotation_error_deg,rotation_sigma_deg,nees"};
  std::optional<FilmTables> film;
};

/// A hand-held camera in a room, standing still before it moves, with noise and 2 % of outliers.
Recording SimulatedOdometryRecording(uint64_t seed = 1);

/// @param settings  which policies, and how
/// @param batch     also solves the recording at once, from the first run; it is in none of these tables
/// @param film      of both windows, for which some of their slides are told
OdometryStudy RunOdometryStudy(Recording recording, const StudyProgress& progress = nullptr,
                               const OdometrySettings& settings = {}, bool batch = false, bool film = false);

/// Into `csv`: odometry_policies.csv, odometry_results.csv, odometry_segments.csv, odometry_path.csv, odometry_lengths.csv, odometry_consistency.csv,
/// odometry_windows.csv, odometry_spectrum.csv, odometry_gauge.csv, odometry_warnings.csv, odometry_machine.csv and those of the film; all or none.
/// @throws WriteError
void WriteOdometryTables(const OdometryStudy& study, const std::filesystem::path& csv);

/// POLICY.tum and POLICY.csv (EuRoC's format) for each policy, stamped as the images are, whatever the time offset; what follows a restart is in files of its own, POLICY_1.tum,
/// POLICY_1.csv and so on by its segment. Such files of an earlier run are removed.
/// @throws WriteError
void WriteOdometryTrajectories(const OdometryStudy& study, const std::filesystem::path& out);

}  // namespace ch5
