#include <string>

#include "ch5_backend/dense/problem.h"
#include "ch5_backend/experiments/studies/matrices.h"
#include "ch5_backend/experiments/studies/solver/perturbed_scene.h"
#include "ch5_backend/experiments/studies/solver/solver_studies.h"
#include "ch5_backend/linear/conjugate_gradients.h"

namespace ch5 {
namespace {

constexpr int kFrames = 20, kPoints = 200, kMaxIterations = 250;
constexpr double kLambda = 1e-4;  // of diagonal damping, LM's after a few good steps

struct ReducedSystem {
  MatXX S;  // n×n, n = 6·frames
  VecX b;   // n×1
};

// S Δx_p = b_S of the scene at its start.
ReducedSystem MakeReducedSystem() {
  MonoBa ba = BuildPerturbed(kFrames, kPoints, 0.1, 0.02);
  Problem problem(&ba.graph);
  problem.SetDamping(Damping::kDiagonal);
  problem.SetOrdering();
  problem.MakeHessian();
  VecX delta_x;
  problem.SolveLinearSystem(kLambda, &delta_x);
  const Eigen::Index p = problem.SchurComplement().rows();
  // b_S follows from S and the solution's first rows.
  return {problem.SchurComplement(), problem.SchurComplement() * delta_x.head(p)};
}

// M as its Cholesky factor L, M = L Lᵀ: blocks of `block` rows on the diagonal of S; 0 means M = I.
MatXX PreconditionerFactor(const MatXX& S, int block) {
  if (block == 0) return MatXX::Identity(S.rows(), S.cols());
  MatXX L = MatXX::Zero(S.rows(), S.cols());
  for (Eigen::Index k = 0; k < S.rows(); k += block) {
    L.block(k, k, block, block) = S.block(k, k, block, block).llt().matrixL();
  }
  return L;
}

// ‖b − Sx‖/‖b‖ after every iteration, of x and of x without the first step α₀p₀.
void AppendResiduals(const ReducedSystem& system, const MatXX& L, const std::string& name, CsvTable* table) {
  const auto multiply = [&](const VecX& v, VecX* Av) { *Av = system.S * v; };
  const auto precondition = [&](const VecX& r, VecX* z) {
    *z = L.transpose().triangularView<Eigen::Upper>().solve(L.triangularView<Eigen::Lower>().solve(r));
  };
  LinearIterate state;
  state.Resize(system.b.size());
  VecX x = VecX::Zero(system.b.size()), first;
  state.StartAtZero(system.b, precondition);
  const auto relative = [&](const VecX& y) { return (system.b - system.S * y).norm() / system.b.norm(); };
  table->Row(name, 0, 1.0, 1.0);
  const auto report = [&](const LinearIterate& now) {
    if (now.count == 1) first = x;
    table->Row(name, now.count, relative(x), relative(x - first));
    return relative(x) < 1e-10;
  };
  ConjugateGradients(multiply, precondition, report, kMaxIterations, &state, &x);
}

}  // namespace

void RunPcgStudy(const std::filesystem::path& csv) {
  CsvTable residuals("preconditioner,iteration,relative_residual,without_first_step");
  CsvTable spectrum("preconditioner,index,eigenvalue");
  const ReducedSystem system = MakeReducedSystem();
  for (const auto& [name, block] : {std::pair("none", 0), std::pair("diagonal", 1), std::pair("blocks", 6)}) {
    const MatXX L = PreconditionerFactor(system.S, block);
    AppendResiduals(system, L, name, &residuals);
    const MatXX half = L.triangularView<Eigen::Lower>().solve(system.S);
    const MatXX scaled = L.triangularView<Eigen::Lower>().solve(MatXX(half.transpose()));
    const VecX eigenvalues = Eigenvalues(0.5 * (scaled + scaled.transpose()));
    for (int i = 0; i < eigenvalues.size(); ++i) spectrum.Row(name, i, eigenvalues[i]);
  }
  residuals.Write(csv / "solver_pcg.csv");
  spectrum.Write(csv / "solver_spectrum.csv");
}

}  // namespace ch5
