#include "ch5_backend/sparse/covariance.h"

#include <Eigen/Cholesky>

#include "ch5_backend/linear/pivot_rule.h"
#include "ch5_backend/linear/selected_inverse.h"
#include "ch5_backend/sparse/sparse_solver.h"

namespace ch5 {
namespace {

std::unordered_map<const Vertex*, int> NumbersOf(const Array<Vertex*>& vertices) {
  std::unordered_map<const Vertex*, int> numbers;
  for (const Vertex* vertex : vertices) numbers.emplace(vertex, static_cast<int>(numbers.size()));
  return numbers;
}

}  // namespace

// Keeps the factor of S that the solver would throw away.
class Covariance::Factorization : public ReducedSolver {
 public:
  explicit Factorization(CovarianceFactor factor) : factor_(factor) {}

  void Prepare(const SymmetricBlockMatrix& S, ThreadPool* pool) override {
    cholesky_.Analyze(S, factor_ == CovarianceFactor::kDense ? PlanOneFront(S) : PlanElimination(S), pool);
  }
  bool Solve(const SymmetricBlockMatrix& S, const VecX& b, const VecX& scale, VecX* x) override {
    refused_ = !cholesky_.Factorize(S, PivotRounding(S.Size()) * scale);
    if (!refused_) cholesky_.Solve(b, x);
    return !refused_;
  }

  SparseCholesky& Cholesky() { return cholesky_; }
  bool Refused() const { return refused_; }

 private:
  CovarianceFactor factor_;
  SparseCholesky cholesky_;
  bool refused_ = false;
};

Covariance::Covariance(Graph* graph, const Selection& selection, CovarianceFactor factor, int threads,
                       const std::vector<HeldDirections>& held)
    : solver_(std::make_unique<SparseSolver>(graph, threads)), vertices_(graph->Vertices()) {
  auto factorization = std::make_unique<Factorization>(factor);
  factorization_ = factorization.get();
  solver_->SetReducedSolver(std::move(factorization));
  solver_->Select(selection);
  solver_->Hold(held);
  solver_->SetOrdering();
  pose_numbers_ = NumbersOf(solver_->GetStructure().poses);
  landmark_numbers_ = NumbersOf(solver_->GetStructure().landmarks);
  solver_->MakeHessian();
  for (const auto& [pose, projection] : solver_->HeldPoses()) projections_[pose] = projection;
  VecX delta_x;
  if (!solver_->SolveLinearSystem(0.0, &delta_x)) ThrowSingular();
  inverse_ = std::make_unique<SelectedInverse>(factorization_->Cholesky());
}

Covariance::~Covariance() = default;

void Covariance::ThrowSingular() const {
  const Structure& s = solver_->GetStructure();
  const std::string what = WhatIsNotFinite(s.ordering.edges);
  if (!what.empty()) throw CovarianceError("Covariance: " + what);
  for (size_t l = 0; l < s.landmarks.size() && !factorization_->Refused(); ++l) {
    const int dim = s.landmark_dim[l];
    const Eigen::LDLT<MatXX> ldlt(
        Eigen::Map<const MatXX>(&solver_->GetLinearized().H_ll[s.landmark_block[l]], dim, dim));
    const double rounding = PivotRounding(dim) * ldlt.vectorD().maxCoeff();
    if (ldlt.vectorD().minCoeff() > rounding) continue;
    throw CovarianceError("Covariance: H is singular, as its edges do not determine " + s.landmarks[l]->Name());
  }
  throw CovarianceError("Covariance: H is singular; is a gauge free?");
}

std::vector<Covariance::Influence> Covariance::InfluencesOn(const Vertex& vertex, int* landmark) const {
  const Structure& s = solver_->GetStructure();
  *landmark = -1;
  if (const auto pose = pose_numbers_.find(&vertex); pose != pose_numbers_.end()) {
    return {{pose->second, MatXX::Identity(vertex.LocalDimension(), vertex.LocalDimension())}};
  }
  const auto found = landmark_numbers_.find(&vertex);
  if (found == landmark_numbers_.end()) {
    throw CovarianceError("Covariance: " + vertex.Name() + (vertex.IsFixed() ? " is fixed" : " takes no part"));
  }
  const int l = *landmark = found->second;
  const int dim = s.landmark_dim[l];
  const Eigen::Map<const MatXX> H_ll_inverse(&solver_->GetEliminated().H_ll_inverse[s.landmark_block[l]], dim, dim);
  std::vector<Influence> influences;
  for (int slot = s.landmark_slots[l]; slot < s.landmark_slots[l + 1]; ++slot) {
    const int p = s.slot_pose[slot];
    influences.push_back({p, -solver_->GetLinearized().Coupling(s, slot) * H_ll_inverse});
  }
  return influences;
}

// Takes out what HoldPoses has put into H⁻¹ in place of the held directions.
void Covariance::Project(int pose, Eigen::Ref<MatXX> rows) const {
  const auto held = projections_.find(pose);
  if (held != projections_.end()) rows = (held->second * rows).eval();
}

MatXX Covariance::PoseBlock(int i, int j) {
  if (auto block = inverse_->Block(i, j)) {
    Project(i, *block);
    MatXX transposed = block->transpose();
    Project(j, transposed);
    return transposed.transpose();
  }
  const SymmetricBlockMatrix& S = solver_->GetEliminated().S;
  MatXX& columns = columns_[j];
  if (columns.size() == 0) {
    columns.resize(S.Size(), S.Dim(j));
    VecX x;
    for (int c = 0; c < S.Dim(j); ++c) {
      factorization_->Cholesky().Solve(VecX::Unit(S.Size(), S.Offset(j) + c), &x);
      columns.col(c) = x;
    }
    for (int k = 0; k < S.NumColumns(); ++k) Project(k, columns.middleRows(S.Offset(k), S.Dim(k)));
    MatXX transposed = columns.transpose();
    Project(j, transposed);
    columns = transposed.transpose();
  }
  return columns.middleRows(S.Offset(i), S.Dim(i));
}

MatXX Covariance::Block(const Vertex& a, const Vertex& b) {
  int landmark_a, landmark_b;
  const std::vector<Influence> on_a = InfluencesOn(a, &landmark_a), on_b = InfluencesOn(b, &landmark_b);
  MatXX block = MatXX::Zero(a.LocalDimension(), b.LocalDimension());
  if (&a == &b && landmark_a >= 0) {
    const double* H_ll_inverse =
        &solver_->GetEliminated().H_ll_inverse[solver_->GetStructure().landmark_block[landmark_a]];
    block = Eigen::Map<const MatXX>(H_ll_inverse, block.rows(), block.cols());
  }
  for (const Influence& i : on_a) {
    for (const Influence& j : on_b) block += i.coefficient.transpose() * PoseBlock(i.pose, j.pose) * j.coefficient;
  }
  return block;
}

std::vector<MatXX> Covariance::Blocks(const std::vector<VertexPair>& pairs) {
  std::vector<MatXX> blocks;
  for (const auto& [a, b] : pairs) {
    if (!a || !b) throw CovarianceError("Covariance: a vertex is missing (null)");
    blocks.push_back(Block(*a, *b));
  }
  return blocks;
}

}  // namespace ch5
