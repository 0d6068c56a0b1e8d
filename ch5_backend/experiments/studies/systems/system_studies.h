#pragma once
/// What OKVIS, VINS-Mono and g2o are tested for, as curves: ch5_systems STUDY.

#include "ch5_backend/experiments/studies/trial_study.h"

namespace ch5 {

/// What leaves the window marginalized, held fixed, dropped, or marginalized with first estimates: error, NEES and time on
/// the same simulated flight …
CsvTable AblationTable(int trial, const std::filesystem::path&);
/// … and on EuRoC's V1_01.
CsvTable AblationRecordingTable(int trial, const std::filesystem::path& data);
/// VINS-Mono's window with observations used once and twice, hosts exact and noisy, weights as simulated and as published:
/// NEES of the newest pose. ./course refute asks which of the three makes it large.
CsvTable CertaintyTable(int trial, const std::filesystem::path&);
/// Observability constraints for no edge, marginalized edges or all, and other noise than the default's: error, NEES of the
/// motion across the window and its parts, the prior's leak of yaw. Trial 0 is EuRoC's V1_01, 1 Tango's walk, others are
/// simulated.
CsvTable ConsistencyRecordingTable(int trial, const std::filesystem::path& data);
/// Observability constraints for no edge, marginalized edges or all, with default weights and windows, on a simulated flight
/// of each of four kinds: ATE and NEES of the motion across the window.
CsvTable FirstEstimatesTable(int trial, const std::filesystem::path&);
/// The same of VINS, with no edge or all, on two of the kinds: what ./course refute asks of.
CsvTable RefutedEstimatesTable(int trial, const std::filesystem::path&);
/// The batch on Tango's walk with its observations, gyroscope and accelerometer as recorded, or each replaced by what the
/// publisher's trajectory would give: ATE and scale. Trials differ in the observations' noise.
CsvTable WalkScaleTable(int trial, const std::filesystem::path& data);
/// The Schur complement with pivoted Cholesky and with eigenvalues, and QR: error of the prior the less the old prior knew,
/// and time over the size of the window. The measure is QR in extended precision.
CsvTable BackEndsTable(int trial, const std::filesystem::path&);
/// The error of the clock's offset and of the camera's rotation, image by image.
CsvTable CalibrationTable(int trial, const std::filesystem::path&);
/// σ of a preintegration over its length and over the IMU's rate, claimed and measured on simulated measurements.
CsvTable PreintegrationTable(int trial, const std::filesystem::path&);
/// Relative error over the distance, of both policies on all recordings.
CsvTable DistanceTable(int trial, const std::filesystem::path& data);
/// OKVIS's numbers of keyframes and of newest frames; trial 0 is EuRoC's V1_01, others are simulated.
CsvTable WindowSizeTable(int trial, const std::filesystem::path& data);
/// A pose graph a trial, by one algorithm and linear solver: cost and time after each iteration, and memory.
CsvTable PoseGraphsTable(int trial, const std::filesystem::path& data);
/// A pose graph a trial, the last one simulated with large noise: where each start leads to.
CsvTable PoseGraphStartsTable(int trial, const std::filesystem::path& data);
/// A pose graph with 10 and 100 false loops, drawn anew in each trial of that graph: how many graduated non-convexity gives up,
/// how many good ones with them, and how far it and plain least squares end from the optimum without.
CsvTable FalseLoopsTable(int trial, const std::filesystem::path& data);
/// What times were measured on: the processor's name, its cores, and the load of the last minute.
CsvTable MachineTable(int trial, const std::filesystem::path&);

}  // namespace ch5
