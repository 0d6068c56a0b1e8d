#include "ch5_backend/sparse/coupling_blocks.h"

#include "ch5_backend/math/large_pages.h"

namespace ch5 {
namespace {

template <typename Numbers>
void TakeZeros(size_t n, Numbers* numbers) {
  numbers->clear();
  numbers->reserve(n);
  AskForLargePages(numbers->data(), n * sizeof(numbers->front()));
  numbers->resize(n);
}

}  // namespace

void CouplingBlocks::Take(int size) {
  const auto n = static_cast<size_t>(size + kLanes);  // the last block is read in whole registers too
  TakeZeros(single_precision ? 0 : n, &doubles);
  TakeZeros(single_precision ? n : 0, &floats);
}

MatXX CouplingBlocks::Block(int begin, int rows, int columns) const {
  if (single_precision) return Eigen::Map<const Eigen::MatrixXf>(&floats[begin], rows, columns).cast<double>();
  return Eigen::Map<const MatXX>(&doubles[begin], rows, columns);
}

}  // namespace ch5
