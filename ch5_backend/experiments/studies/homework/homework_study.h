#pragma once
/// The homework at work: what each stage's functions do to the chapter's own problems, as tables. The program is linked
/// twice, with the solutions and with a student's files (ch5_homework/judge/mine.cmake), and `./course run --mine` lays
/// the tables of both side by side.

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

namespace ch5 {

/// One experiment, in a process of its own, so that a crash spoils no other.
struct HomeworkExperiment {
  std::string name;
  /// Writes tables into `csv`; what came before an exception too, where that is of use (a flight that breaks off).
  /// @param data  a recording's folder, or a BAL file; empty: simulated
  void (*run)(const std::filesystem::path& csv, const std::string& data, const std::function<void(double)>& progress);
};

/// hessian   1.1, 1.2  matrices.csv: H, b, S and Δx of the course's scene; convergence.csv
/// marginal  2         matrices.csv: what TestMarginalize leaves of the slides' chain and of a scene
/// weights   3         weights.csv: iterations and drift over the prior's weight
/// gauge     4         deviations.csv: standard deviations in a free and in a fixed gauge, and from one into the other
/// okvis     5         path.csv, summary.csv: a flight whose priors MarginalizationError makes
/// vins      6         the same by MarginalizationInfo, in a window that SlideWindow moves
/// blocks    7         convergence.csv of PlainBlockSolver; times.csv, beside Problem and the sparse solver
/// beacons   8         convergence.csv, path.csv: an IMU's guess, corrected by points and three beacons
const std::vector<HomeworkExperiment>& HomeworkExperiments();

/// The last of them: a body flies a circle, an IMU guesses its path, points and three beacons correct it.
void RunBeacons(const std::filesystem::path& csv);

}  // namespace ch5
