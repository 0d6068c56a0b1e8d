#include "ch5_backend/sparse/hold_poses.h"

#include <algorithm>
#include <stdexcept>

#include "ch5_backend/math/psd.h"

namespace ch5 {
namespace {

using Block = Eigen::Map<MatXX, 0, Eigen::OuterStride<>>;

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

void ProjectCoupling(const Structure& s, int i, const MatXX& projection, Linearized* system) {
  for (const int slot : s.pose_slots[i]) {
    if (!system->H_pl_factors.empty()) {  // H_pl = J̃_pᵀJ̃_l, and J̃_p takes the projection
      const int dim = s.pose_dim[i], row = dim + s.landmark_dim[s.slot_landmark[slot]];
      Eigen::Map<Eigen::MatrixXf> J(&system->H_pl_factors[static_cast<size_t>(slot) * 2 * row], row, 2);  // transposed
      J.topRows(dim) = (projection * J.topRows(dim).cast<double>()).cast<float>().eval();
      continue;
    }
    Eigen::Map<MatXX> block(system->H_pl.data() + s.SlotBlock(slot), s.pose_dim[i],
                            s.landmark_dim[s.slot_landmark[slot]]);
    block = projection.lazyProduct(block).eval();
  }
}

}  // namespace

std::vector<HeldPose> FindHeldPoses(const Structure& s, const std::vector<HeldDirections>& held) {
  std::vector<HeldPose> poses;
  for (const HeldDirections& h : held) {
    if (!h.vertex || !h.rows) throw std::invalid_argument("HeldDirections: the vertex or its rows are missing (null)");
    const MatXX C = h.rows();
    const int dim = h.vertex->LocalDimension();
    const auto refuse = [&](const std::string& fault) {
      throw std::invalid_argument("HeldDirections: " + h.vertex->Name() + " cannot be held" + fault);
    };
    if (h.vertex->GetRole() == Role::kLandmark) refuse(": it is a landmark; give it the role of a pose");
    if (C.cols() != dim) {
      refuse(" along " + std::to_string(C.cols()) + " coordinates: it has " + std::to_string(dim) +
             " degrees of freedom");
    }
    if (!C.allFinite())
      throw std::invalid_argument("HeldDirections: the rows of " + h.vertex->Name() + " are not finite");
    if (C.isZero(0.0)) refuse(" along no direction: its rows are missing or zero");
    const auto found = std::find(s.poses.begin(), s.poses.end(), h.vertex.get());
    if (found == s.poses.end()) continue;
    const MatXX onto_rows = C.transpose() * PseudoInversePsd(C * C.transpose()) * C;
    poses.push_back({static_cast<int>(found - s.poses.begin()), MatXX::Identity(dim, dim) - onto_rows});
  }
  return poses;
}

// The normal equations under the constraints C δ = 0, by their null space.  Nocedal & Wright (2006), §15.3
void HoldPoses(const Structure& s, const std::vector<HeldPose>& held, Linearized* system) {
  for (const auto& [i, projection] : held) {
    ProjectPoseBlocks(s, i, projection, &system->H_pp);
    ProjectCoupling(s, i, projection, system);
    auto b = system->b.segment(s.pose_offset[i], s.pose_dim[i]);
    b = (projection * b).eval();
  }
}

}  // namespace ch5
