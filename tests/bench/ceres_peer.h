#pragma once
/// The peer in our races: the same problems solved by Ceres, with analytic Jacobians, from the same start.

#include <string>
#include <vector>

#include "ch5_backend/files/bal.h"
#include "ch5_backend/files/window_dump.h"

namespace ch5::peer {

enum class LinearSolver { kDenseSchur, kSparseSchur, kIterativeSchur, kSparseNormal };

struct PeerOptions {
  LinearSolver linear_solver = LinearSolver::kDenseSchur;
  int iterations = 20;
  int threads = 1;
  bool dogleg = false;      ///< instead of Levenberg-Marquardt
  double tolerance = 1e-6;  ///< of the cost's relative change, Ceres' default
};

struct PeerPoint {
  double seconds, cost;  ///< since the start, the preprocessor included; ½ Σρ
};

struct PeerResult {
  double initial_cost = 0.0, final_cost = 0.0, seconds = 0.0;
  int iterations = 0;  ///< linear systems solved, those of rejected steps included
  std::vector<PeerPoint> trace;
  double bytes_before = 0.0;  ///< of memory, with the problem in it, before the solver was called
};

/// A BAL problem; Ceres' damping is λ diag(H), as our Damping::kDiagonal, from λ = 1e-4 on.
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
