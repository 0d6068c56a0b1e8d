#pragma once
/// Linear problems over the poses of a graph, with D numbers δ_i a pose and K right-hand sides at once:
///
///   min Σ ‖r + J_i δ_i + J_j δ_j‖²_W   over the edges (i, j);   δ = 0 for the poses that are held
///
/// The blocks go straight into the normal equations: no graph, and one factorization for all K.

#include <algorithm>
#include <vector>

#include "ch5_backend/graph/graph.h"
#include "ch5_backend/linear/reduced_solver.h"

namespace ch5 {

template <int D, int K = 1>
class LinearShift {
 public:
  using Shift = Eigen::Matrix<double, D, K>;

  /// @param edges    of two poses each;  @param is_held  of each of the graph's vertices
  LinearShift(const Graph& graph, const std::vector<Edge*>& edges, const std::vector<bool>& is_held)
      : graph_(graph), number_(is_held.size(), kHeld) {
    int count = 0;
    std::vector<std::vector<int>> rows;
    for (const Edge* edge : edges) {
      for (const auto& vertex : edge->Vertices()) {
        const size_t position = graph.PositionOf(*vertex);
        if (number_[position] != kHeld || is_held[position]) continue;
        rows.push_back({number_[position] = count++});
      }
      const auto [first, second] = std::minmax({Number(*edge, 0), Number(*edge, 1)});
      if (first != kHeld && first != second) rows[first].push_back(second);
    }
    for (auto& column : rows) {
      std::sort(column.begin(), column.end());
      column.erase(std::unique(column.begin(), column.end()), column.end());
    }
    H_.SetPattern(Array<int>(static_cast<size_t>(count), D), rows);
    b_.setZero(D * count, K);
  }

  /// Adds an edge's term.
  template <int R>
  void Add(const Edge& edge, const Eigen::Matrix<double, R, K>& r, const Eigen::Matrix<double, R, D>& J_i,
           const Eigen::Matrix<double, R, D>& J_j, const Eigen::Matrix<double, R, R>& W) {
    const int i = Number(edge, 0), j = Number(edge, 1);
    const Eigen::Matrix<double, D, R> J_i_W = J_i.transpose() * W, J_j_W = J_j.transpose() * W;
    if (i != kHeld) Block(i, i) += J_i_W * J_i, b_.template middleRows<D>(D * i) -= J_i_W * r;
    if (j != kHeld) Block(j, j) += J_j_W * J_j, b_.template middleRows<D>(D * j) -= J_j_W * r;
    if (i == kHeld || j == kHeld) return;
    if (i == j) {
      Block(i, i) += J_i_W * J_j + J_j_W * J_i;
    } else if (i > j) {
      Block(i, j) += J_i_W * J_j;
    } else {
      Block(j, i) += J_j_W * J_i;
    }
  }

  /// With as little damping as the factorization bears, which only keeps in place what no edge determines: the weakest
  /// direction of a chain of n poses has about 1/n² of the diagonal.
  void Solve(int threads) {
    ThreadPool pool(threads);
    const auto solver = MakeReducedSolver(ReducedSolverType::kAutomatic);
    solver->Prepare(H_, &pool);
    const VecX diagonal = H_.Diagonal();
    delta_.setZero(b_.rows(), K);
    VecX x;
    for (double tau = 1e-13, damped = 0.0; tau < 1.0; tau *= 10.0) {
      for (int k = 0; k < H_.Size(); ++k) {
        H_.Values(H_.ColumnBegin(k / D))[k % D * (Stride(D) + 1)] += (tau - damped) * std::max(diagonal[k], 1e-6);
      }
      damped = tau;
      bool solved = true;
      for (int k = 0; k < K && solved; ++k) {
        solved = solver->Solve(H_, b_.col(k), H_.Diagonal(), &x);
        if (solved) delta_.col(k) = x;
      }
      if (solved) return;
    }
    delta_.setZero();
  }

  /// δ of a pose; zero if it is held or has no edge here.
  Shift Of(const Vertex& vertex) const {
    const int number = number_[graph_.PositionOf(vertex)];
    return number == kHeld ? Shift::Zero().eval() : delta_.template middleRows<D>(D * number).eval();
  }

 private:
  static constexpr int kHeld = -1;
  using BlockMap = Eigen::Map<Eigen::Matrix<double, D, D>, 0, Eigen::OuterStride<>>;

  int Number(const Edge& edge, size_t end) const { return number_[graph_.PositionOf(*edge.Vertices()[end])]; }
  BlockMap Block(int i, int j) { return BlockMap(H_.Values(H_.Find(i, j)), Eigen::OuterStride<>(Stride(D))); }

  const Graph& graph_;
  std::vector<int> number_;  // of each of the graph's vertices
  SymmetricBlockMatrix H_;
  Eigen::Matrix<double, Eigen::Dynamic, K> b_, delta_;
};

}  // namespace ch5
