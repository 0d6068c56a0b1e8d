#pragma once
/// What the second lecture shows of solvers, as tables: each study writes its own into the folder `csv`. All are made of
/// seeded scenes, so that the same build writes the same bytes.

#include <filesystem>

namespace ch5 {

/// Conjugate gradients on the reduced system of a bundle adjustment, with three preconditioners, and what is left if the
/// first step is never added. Writes solver_pcg.csv, solver_spectrum.csv.
void RunPcgStudy(const std::filesystem::path& csv);

/// Rules for λ on three problems; damping that leaves out the landmarks; what a stop rule sees of W.
/// Writes solver_rules.csv, solver_half_damped.csv, solver_stop.csv.
void RunDampingStudy(const std::filesystem::path& csv);

/// The ways of Gauss-Newton, Levenberg-Marquardt and Dogleg through Rosenbrock's valley, and Dogleg's kinds of step on a
/// bundle adjustment for several first radii. Writes solver_paths.csv, solver_dogleg.csv.
void RunStepStudy(const std::filesystem::path& csv);

/// Losses as functions of the residual, bundle adjustments with outliers, and the two corrections of the Hessian.
/// Writes solver_losses.csv, solver_outliers.csv, solver_corrections.csv.
void RunLossStudy(const std::filesystem::path& csv);

}  // namespace ch5
