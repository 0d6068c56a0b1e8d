#include "ch5_backend/sparse/save_hessian.h"

#include <algorithm>
#include <cstdio>
#include <tuple>

namespace ch5 {
namespace {

using Entry = std::tuple<int, int, double>;  // column, row, value

std::vector<Entry> EntriesOf(const Structure& s, const Linearized& system) {
  std::vector<Entry> entries;
  // A block of `values` with `stride` numbers from column to column, and its mirror image if it is off the diagonal.
  const auto add = [&](const double* values, int stride, int row, int rows, int column, int columns) {
    for (int c = 0; c < columns; ++c) {
      for (int r = 0; r < rows; ++r) {
        const double value = values[c * stride + r];
        if (value == 0.0) continue;
        entries.emplace_back(column + c, row + r, value);
        if (row != column) entries.emplace_back(row + r, column + c, value);
      }
    }
  };
  const SymmetricBlockMatrix& H_pp = system.H_pp;
  for (int j = 0; j < H_pp.NumColumns(); ++j) {
    for (int block = H_pp.ColumnBegin(j); block < H_pp.ColumnBegin(j + 1); ++block) {
      const int i = H_pp.Row(block), dim = H_pp.Dim(i);
      add(H_pp.Values(block), Stride(dim), H_pp.Offset(i), dim, H_pp.Offset(j), H_pp.Dim(j));
    }
  }
  for (size_t l = 0; l < s.landmarks.size(); ++l) {
    const int dim = s.landmark_dim[l], column = s.landmark_offset[l];
    add(&system.H_ll[s.landmark_block[l]], dim, column, dim, column, dim);
    for (int slot = s.landmark_slots[l]; slot < s.landmark_slots[l + 1]; ++slot) {
      const int p = s.slot_pose[slot];
      add(system.Coupling(s, slot).data(), s.pose_dim[p], s.pose_offset[p], s.pose_dim[p], column, dim);
    }
  }
  std::sort(entries.begin(), entries.end());
  return entries;
}

}  // namespace

void SaveHessian(const SparseSolver& solver, const std::string& name, std::ostream* out) {
  const std::vector<Entry> entries = EntriesOf(solver.GetStructure(), solver.GetLinearized());
  *out << "# name: " << name << "\n# type: sparse matrix\n# nnz: " << entries.size() << "\n# rows: " << solver.Size()
       << "\n# columns: " << solver.Size() << "\n";
  char line[64];
  for (const auto& [column, row, value] : entries) {
    std::snprintf(line, sizeof line, "%d %d %.17g\n", row + 1, column + 1, value);
    *out << line;
  }
}

}  // namespace ch5
