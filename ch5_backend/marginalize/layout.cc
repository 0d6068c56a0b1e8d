#include "ch5_backend/marginalize/layout.h"

#include <algorithm>
#include <stdexcept>

namespace ch5 {
namespace {

using Vertices = std::vector<std::shared_ptr<Vertex>>;

// Numbers vertices 0, 1, … as they appear: a hash table with open addressing, for an edge asks for each of its own.
class VertexTable {
 public:
  int Of(const Vertex* vertex) {
    Slot& slot = Find(vertex);
    if (slot.vertex) return slot.number;
    slot = {vertex, size_++};
    if (2 * static_cast<size_t>(size_) > slots_.size()) Grow();
    return size_ - 1;
  }
  int Size() const { return size_; }

 private:
  struct Slot {
    const Vertex* vertex = nullptr;
    int number = 0;
  };
  // Where the vertex is, or is to be; slots_.size() is a power of two, and Knuth's factor mixes the address' bits.
  Slot& Find(const Vertex* vertex) {
    size_t slot = reinterpret_cast<size_t>(vertex) * 0x9E3779B97F4A7C15u >> 32;
    for (;; ++slot) {
      Slot& found = slots_[slot & (slots_.size() - 1)];
      if (!found.vertex || found.vertex == vertex) return found;
    }
  }
  void Grow() {
    std::vector<Slot> old(4 * slots_.size());
    old.swap(slots_);
    for (const Slot& item : old) {
      if (item.vertex) Find(item.vertex) = item;
    }
  }

  std::vector<Slot> slots_ = std::vector<Slot>(512);
  int size_ = 0;
};

// By id, and those outside of a graph as they come: the result must not depend on addresses.
void SortById(Vertices* vertices) {
  std::stable_sort(vertices->begin(), vertices->end(), [](const auto& a, const auto& b) { return a->Id() < b->Id(); });
}

}  // namespace

Layout MakeLayout(const std::vector<std::shared_ptr<Edge>>& edges, const Vertices& drop) {
  Layout layout;
  VertexTable numbers;
  for (const auto& vertex : drop) numbers.Of(vertex.get());
  const int num_drop = numbers.Size();
  std::vector<int> mentioned;  // the number of each edge's each vertex
  std::vector<char> seen(static_cast<size_t>(num_drop), false);
  for (const auto& edge : edges) {
    for (const auto& vertex : edge->Vertices()) {
      const int number = numbers.Of(vertex.get());
      mentioned.push_back(number);
      if (number >= static_cast<int>(seen.size())) seen.push_back(false);
      if (vertex->IsFixed() || seen[number]) continue;
      seen[number] = true;
      const bool goes = number < num_drop, is_landmark = goes && vertex->GetRole() == Role::kLandmark;
      (is_landmark ? layout.landmarks : goes ? layout.dropped : layout.kept).push_back(vertex);
    }
  }

  std::vector<int> column(seen.size(), Layout::kFixed), owner(seen.size(), -1);
  for (Vertices* vertices : {&layout.kept, &layout.dropped, &layout.landmarks}) SortById(vertices);
  for (const Vertices* vertices : {&layout.kept, &layout.dropped}) {
    for (const auto& vertex : *vertices) {
      column[numbers.Of(vertex.get())] = layout.size;
      layout.size += vertex->LocalDimension();
    }
    if (vertices == &layout.kept) layout.kept_size = layout.size;
  }
  for (size_t l = 0; l < layout.landmarks.size(); ++l) {
    const int number = numbers.Of(layout.landmarks[l].get());
    column[number] = Layout::kLandmark;
    owner[number] = static_cast<int>(l);
  }

  layout.columns.reserve(mentioned.size());
  layout.landmark_edges.resize(layout.landmarks.size());
  for (const auto& edge : edges) {
    const size_t begin = layout.columns.size();
    int landmark = -1;
    for (size_t i = 0; i < edge->Vertices().size(); ++i) {
      const int number = mentioned[begin + i];
      layout.columns.push_back(column[number]);
      if (owner[number] < 0) continue;
      if (landmark >= 0)
        throw std::invalid_argument("Marginalize: " + edge->TypeInfo() + " ties two dropped landmarks");
      landmark = owner[number];
    }
    (landmark < 0 ? layout.dense_edges : layout.landmark_edges[static_cast<size_t>(landmark)])
        .push_back({edge.get(), begin});
  }
  return layout;
}

}  // namespace ch5
