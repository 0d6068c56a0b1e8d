#include "tests/linear/block_matrices.h"

#include <Eigen/Cholesky>
#include <algorithm>

#include "ch5_backend/simulate/random.h"

namespace ch5::test {

SymmetricBlockMatrix MakeMatrix(const std::vector<int>& dims, const Ties& ties, uint64_t seed) {
  std::vector<std::vector<int>> rows(dims.size());
  std::vector<double> degree(dims.size(), 1.0);
  for (size_t j = 0; j < dims.size(); ++j) rows[j].push_back(static_cast<int>(j));
  for (const auto& [i, j] : ties) {
    rows[j].push_back(i);
    degree[i] += dims[j];
    degree[j] += dims[i];
  }
  for (auto& column : rows) {
    std::sort(column.begin(), column.end());
    column.erase(std::unique(column.begin(), column.end()), column.end());
  }
  SymmetricBlockMatrix A;
  A.SetPattern(Array<int>(dims.begin(), dims.end()), rows);
  Random random(seed);
  for (int j = 0; j < A.NumColumns(); ++j) {
    for (int block = A.ColumnBegin(j); block < A.ColumnBegin(j + 1); ++block) {
      const int i = A.Row(block), stride = Stride(A.Dim(i));
      for (int c = 0; c < A.Dim(j); ++c) {
        for (int r = i == j ? c : 0; r < A.Dim(i); ++r) {
          const double value = i == j && r == c ? degree[j] + A.Dim(j) : random.Uniform(-1.0, 1.0);
          A.Values(block)[c * stride + r] = value;
          if (i == j) A.Values(block)[r * stride + c] = value;
        }
      }
    }
  }
  return A;
}

Ties Chain(int n) {
  Ties ties;
  for (int i = 1; i < n; ++i) ties.emplace_back(i, i - 1);
  return ties;
}

Ties Grid(int side) {
  Ties ties;
  for (int y = 0; y < side; ++y) {
    for (int x = 0; x < side; ++x) {
      if (x > 0) ties.emplace_back(y * side + x, y * side + x - 1);
      if (y > 0) ties.emplace_back(y * side + x, (y - 1) * side + x);
    }
  }
  return ties;
}

Ties Everything(int n) {
  Ties ties;
  for (int i = 0; i < n; ++i) {
    for (int j = 0; j < i; ++j) ties.emplace_back(i, j);
  }
  return ties;
}

Ties RandomTies(int n, int count, uint64_t seed) {
  Random random(seed);
  Ties ties;
  for (int k = 0; k < count; ++k) {
    const int i = static_cast<int>(random.Uniform(0, n)), j = static_cast<int>(random.Uniform(0, n));
    if (i != j) ties.emplace_back(std::max(i, j), std::min(i, j));
  }
  return ties;
}

std::vector<int> MixedDims(int n) {
  constexpr int kDims[] = {6, 3, 1, 9, 2, 6, 15};
  std::vector<int> dims;
  for (int i = 0; i < n; ++i) dims.push_back(kDims[i % 7]);
  return dims;
}

VecX RandomVector(int n, uint64_t seed) {
  Random random(seed);
  return VecX::NullaryExpr(n, [&] { return random.Normal(); });
}

std::vector<SymmetricBlockMatrix> Matrices() {
  std::vector<SymmetricBlockMatrix> matrices;
  for (const int dim : {1, 3, 6, 9}) {
    matrices.push_back(MakeMatrix(std::vector<int>(1, dim), {}, 1));
    matrices.push_back(MakeMatrix(std::vector<int>(40, dim), Chain(40), 2));
    matrices.push_back(MakeMatrix(std::vector<int>(144, dim), Grid(12), 3));
    matrices.push_back(MakeMatrix(std::vector<int>(30, dim), Everything(30), 4));
  }
  matrices.push_back(MakeMatrix(MixedDims(50), Chain(50), 5));
  matrices.push_back(MakeMatrix(MixedDims(100), Grid(10), 6));
  matrices.push_back(MakeMatrix(MixedDims(80), RandomTies(80, 60, 7), 8));  // several parts, and single blocks
  matrices.push_back(MakeMatrix(MixedDims(60), RandomTies(60, 400, 9), 10));
  return matrices;
}

VecX SolveByEigen(const SymmetricBlockMatrix& A, const VecX& b) { return A.Dense().llt().solve(b); }

}  // namespace ch5::test
