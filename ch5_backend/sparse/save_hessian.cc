#include "ch5_backend/sparse/save_hessian.h"

#include <algorithm>
#include <cstdio>
#include <tuple>

namespace ch5 {
namespace {

using Entry = std::tuple<int, int, double>;  // column, row, value

std::vector<Entry> EntriesOf(const Structure& s, const Linearized& system) {
  std::vector<Entry> entries;
  system.ForEachBlock(s, [&](int row, int column, const auto& block) {
    for (int c = 0; c < block.cols(); ++c) {
      for (int r = 0; r < block.rows(); ++r) {
        const double value = block(r, c);
        if (value == 0.0) continue;
        entries.emplace_back(column + c, row + r, value);
        if (row != column) entries.emplace_back(row + r, column + c, value);
      }
    }
  });
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
