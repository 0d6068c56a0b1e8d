#include <stdexcept>
#include <string>

#include "ch5_backend/dense/dense_solvers.h"
#include "ch5_backend/dense/problem.h"

namespace ch5 {

Problem::Problem(Graph* graph, LinearSolver linear_solver) : graph_(graph), linear_solver_(linear_solver) {
  SetOrdering();
}

Problem::~Problem() = default;

void Problem::SetOrdering() {
  ordering_ = MakeOrdering(*graph_);
  ordering_poses_ = ordering_.dim_poses;
  ordering_landmarks_ = ordering_.dim_landmarks;
  idx_landmark_vertices_.clear();
  for (const auto& landmark : ordering_.landmarks) idx_landmark_vertices_.emplace(landmark->Id(), landmark);
  LandmarkOfEachEdge(ordering_);  // throws if an edge has two
  Hessian_.setZero(Size(), Size());
  b_.setZero(Size());
}

const MatXX& Problem::DampedHessian(double lambda) {
  H_damped_ = Hessian_;
  for (int i = 0; i < H_damped_.rows(); ++i) H_damped_(i, i) += lambda * DampingEntry(Hessian_(i, i));
  return H_damped_;
}

bool Problem::SolvePoses(VecX* delta_x_pp) const {
  const MatXX& S = H_pp_schur_;
  if (S.rows() != ordering_poses_ || S.cols() != ordering_poses_ || b_pp_schur_.size() != ordering_poses_) {
    throw std::logic_error("SolvePoses: the poses have " + std::to_string(ordering_poses_) + " rows, H_pp_schur_ is " +
                           std::to_string(S.rows()) + "×" + std::to_string(S.cols()) + ", b_pp_schur_ has " +
                           std::to_string(b_pp_schur_.size()) + " entries");
  }
  return SolveDense(S, b_pp_schur_, delta_x_pp);
}

bool Problem::SolveDense(const MatXX& A, const VecX& b, VecX* x) const {
  if (linear_solver_ == LinearSolver::kLdlt) return SolveLdlt(A, b, x);
  return SolvePcg(A, b, /*max_iterations=*/10 * static_cast<int>(A.rows()) + 100, /*tolerance=*/1e-14, x);
}

}  // namespace ch5
