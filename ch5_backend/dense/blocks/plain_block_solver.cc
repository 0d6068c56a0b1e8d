#include "ch5_backend/dense/blocks/plain_block_solver.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <stdexcept>

#include "ch5_backend/linear/pivot_rule.h"
#include "ch5_backend/linear/reduced_solver.h"

namespace ch5 {

void SparseBlocks::SetZero() {
  for (auto& block : blocks_) block.second.setZero();
}

MatXX& SparseBlocks::operator()(int i, int j) {
  const auto it = blocks_.find({i, j});
  if (it != blocks_.end()) return it->second;
  throw std::out_of_range(name_ + " has no block (" + std::to_string(i) + ", " + std::to_string(j) + ")");
}

PlainBlockSolver::PlainBlockSolver(Graph* graph)
    : graph_(graph), reduced_solver_(MakeReducedSolver(ReducedSolverType::kAutomatic)) {}

PlainBlockSolver::~PlainBlockSolver() = default;

// ---- structure -------------------------------------------------------------------------------------------------

void PlainBlockSolver::SetOrdering() {
  ordering_ = MakeOrdering(*graph_);
  block_of_row_.assign(static_cast<size_t>(Size()), BlockIndex{});
  for (const bool is_landmark : {false, true}) {
    int number = 0;
    for (const auto& vertex : is_landmark ? ordering_.landmarks : ordering_.poses) {
      block_of_row_[static_cast<size_t>(vertex->OrderingId())] = {is_landmark, number++};
    }
  }
  b_.setZero(Size());
  BuildStructure();
}

void PlainBlockSolver::MakeHessianBlocks() {
  for (SparseBlocks* blocks : {&H_pp_, &H_pl_, &H_ll_, &H_ll_inverse_, &S_}) blocks->Clear();
  seen_by_.assign(ordering_.landmarks.size(), {});
  for (const auto& edge : ordering_.edges) {
    for (const auto& v : edge->Vertices()) {
      for (const auto& w : edge->Vertices()) {
        if (v->OrderingId() < 0 || w->OrderingId() < 0) continue;
        const BlockIndex a = BlockIndexOf(*v), c = BlockIndexOf(*w);
        if (a.is_landmark && c.is_landmark && a.number != c.number) {
          throw GraphError("BuildStructure: " + edge->Name() + " ties two landmarks, " + v->Name() + " and " +
                           w->Name());
        }
        SparseBlocks* blocks = !c.is_landmark ? &H_pp_ : a.is_landmark ? &H_ll_ : &H_pl_;
        if (c.is_landmark == a.is_landmark ? a.number < c.number : a.is_landmark) continue;
        blocks->Add(a.number, c.number, v->LocalDimension(), w->LocalDimension());
        if (blocks != &H_pl_) continue;
        std::vector<int>& poses = seen_by_[static_cast<size_t>(c.number)];
        if (std::find(poses.begin(), poses.end(), a.number) == poses.end()) poses.push_back(a.number);
      }
    }
  }
  for (const auto& block : H_pp_.All()) AddSchurBlock(block.first.first, block.first.second);
}

std::vector<std::pair<int, int>> PlainBlockSolver::SchurPattern() const {
  std::vector<std::pair<int, int>> pattern;
  for (const auto& block : S_.All()) pattern.push_back(block.first);
  return pattern;
}

// ---- the linear system -----------------------------------------------------------------------------------------

void PlainBlockSolver::SetSystemToZero() {
  for (SparseBlocks* blocks : {&H_pp_, &H_pl_, &H_ll_}) blocks->SetZero();
  b_.setZero(Size());
}

VecX::SegmentReturnType PlainBlockSolver::LandmarkPart(VecX* v, int l) const {
  const Vertex& landmark = *ordering_.landmarks[static_cast<size_t>(l)];
  return v->segment(landmark.OrderingId(), landmark.LocalDimension());
}

bool PlainBlockSolver::InvertLandmarks(double lambda) {
  H_ll_inverse_.Clear();
  for (int l = 0; l < NumLandmarks(); ++l) {
    MatXX damped = H_ll_(l, l);
    for (int i = 0; i < damped.rows(); ++i) damped(i, i) += lambda * DampingEntry(damped(i, i));
    const Eigen::LLT<MatXX> llt(damped);
    const double rounding = PivotRounding(static_cast<int>(damped.rows()));
    for (int i = 0; i < damped.rows(); ++i) {
      const double root = llt.matrixLLT()(i, i);
      if (llt.info() != Eigen::Success || !(root * root > rounding * damped(i, i))) return false;
    }
    H_ll_inverse_.Add(l, l, 0, 0);
    H_ll_inverse_(l, l) = llt.solve(MatXX::Identity(damped.rows(), damped.rows()));
  }
  return true;
}

void PlainBlockSolver::BeginSchurComplement(double lambda) {
  b_schur_ = b_.head(ordering_.dim_poses);
  scale_.resize(ordering_.dim_poses);
  S_.SetZero();
  for (const auto& [place, block] : H_pp_.All()) {
    MatXX& target = S_(place.first, place.second);
    target = block;
    if (place.first != place.second) continue;
    for (int i = 0; i < block.rows(); ++i) {
      target(i, i) += lambda * DampingEntry(block(i, i));
      scale_[PoseRow(place.first) + i] = target(i, i);
    }
  }
}

bool PlainBlockSolver::SolvePoses(VecX* delta_x) {
  delta_x->setZero(Size());
  if (ordering_.poses.empty()) return true;
  Array<int> dims;
  for (const auto& pose : ordering_.poses) dims.push_back(pose->LocalDimension());
  std::vector<std::vector<int>> rows(dims.size());
  for (const auto& block : S_.All()) rows[static_cast<size_t>(block.first.second)].push_back(block.first.first);
  SymmetricBlockMatrix S;
  S.SetPattern(dims, rows);
  for (const auto& [place, block] : S_.All()) {
    double* values = S.Values(S.Find(place.first, place.second));
    for (int c = 0; c < block.cols(); ++c) {
      std::copy_n(block.col(c).data(), block.rows(), values + c * Stride(static_cast<int>(block.rows())));
    }
  }
  reduced_solver_->Prepare(S, nullptr);
  VecX delta_poses;
  if (!reduced_solver_->Solve(S, b_schur_, scale_, &delta_poses)) return false;
  delta_x->head(ordering_.dim_poses) = delta_poses;
  return true;
}

// ---- H as a whole ----------------------------------------------------------------------------------------------

VecX PlainBlockSolver::HessianDiagonal() const {
  VecX diagonal(Size());
  for (int i = 0; i < static_cast<int>(ordering_.poses.size()); ++i) {
    diagonal.segment(PoseRow(i), PoseDimension(i)) = H_pp_(i, i).diagonal();
  }
  for (int l = 0; l < NumLandmarks(); ++l) LandmarkPart(&diagonal, l) = H_ll_(l, l).diagonal();
  return diagonal;
}

VecX PlainBlockSolver::MultiplyHessian(const VecX& v) const {
  VecX y = VecX::Zero(Size());
  for (const SparseBlocks* blocks : {&H_pp_, &H_pl_, &H_ll_}) {
    const auto& rows = blocks == &H_ll_ ? ordering_.landmarks : ordering_.poses;
    const auto& columns = blocks == &H_pp_ ? ordering_.poses : ordering_.landmarks;
    for (const auto& [place, block] : blocks->All()) {
      const int row = rows[static_cast<size_t>(place.first)]->OrderingId();
      const int column = columns[static_cast<size_t>(place.second)]->OrderingId();
      y.segment(row, block.rows()) += block * v.segment(column, block.cols());
      if (row != column) y.segment(column, block.cols()) += block.transpose() * v.segment(row, block.rows());
    }
  }
  return y;
}

MatXX PlainBlockSolver::DenseHessian() const {
  MatXX H(Size(), Size());
  for (int k = 0; k < Size(); ++k) H.col(k) = MultiplyHessian(VecX::Unit(Size(), k));
  return H;
}

MatXX PlainBlockSolver::SchurComplement() const {
  MatXX S = MatXX::Zero(ordering_.dim_poses, ordering_.dim_poses);
  for (const auto& [place, block] : S_.All()) {
    const int row = PoseRow(place.first), column = PoseRow(place.second);
    S.block(column, row, block.cols(), block.rows()) = block.transpose();
    S.block(row, column, block.rows(), block.cols()) = block;  // last: on the diagonal it is what stands there
  }
  return S;
}

}  // namespace ch5
