#include <Eigen/QR>
#include <algorithm>
#include <stdexcept>

#include "ch5_backend/sparse/linearize.h"

namespace ch5 {
namespace {

using Block = Eigen::Map<MatXX, 0, Eigen::OuterStride<>>;

// The vertex's number among the poses, or −1 if it has no rows.
int PoseNumber(const Structure& s, const Vertex& vertex) {
  const auto found = std::find(s.poses.begin(), s.poses.end(), &vertex);
  return found == s.poses.end() ? -1 : static_cast<int>(found - s.poses.begin());
}

Block BlockOf(const Structure& s, int row, int column, int number, SymmetricBlockMatrix* H_pp) {
  const int rows = s.pose_dim[row];
  return Block(H_pp->Values(number), rows, s.pose_dim[column], Eigen::OuterStride<>(Stride(rows)));
}

void ProjectPoseBlocks(const Structure& s, int i, const MatXX& projection, SymmetricBlockMatrix* H_pp) {
  for (int j = 0; j < i; ++j) {
    const int number = H_pp->Find(i, j);
    if (number >= 0) BlockOf(s, i, j, number, H_pp) = projection * BlockOf(s, i, j, number, H_pp);
  }
  for (int number = H_pp->ColumnBegin(i); number < H_pp->ColumnBegin(i + 1); ++number) {
    Block block = BlockOf(s, H_pp->Row(number), i, number, H_pp);
    block = block * projection;
    if (H_pp->Row(number) != i) continue;
    const double h = std::max(block.trace() / static_cast<double>(block.rows()), 1e-3);
    block = projection * block + h * (MatXX::Identity(block.rows(), block.cols()) - projection);
  }
}

template <typename Scalar>
void ProjectCoupling(const Structure& s, int i, const MatXX& projection, Scalar* H_pl) {
  using Coupling = Eigen::Matrix<Scalar, Eigen::Dynamic, Eigen::Dynamic>;
  for (int k = s.pose_slots_begin[i]; k < s.pose_slots_begin[i + 1]; ++k) {
    const int slot = s.pose_slots[k];
    Eigen::Map<Coupling> block(H_pl + s.slot_block[slot], s.pose_dim[i], s.landmark_dim[s.slot_landmark[slot]]);
    block = projection.cast<Scalar>() * block;
  }
}

}  // namespace

MatXX ProjectionBesides(const MatXX& C) {
  const Eigen::CompleteOrthogonalDecomposition<MatXX> decomposition(C);
  return MatXX::Identity(C.cols(), C.cols()) - decomposition.pseudoInverse() * C;
}

// The normal equations of the constraints C δ = 0, by their null space.  Nocedal & Wright (2006), §15.3
void HoldDirections(const Structure& s, const std::vector<HeldDirections>& held, Linearized* system) {
  for (const HeldDirections& h : held) {
    const MatXX C = h.rows();
    if (C.cols() != h.vertex->LocalDimension() || h.vertex->GetRole() == Role::kLandmark) {
      throw std::invalid_argument("HoldDirections: " + h.vertex->TypeInfo() + " cannot be held in directions of " +
                                  std::to_string(C.cols()) + " numbers: it is a landmark, or has " +
                                  std::to_string(h.vertex->LocalDimension()) + " degrees of freedom");
    }
    const int i = PoseNumber(s, *h.vertex);
    if (i < 0) continue;
    const MatXX projection = ProjectionBesides(C);
    ProjectPoseBlocks(s, i, projection, &system->H_pp);
    if (system->H_pl.single_precision) ProjectCoupling(s, i, projection, system->H_pl.Numbers<float>());
    if (!system->H_pl.single_precision) ProjectCoupling(s, i, projection, system->H_pl.Numbers<double>());
    auto b = system->b.segment(s.pose_offset[i], s.pose_dim[i]);
    b = projection * b;
  }
}

}  // namespace ch5
