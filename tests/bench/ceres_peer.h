#pragma once
/// The peer in our races: the same problems solved by Ceres, with analytic Jacobians, from the same start.

#include <optional>
#include <string>
#include <vector>

#include "ch5_backend/files/bal.h"
#include "ch5_backend/files/window_dump.h"

namespace ch5::peer {

enum class LinearSolver { kDenseSchur, kSparseSchur, kIterativeSchur, kSparseNormal };

/// What both sides are told. What has no value is each side's own choice: Ceres' defaults, and what our library does unasked.
struct PeerOptions {
  int iterations = 20;
  int threads = 1;
  bool wall = false;        ///< times are the clock's, not the processor's
  bool dogleg = false;      ///< instead of Levenberg-Marquardt
  double tolerance = 1e-6;  ///< of the cost's relative change, Ceres' default
  std::optional<double>
      radius;  ///< the first one: of Dogleg's region, 1/λ₀ of Levenberg-Marquardt's; Ceres' default is 1e4
  std::optional<BalPoints> points;
  std::optional<bool> inner;  ///< landmarks once more, alone: Ceres' inner iterations, SolveOptions::landmark_steps
  /// Of Ceres alone.
  LinearSolver linear_solver = LinearSolver::kDenseSchur;
  bool scaled = true;  ///< the Jacobian's columns
  bool eigen = false;  ///< Eigen's sparse Cholesky instead of SuiteSparse's
  bool mixed = false;  ///< factors in float, refined three times
};

struct PeerPoint {
  double seconds, cost;  ///< of bench::Stopwatch since the solver was called, the preprocessor included; ½ Σρ
};

struct PeerResult {
  double initial_cost = 0.0, final_cost = 0.0, seconds = 0.0;
  int trials = 0;  ///< steps whose cost was worked out: rejected ones count, and the one that ends the solve
  std::vector<PeerPoint> trace;  ///< the least cost so far
  double bytes_before = 0.0;     ///< of memory, with the problem in it, before the solver was called
};

/// A BAL problem; Ceres' damping is λ diag(H), as our Damping::kDiagonal.
PeerResult SolveBalWithCeres(const BalProblem& problem, const PeerOptions& options);

/// A window as VINS-Mono solves it; the preintegration and what it needs is made before the clock starts, as for us.
PeerResult SolveWindowWithCeres(const WindowDump& dump, const PeerOptions& options);

/// A pose graph, by SPARSE_NORMAL_CHOLESKY whatever the options say.
/// @throws FileError as ReadG2o
PeerResult SolvePoseGraphWithCeres(const std::string& path, const PeerOptions& options);

/// Σ of every free pose at the start, by ceres::Covariance; the costs are the sum of the traces.
/// @throws std::runtime_error if Ceres finds H singular
PeerResult WindowCovariancesWithCeres(const WindowDump& dump, const PeerOptions& options);
PeerResult PoseGraphCovariancesWithCeres(const std::string& path, const PeerOptions& options);

}  // namespace ch5::peer
