#include <algorithm>
#include <stdexcept>

#include "ch5_backend/marginalize/marginalization_error.h"
#include "ch5_backend/marginalize/moved_vertices.h"
#include "ch5_backend/marginalize/square_root.h"

namespace ch5 {
namespace {

std::string Name(const Vertex& vertex) { return vertex.TypeInfo() + " " + std::to_string(vertex.Id()); }

}  // namespace

int MarginalizationError::Find(const Vertex& vertex) const {
  const auto it =
      std::find_if(blocks_.begin(), blocks_.end(), [&](const Block& b) { return b.vertex.get() == &vertex; });
  return it == blocks_.end() ? -1 : static_cast<int>(it - blocks_.begin());
}

int MarginalizationError::OrderingIdx(const Vertex& vertex) const {
  const int i = Find(vertex);
  return i < 0 ? -1 : blocks_[static_cast<size_t>(i)].ordering_idx;
}

void MarginalizationError::Connect(const std::shared_ptr<Vertex>& vertex) {
  if (vertex->IsFixed() || Find(*vertex) >= 0) return;
  const bool is_landmark = vertex->GetRole() == Role::kLandmark;
  const int dim = vertex->LocalDimension();
  const int idx = InsertBlock(dim, is_landmark);
  if (!is_landmark) {  // the landmarks behind it have moved on
    for (Block& block : blocks_) block.ordering_idx += block.is_landmark ? dim : 0;
    dense_size_ += dim;
  }
  blocks_.push_back({vertex, idx, dim, is_landmark, vertex->Parameters()});
}

void MarginalizationError::AddResidualBlock(const std::shared_ptr<Edge>& edge) {
  const auto& vertices = edge->Vertices();
  const auto is_free_landmark = [](const auto& v) { return v->GetRole() == Role::kLandmark && !v->IsFixed(); };
  if (std::count_if(vertices.begin(), vertices.end(), is_free_landmark) > 1) {
    throw std::invalid_argument("MarginalizationError: " + edge->TypeInfo() + " ties two landmarks");
  }
  for (const auto& vertex : vertices) Connect(vertex);

  MovedVertices at_linearisation;
  for (const auto& vertex : vertices) {
    if (!vertex->IsFixed()) at_linearisation.Move(vertex.get(), blocks_[static_cast<size_t>(Find(*vertex))].x0);
  }
  edge->ComputeResidual();
  edge->ComputeJacobians();
  double drho;
  MatXX W;
  edge->RobustInfo(&drho, &W);

  for (size_t i = 0; i < vertices.size(); ++i) {
    if (vertices[i]->IsFixed()) continue;
    const int row = OrderingIdx(*vertices[i]), dim_i = vertices[i]->LocalDimension();
    const MatXX JtW = edge->Jacobian(i).transpose() * W;
    for (size_t j = 0; j < vertices.size(); ++j) {
      if (vertices[j]->IsFixed()) continue;
      H_.block(row, OrderingIdx(*vertices[j]), dim_i, vertices[j]->LocalDimension()) += JtW * edge->Jacobian(j);
    }
    b0_.segment(row, dim_i) -= drho * edge->Jacobian(i).transpose() * (edge->Information() * edge->Residual());
  }
}

void MarginalizationError::MarginalizeOut(const std::vector<std::shared_ptr<Vertex>>& vertices) {
  std::vector<bool> gone(static_cast<size_t>(H_.rows()), false);
  std::vector<int> dense;
  std::vector<size_t> landmarks;
  for (const auto& vertex : vertices) {
    const int i = vertex ? Find(*vertex) : -1;
    if (i < 0) {
      throw std::invalid_argument("MarginalizeOut: " + (vertex ? Name(*vertex) : "null") + " is not connected");
    }
    const Block& block = blocks_[static_cast<size_t>(i)];
    if (block.is_landmark) landmarks.push_back(static_cast<size_t>(i));
    for (int k = 0; k < block.dim; ++k) {
      gone[static_cast<size_t>(block.ordering_idx + k)] = true;
      if (!block.is_landmark) dense.push_back(block.ordering_idx + k);
    }
  }

  // Scaled to a unit diagonal, so that the pseudo-inverses compare like with like.
  const VecX p = ScalingOf(H_), p_inverse = p.cwiseInverse();
  H_ = p_inverse.asDiagonal() * H_ * p_inverse.asDiagonal();
  b0_ = p_inverse.asDiagonal() * b0_;

  // What a step works on: everything but the landmarks that go, whose blocks do not touch each other.
  std::vector<int> rest;
  const auto is_dense = [&](int row) { return std::find(dense.begin(), dense.end(), row) != dense.end(); };
  for (int row = 0; row < H_.rows(); ++row) {
    if (!gone[static_cast<size_t>(row)] || is_dense(row)) rest.push_back(row);
  }
  MatXX U = H_(rest, rest);
  VecX b_a = b0_(rest);
  for (const size_t i : landmarks) {
    const Block& block = blocks_[i];
    const MatXX V = H_.block(block.ordering_idx, block.ordering_idx, block.dim, block.dim);
    SchurComplement(V, H_(rest, Eigen::seqN(block.ordering_idx, block.dim)), b0_.segment(block.ordering_idx, block.dim),
                    &U, &b_a);
  }

  std::vector<int> stay, go, stay_rows;  // positions in `rest`, and rows of H
  for (int k = 0; k < static_cast<int>(rest.size()); ++k) {
    const bool goes = gone[static_cast<size_t>(rest[static_cast<size_t>(k)])];
    (goes ? go : stay).push_back(k);
    if (!goes) stay_rows.push_back(rest[static_cast<size_t>(k)]);
  }
  H_ = U(stay, stay);
  b0_ = b_a(stay);
  if (!go.empty()) SchurComplement(U(go, go), U(stay, go), b_a(go), &H_, &b0_);

  VecX p_stay = p(stay_rows);
  H_ = p_stay.asDiagonal() * H_ * p_stay.asDiagonal();
  b0_ = p_stay.asDiagonal() * b0_;
  RemoveRows(gone);
}

// Forgets the blocks whose rows are gone and closes the gaps; after a Schur complement the rest is dense.
void MarginalizationError::RemoveRows(const std::vector<bool>& gone) {
  std::vector<int> new_row(gone.size(), 0);
  for (size_t row = 1; row < gone.size(); ++row) new_row[row] = new_row[row - 1] + (gone[row - 1] ? 0 : 1);
  const auto is_gone = [&](const Block& block) { return gone[static_cast<size_t>(block.ordering_idx)]; };
  blocks_.erase(std::remove_if(blocks_.begin(), blocks_.end(), is_gone), blocks_.end());
  dense_size_ = 0;
  for (Block& block : blocks_) {
    block.ordering_idx = new_row[static_cast<size_t>(block.ordering_idx)];
    dense_size_ += block.is_landmark ? 0 : block.dim;
  }
}

VecX MarginalizationError::ComputeDeltaChi() const {
  VecX delta_chi(H_.rows());
  for (const Block& block : blocks_) delta_chi.segment(block.ordering_idx, block.dim) = block.vertex->Minus(block.x0);
  return delta_chi;
}

Prior MarginalizationError::GetPrior() const {
  std::vector<Block> blocks = blocks_;
  std::sort(blocks.begin(), blocks.end(),
            [](const Block& a, const Block& b) { return a.ordering_idx < b.ordering_idx; });
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
