/// The numbers that the handouts work out by hand, from the course's own solvers: one line "name number…" for each row.

#include <cmath>
#include <iomanip>
#include <iostream>
#include <string>
#include <vector>

#include "ch5_backend/consistency/gauge_freedom.h"
#include "ch5_backend/dense/blocks/plain_block_solver.h"
#include "ch5_backend/dense/problem.h"
#include "ch5_backend/graph/sized_edge.h"
#include "ch5_backend/marginalize/marginalization_error.h"
#include "ch5_backend/marginalize/square_root.h"
#include "ch5_backend/math/psd.h"
#include "ch5_backend/simulate/mono_ba.h"
#include "ch5_backend/types/edge_se3_prior.h"
#include "ch5_backend/types/vertices.h"

namespace ch5 {
namespace {

void Print(const std::string& name, const MatXX& M) {
  for (int row = 0; row < M.rows(); ++row) {
    std::cout << name;
    for (int column = 0; column < M.cols(); ++column) std::cout << ' ' << M(row, column);
    std::cout << '\n';
  }
}

void Print(const std::string& name, double x) { Print(name, MatXX::Constant(1, 1, x)); }

using Scalar = std::shared_ptr<VertexScalar>;

Scalar Add(Graph* graph, Role role) {
  auto vertex = std::make_shared<VertexScalar>(VertexScalar::Estimate(0.0));
  vertex->SetRole(role);
  graph->AddVertex(vertex);
  return vertex;
}

// r = b − a − measured
class Difference : public SizedEdge<1, VertexScalar, VertexScalar> {
 public:
  Difference(Scalar b, Scalar a, double measured, double weight)
      : SizedEdge(std::move(b), std::move(a)), measured_(measured) {
    SetInformation(MatXX::Constant(1, 1, weight));
  }
  void ComputeResidual() override {
    r_[0] = GetVertex<0>().GetEstimate()[0] - GetVertex<1>().GetEstimate()[0] - measured_;
  }
  void ComputeJacobians() override {
    J<0>()(0) = 1.0;
    J<1>()(0) = -1.0;
  }
  std::string TypeInfo() const override { return "Difference"; }

 private:
  double measured_;
};

// r = x − wanted
class Wish : public SizedEdge<1, VertexScalar> {
 public:
  Wish(Scalar x, double wanted, double weight) : SizedEdge(std::move(x)), wanted_(wanted) {
    SetInformation(MatXX::Constant(1, 1, weight));
  }
  void ComputeResidual() override { r_[0] = GetVertex<0>().GetEstimate()[0] - wanted_; }
  void ComputeJacobians() override { J<0>()(0) = 1.0; }
  std::string TypeInfo() const override { return "Wish"; }

