#include "ch5_backend/graph/fast_edge.h"

#include "ch5_backend/math/dense_kernels.h"

namespace ch5 {

bool NegativeProducts(Edge* edge, const std::vector<int>& columns, double* C) {
  FastEdge* fast = AsFast(edge);
  if (!fast) return false;
  size_t n = 1;
  for (const auto& vertex : edge->Vertices()) n += static_cast<size_t>(vertex->LocalDimension());
  thread_local std::vector<double> memory;
  memory.resize(n * n + kernels::kOverread);
  double* own = memory.data();
  if (!fast->NegativeProductsInto(own)) return false;
  // A run of successive numbers (a vertex) does not hold j again: it lies below own's diagonal, or above it.
  const auto size = columns.size();
  for (size_t c = 0; c < size; ++c) {
    const auto j = static_cast<size_t>(columns[c]);
    for (size_t r = c; r < size;) {
      const auto i = static_cast<size_t>(columns[r]);
      const size_t step = i >= j ? 1 : n;
      const double* from = own + (i >= j ? j * n + i : i * n + j);
      double* to = C + c * size;
      do {
        to[r++] = *from;
        from += step;
      } while (r < size && columns[r] == columns[r - 1] + 1);
    }
  }
  return true;
}

}  // namespace ch5
