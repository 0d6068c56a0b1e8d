#include "ch5_backend/sparse/steps/numeric_edges.h"

#include <cstdint>
#include <typeindex>
#include <unordered_map>

namespace ch5 {
namespace {

constexpr int kEdges = 8;  // a task's
constexpr size_t kBits = 64;

// The colors that one vertex has: a bit each.
using Colors = Array<uint64_t>;

size_t FirstFreeColor(const Array<Colors*>& taken) {
  for (size_t word = 0;; ++word) {
    uint64_t bits = 0;
    for (const Colors* colors : taken) bits |= word < colors->size() ? (*colors)[word] : 0;
    if (~bits != 0) return kBits * word + static_cast<size_t>(__builtin_ctzll(~bits));
  }
}

void Take(size_t color, Colors* colors) {
  colors->resize(std::max(colors->size(), color / kBits + 1));
  (*colors)[color / kBits] |= uint64_t{1} << color % kBits;
}

}  // namespace

void NumericEdges::Find(int first, Structure* structure) {
  colors_.clear();
  std::unordered_map<std::type_index, bool> is_numeric;
  std::unordered_map<const Vertex*, Colors> taken;
  for (int e = first; e < structure->num_active_edges; ++e) {
    EdgeRecord& record = structure->edges[e];
    const auto [type, is_new] = is_numeric.try_emplace(typeid(*record.edge));
    if (is_new) {
      record.edge->Linearize();
      type->second = record.edge->HasNumericJacobians();
    }
    record.is_numeric = type->second;
    if (!record.is_numeric) continue;
    Array<Colors*> of_vertices;
    for (const auto& vertex : record.edge->Vertices()) of_vertices.push_back(&taken[vertex.get()]);
    const size_t color = FirstFreeColor(of_vertices);
    for (Colors* colors : of_vertices) Take(color, colors);
    colors_.resize(std::max(colors_.size(), color + 1));
    colors_[color].push_back(record.edge);
  }
}

void NumericEdges::Linearize(ThreadPool* pool) const {
  for (const Array<Edge*>& color : colors_) {
    ParallelFor(pool, static_cast<int>(color.size()), kEdges, [&](int begin, int end) {
      for (int i = begin; i < end; ++i) color[static_cast<size_t>(i)]->Linearize();
    });
  }
}

}  // namespace ch5