 private:
  double wanted_;
};

MatXX Solution(const MarginalizeResult& result) { return result.H_prior.ldlt().solve(result.b_prior).transpose(); }

// "One example on paper": two poses and two landmarks on a line.
void TwoPosesTwoLandmarks() {
  Graph graph;
  const Scalar x0 = Add(&graph, Role::kPose), x1 = Add(&graph, Role::kPose);
  const Scalar l0 = Add(&graph, Role::kLandmark), l1 = Add(&graph, Role::kLandmark);
  graph.AddEdge(std::make_shared<Wish>(x0, 1.0, 1.0));
  graph.AddEdge(std::make_shared<Difference>(l0, x0, 2.4, 2.0));
  graph.AddEdge(std::make_shared<Difference>(l0, x1, 2.6, 2.0));
  graph.AddEdge(std::make_shared<Difference>(l1, x0, 4.4, 3.0));
  graph.AddEdge(std::make_shared<Difference>(l1, x1, 2.8, 6.0));

  Problem problem(&graph);
  problem.SetOrdering();
  Print("paper.before", problem.Cost());
  problem.MakeHessian();
  Print("paper.H", problem.Hessian());
  Print("paper.b", problem.RightHandSide());
  VecX delta_x;
  problem.SolveLinearSystem(0.0, &delta_x);
  Print("paper.S", problem.SchurComplement());
  Print("paper.delta_x", delta_x.transpose());

  MarginalizeResult poses = Problem::TestMarginalize(problem.Hessian(), problem.RightHandSide(), 2, 2);
  Print("paper.b_schur", poses.b_prior);
  const MarginalizeResult without_x0 = Problem::TestMarginalize(problem.Hessian(), problem.RightHandSide(), 0, 1);
  Print("paper.H_without_x0", without_x0.H_prior);
  Print("paper.b_without_x0", without_x0.b_prior);
  Print("paper.delta_x_without_x0", Solution(without_x0));
  poses = Problem::TestMarginalize(poses.H_prior, poses.b_prior, 0, 1);
  Print("paper.H_x1", poses.H_prior);
  Print("paper.b_x1", poses.b_prior);
  const SquareRootForm root = FactorNormalEquations(poses.H_prior, poses.b_prior, EigenvalueCutoff::Vins());
  const double sign = root.J(0, 0) > 0.0 ? 1.0 : -1.0;
  Print("paper.J", sign * root.J);
  Print("paper.r0", sign * root.r0);

  problem.UpdateStates(delta_x);
  Print("paper.after", problem.Cost());
}

// Stage 2: three scalars in a chain; the middle one goes.
void Chain(const std::string& name, bool prior) {
  Graph graph;
  const std::vector<Scalar> x = {Add(&graph, Role::kPose), Add(&graph, Role::kPose), Add(&graph, Role::kPose)};
  graph.AddEdge(std::make_shared<Difference>(x[1], x[0], 0.0, 1.0 / (0.1 * 0.1)));
  if (prior) graph.AddEdge(std::make_shared<Wish>(x[1], 0.2, 1.0 / (0.2 * 0.2)));
  graph.AddEdge(std::make_shared<Difference>(x[2], x[1], 0.0, 1.0 / (0.3 * 0.3)));
  Problem problem(&graph);
  problem.SetOrdering();
  problem.MakeHessian();
  const MarginalizeResult result = Problem::TestMarginalize(problem.Hessian(), problem.RightHandSide(), 1, 1);
  Print(name + ".H", problem.Hessian());
  Print(name + ".H_prior", result.H_prior);
  if (!prior) return;
  Print(name + ".b", problem.RightHandSide());
  Print(name + ".b_prior", result.b_prior);
  Print(name + ".before", problem.Hessian().ldlt().solve(problem.RightHandSide()).transpose());
  Print(name + ".after", Solution(result));
}

// Stages 1.1 and 1.2: the shape of H and S of the course's scene.
void ShapeOfTheScene() {
  MonoBa ba = BuildMonoBa(SimulateMonoBa({}), Gauge::kFree, 1.0, 0.0);
  Problem problem(&ba.graph);
  problem.SetOrdering();
  problem.MakeHessian();
  VecX delta_x;
  problem.SolveLinearSystem(1e-3, &delta_x);
  const auto num_zero_blocks = [](const MatXX& M) {
    int count = 0;
    for (int i = 0; i < 18; i += 6) {
      for (int j = 0; j < 18; j += 6) count += M.block(i, j, 6, 6).isZero(0.0);
    }
    return count;
  };
  Print("scene.rows", static_cast<double>(problem.Size()));
  Print("scene.zeros_in_H", num_zero_blocks(problem.Hessian()));
  Print("scene.zeros_in_S", num_zero_blocks(problem.SchurComplement()));
}

// Stage 3: how many eigenvalues of H are zero with priors on the first `priors` frames.
int NumZeroEigenvalues(size_t priors) {
  const MonoBaScene scene = SimulateMonoBa({});
  MonoBa ba = BuildMonoBa(scene, Gauge::kFree, 1.0, 0.0);
  for (size_t i = 0; i < priors; ++i) {
    ba.graph.AddEdge(std::make_shared<EdgeSE3Prior>(ba.poses[i], scene.frames[i].q, scene.frames[i].p));
  }
  Problem problem(&ba.graph);
  problem.Solve();
  problem.MakeHessian();
  const VecX S = DecomposeSymmetric(problem.Hessian()).S;
  return static_cast<int>((S.array() < 1e-10 * S.maxCoeff()).count());
}

// Stage 4: three numbers on a line, two differences measured with σ = 1.
void ThreeNumbers() {
  MatXX H(3, 3);
  H << 1, -1, 0, -1, 2, -1, 0, -1, 1;
  const MatXX covariance = PseudoInversePsd(H);
  const MatXX Q = GaugeProjection(VecX::Ones(3), VecX::Unit(3, 0));
  Print("line.free", covariance.diagonal().transpose());
  Print("line.held", TransformCovariance(covariance, MatXX::Identity(3, 3), Q, Q).diagonal().transpose());
}

// Stage 5: the example of rank 1.
class RankOne : private MarginalizationError {
 public:
  RankOne() {
    H_ = MatXX(2, 2);
    H_ << 4, 2, 2, 1;
    b0_ = Vec2(6, 3);
    UpdateErrorComputation();
    Eigen::Index row = 0;
    J_.col(0).cwiseAbs().maxCoeff(&row);
    const double sign = J_(row, 0) > 0.0 ? 1.0 : -1.0;
    Print("rank_one.H", H_);
    Print("rank_one.b0", b0_);
    Print("rank_one.J", sign * J_.row(row));
    Print("rank_one.e0", sign * e0_[row]);
    Print("rank_one.e", sign * Residual(Vec2(1, 0))[row]);
    Print("rank_one.b", -J_.transpose() * Residual(Vec2(1, 0)));
    Print("rank_one.e_null", sign * Residual(Vec2(1, -2))[row]);
  }
};

// Stage 6A: how many rows J has before and after all information is multiplied by 100.
void AbsoluteCut() {
  const MatXX A = Vec2(4.0, 1e-9).asDiagonal();
  Print("cut.before", static_cast<double>(FactorNormalEquations(A, Vec2(0, 0), EigenvalueCutoff::Vins()).J.rows()));
  Print("cut.after",
        static_cast<double>(FactorNormalEquations(100 * A, Vec2(0, 0), EigenvalueCutoff::Vins()).J.rows()));
}

// Stage 7: how many blocks S has if each landmark is seen by three poses in a row.
class LongDrive : public PlainBlockSolver {
 public:
  using PlainBlockSolver::PlainBlockSolver;
  size_t NumBlocks() const { return S_.All().size(); }
};

void LongDriveBlocks(int num_poses) {
  Graph graph;
  std::vector<Scalar> poses;
  for (int i = 0; i < num_poses; ++i) poses.push_back(Add(&graph, Role::kPose));
  for (size_t i = 0; i + 2 < poses.size(); ++i) {
    const Scalar landmark = Add(&graph, Role::kLandmark);
    for (size_t k = i; k < i + 3; ++k) graph.AddEdge(std::make_shared<Difference>(landmark, poses[k], 0.0, 1.0));
  }
  LongDrive solver(&graph);
  solver.SetOrdering();
  Print("drive.blocks", static_cast<double>(solver.NumBlocks()));
}

// The page of what the stages take for granted.
void Background() {
  const MatXX H = (Mat22() << 2, -1, -1, 1).finished();
  Print("background.covariance", H.inverse());
  Print("background.marginal", Problem::TestMarginalize(H, VecX::Zero(2), /*idx=*/1, /*dim=*/1).H_prior);
  Print("background.J_r_inverse", RightJacobianInverseSO3(Vec3(0, 0, M_PI / 2)));
  const MatXX J = 2.0 * (Mat22() << 1.0, 0.0, 0.6, 0.8).finished();
  Print("background.JtJ", J.transpose() * J);
  Print("background.determinant", (J.transpose() * J).determinant());
}

void All() {
  TwoPosesTwoLandmarks();
  Chain("chain", /*prior=*/true);
  Chain("loose_chain", /*prior=*/false);
  ShapeOfTheScene();
  for (const size_t priors : {0, 1, 2}) {
    Print("zeros." + std::to_string(priors), static_cast<double>(NumZeroEigenvalues(priors)));
  }
  ThreeNumbers();
  const RankOne printed;
  AbsoluteCut();
  LongDriveBlocks(100);
  Background();
}

}  // namespace
}  // namespace ch5

int main() {
  std::cout << std::setprecision(17);
  ch5::All();
}
