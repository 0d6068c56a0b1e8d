#include "ch5_backend/solve/coupling_blocks.h"

namespace ch5 {

void CouplingBlocks::Take(int size) {
  const auto n = static_cast<size_t>(size + kLanes);  // the last block is read in whole registers too
  doubles.assign(single_precision ? 0 : n, 0.0);
  floats.assign(single_precision ? n : 0, 0.0F);
}

MatXX CouplingBlocks::Block(int begin, int rows, int columns) const {
  if (single_precision) return Eigen::Map<const Eigen::MatrixXf>(&floats[begin], rows, columns).cast<double>();
  return Eigen::Map<const MatXX>(&doubles[begin], rows, columns);
}

}  // namespace ch5
