#pragma once
/// The experiments of the gauge paper and beyond it: ch5_gauge STUDY; figures/gauge.py draws them.
///
/// Source: Zhang, Gallego, Scaramuzza, RA-L 2018, §V–VI.

#include "ch5_backend/experiments/studies/trial_study.h"
#include "ch5_backend/simulate/sensors/visual_inertial_ba.h"

namespace ch5 {

/// Table II and Fig. 7: iterations, time and errors of each way to handle the gauge, in six scenes; errors where the
/// iteration stops by the usual rules, and at convergence. Each trial begins with another way, since what comes first
/// takes longer.
CsvTable GaugeMethodsTable(int trial, const std::filesystem::path&);
/// Figs. 4, 5: the prior's weight from 0 to 1e8.
CsvTable GaugeSweepTable(int trial, const std::filesystem::path&);
/// Fig. 5 again, sine among planes: from the start that the paper states, and from one as many pixels away as its own.
CsvTable GaugeNearStartTable(int trial, const std::filesystem::path&);
/// Table II and Fig. 7 again, with what the paper leaves open changed: views, number of points, noise.
CsvTable GaugeVariantsTable(int trial, const std::filesystem::path&);
/// Fig. 6: reprojection error and prior error after each iteration.
CsvTable GaugeConvergenceTable(int trial, const std::filesystem::path&);
/// All eigenvalues of H, with the IMU and without.
CsvTable GaugeSpectrumTable(int trial, const std::filesystem::path&);
/// How far the free covariance is from the fixed one, before and after its transformation.
CsvTable GaugeCovarianceTable(int trial, const std::filesystem::path&);
/// Fig. 9: standard deviations of each keyframe in each gauge.
CsvTable GaugeDeviationsTable(int trial, const std::filesystem::path&);
/// Figs. 8, 10: the covariance matrices of the keyframes themselves.
CsvTable GaugeMatricesTable(int trial, const std::filesystem::path&);
/// What the curve over the weight owes to damping, stop rules, start and the place of the prior.
CsvTable PriorChoiceTable(int trial, const std::filesystem::path&);
/// Table III: thirty keyframes of real recordings.
CsvTable GaugeRecordingsTable(int trial, const std::filesystem::path& data);

/// Beyond the paper: what VINS-Mono's and OKVIS's windows claim to know of each direction of the gauge, in flight.
CsvTable WindowAuditTable(int trial, const std::filesystem::path&);

/// The paper's scenes: {"sine", "arc", "rec"} × {"planes", "random"}.
struct GaugeConfiguration {
  std::string path, points;
  VisualInertialOptions options;
};
std::vector<GaugeConfiguration> GaugeConfigurations(int trial);

}  // namespace ch5
