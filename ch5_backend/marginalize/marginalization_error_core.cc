#include <algorithm>
#include <stdexcept>

#include "ch5_backend/marginalize/marginalization_error.h"
#include "ch5_backend/marginalize/scoped_linearization_point.h"
#include "ch5_backend/marginalize/square_root.h"

namespace ch5 {
namespace {

std::vector<int> RowsWithout(const std::vector<bool>& is_left_out) {
  std::vector<int> rows;
  for (size_t row = 0; row < is_left_out.size(); ++row) {
    if (!is_left_out[row]) rows.push_back(static_cast<int>(row));
  }
  return rows;
}

// What is left by a graded function, on whose sizes the rest relies.
void RequireRows(Eigen::Index n, const MatXX& H, const VecX& b0, const char* function) {
  if (H.rows() == n && H.cols() == n && b0.size() == n) return;
  throw std::logic_error(std::string(function) + " leaves " + std::to_string(H.rows()) + " rows, not " +
                         std::to_string(n));
}

}  // namespace

MarginalizationError::~MarginalizationError() = default;

int MarginalizationError::Find(const Vertex& vertex) const {
  const auto it =
      std::find_if(blocks_.begin(), blocks_.end(), [&](const Block& b) { return b.vertex.get() == &vertex; });
  return it == blocks_.end() ? -1 : static_cast<int>(it - blocks_.begin());
}

int MarginalizationError::OrderingId(const Vertex& vertex) const {
  const int i = Find(vertex);
  return i < 0 ? -1 : blocks_[static_cast<size_t>(i)].ordering_id;
}

void MarginalizationError::Connect(const std::shared_ptr<Vertex>& vertex) {
  if (vertex->IsFixed() || Find(*vertex) >= 0) return;
  const bool is_landmark = vertex->GetRole() == Role::kLandmark;
  const int dim = vertex->LocalDimension(), size = static_cast<int>(H_.rows());
  const int idx = InsertBlock(dim, is_landmark);
  RequireRows(size + dim, H_, b0_, "InsertBlock");
  if (idx < 0 || idx > size) throw std::logic_error("InsertBlock returns " + std::to_string(idx));
  if (!is_landmark) {  // the landmarks behind it move back
    for (Block& block : blocks_) block.ordering_id += block.is_landmark ? dim : 0;
    dense_size_ += dim;
  }
  blocks_.push_back({vertex, idx, dim, is_landmark, vertex->Parameters()});
}

void MarginalizationError::AddResidualBlock(const std::shared_ptr<Edge>& edge) {
  if (!edge) throw std::invalid_argument("MarginalizationError: the edge is null");
  const auto& vertices = edge->Vertices();
  const auto is_free_landmark = [](const auto& v) { return v->GetRole() == Role::kLandmark && !v->IsFixed(); };
  if (std::count_if(vertices.begin(), vertices.end(), is_free_landmark) > 1) {
    throw std::invalid_argument("MarginalizationError: " + edge->TypeInfo() + " connects two landmarks");
  }
  for (const auto& vertex : vertices) Connect(vertex);

  ScopedLinearizationPoint at_linearization;
  for (const auto& vertex : vertices) {
    if (!vertex->IsFixed()) at_linearization.Move(vertex.get(), blocks_[static_cast<size_t>(Find(*vertex))].x0);
  }
  edge->ComputeResidual();
  edge->ComputeJacobians();
  double drho;
  MatXX W;
  edge->RobustInfo(&drho, &W);

  for (size_t i = 0; i < vertices.size(); ++i) {
    if (vertices[i]->IsFixed()) continue;
    const int row = OrderingId(*vertices[i]), dim_i = vertices[i]->LocalDimension();
    const MatXX JtW = edge->Jacobian(i).transpose() * W;
    for (size_t j = 0; j < vertices.size(); ++j) {
      if (vertices[j]->IsFixed()) continue;
      H_.block(row, OrderingId(*vertices[j]), dim_i, vertices[j]->LocalDimension()) += JtW * edge->Jacobian(j);
    }
    b0_.segment(row, dim_i) -= drho * edge->Jacobian(i).transpose() * (edge->Information() * edge->Residual());
  }
}

void MarginalizationError::MarginalizeOut(const std::vector<std::shared_ptr<Vertex>>& vertices) {
  std::vector<bool> is_dropped(static_cast<size_t>(H_.rows()), false);
  std::vector<bool> is_dropped_landmark = is_dropped;
  std::vector<const Block*> landmarks;
  for (const auto& vertex : vertices) {
    const int i = vertex ? Find(*vertex) : -1;
    if (i < 0) {
      throw std::invalid_argument("MarginalizeOut: " + (vertex ? vertex->Name() : "null") + " is not connected");
    }
    const Block& block = blocks_[static_cast<size_t>(i)];
    std::fill_n(is_dropped.begin() + block.ordering_id, block.dim, true);
    if (!block.is_landmark) continue;
    std::fill_n(is_dropped_landmark.begin() + block.ordering_id, block.dim, true);
    landmarks.push_back(&block);
  }
  // Scaled to a unit diagonal, so that the cutoff of the pseudo-inverses does not depend on units.
  const VecX p = ScalingOf(H_), p_inverse = p.cwiseInverse();
  H_ = p_inverse.asDiagonal() * H_ * p_inverse.asDiagonal();
  b0_ = p_inverse.asDiagonal() * b0_;
  const std::vector<int> dense_rows = RowsWithout(is_dropped_landmark);
  EliminateLandmarks(landmarks, dense_rows);
  EliminateDense(dense_rows, is_dropped);

  const VecX p_kept = p(RowsWithout(is_dropped));
  H_ = p_kept.asDiagonal() * H_ * p_kept.asDiagonal();
  b0_ = p_kept.asDiagonal() * b0_;
  RemoveRows(is_dropped);
}

// One small block at a time, as no two landmarks share an edge. H_ and b0_ keep the given rows, which
// are those of all other blocks.
void MarginalizationError::EliminateLandmarks(const std::vector<const Block*>& landmarks,
                                              const std::vector<int>& rows) {
  MatXX U = H_(rows, rows);
  VecX b_a = b0_(rows);
  for (const Block* block : landmarks) {
    const int idx = block->ordering_id, dim = block->dim;
    SchurComplement(H_.block(idx, idx, dim, dim), H_(rows, Eigen::seqN(idx, dim)), b0_.segment(idx, dim), &U, &b_a);
    RequireRows(static_cast<Eigen::Index>(rows.size()), U, b_a, "SchurComplement");
  }
  H_ = std::move(U);
  b0_ = std::move(b_a);
}

// @param rows  to which rows of the full H those of H_ belong;  @param is_dropped  by row of the full H
void MarginalizationError::EliminateDense(const std::vector<int>& rows, const std::vector<bool>& is_dropped) {
  std::vector<int> kept, dropped;  // rows of H_
  for (size_t k = 0; k < rows.size(); ++k) {
    (is_dropped[static_cast<size_t>(rows[k])] ? dropped : kept).push_back(static_cast<int>(k));
  }
  const MatXX H = H_;
  const VecX b0 = b0_;
  H_ = H(kept, kept);
  b0_ = b0(kept);
  if (!dropped.empty()) SchurComplement(H(dropped, dropped), H(kept, dropped), b0(dropped), &H_, &b0_);
  RequireRows(static_cast<Eigen::Index>(kept.size()), H_, b0_, "SchurComplement");
}

// Removes the dropped blocks and renumbers the others, which are all connected after the Schur complement.
void MarginalizationError::RemoveRows(const std::vector<bool>& is_dropped) {
  std::vector<int> new_row(is_dropped.size(), 0);
  for (size_t row = 1; row < is_dropped.size(); ++row) new_row[row] = new_row[row - 1] + (is_dropped[row - 1] ? 0 : 1);
  const auto dropped = [&](const Block& block) { return is_dropped[static_cast<size_t>(block.ordering_id)]; };
  blocks_.erase(std::remove_if(blocks_.begin(), blocks_.end(), dropped), blocks_.end());
  dense_size_ = 0;
  for (Block& block : blocks_) {
    block.ordering_id = new_row[static_cast<size_t>(block.ordering_id)];
    dense_size_ += block.is_landmark ? 0 : block.dim;
  }
}

VecX MarginalizationError::ComputeDeltaChi() const {
  VecX delta_chi(H_.rows());
  for (const Block& block : blocks_) delta_chi.segment(block.ordering_id, block.dim) = block.vertex->Minus(block.x0);
  return delta_chi;
}

Prior MarginalizationError::GetPrior() const {
  std::vector<Block> blocks = blocks_;
  std::sort(blocks.begin(), blocks.end(), [](const Block& a, const Block& b) { return a.ordering_id < b.ordering_id; });
  Prior prior;
  for (const Block& block : blocks) {
    prior.vertices.push_back(block.vertex);
    prior.x0.push_back(block.x0);
  }
  prior.J = J_;
  prior.r0 = e0_;
  return prior;
}

}  // namespace ch5
