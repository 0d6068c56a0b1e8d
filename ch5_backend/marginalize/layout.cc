#include "ch5_backend/marginalize/layout.h"

#include <algorithm>
#include <stdexcept>

namespace ch5 {
namespace {

using Vertices = std::vector<std::shared_ptr<Vertex>>;

// Numbers vertices 0, 1, … as they appear. A hash table with open addressing, since it is asked once per edge and vertex.
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
  // The slot that holds the vertex, or the free one for it. slots_.size() is a power of two; Knuth's factor mixes the
  // bits of the address.
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

// By id; vertices outside of a graph keep their order: the result must not depend on addresses.
void SortById(Vertices* vertices) {
  std::stable_sort(vertices->begin(), vertices->end(), [](const auto& a, const auto& b) { return a->Id() < b->Id(); });
}

class LayoutBuilder {
 public:
  Layout Build(const std::vector<std::shared_ptr<Edge>>& edges, const Vertices& drop) {
    ClassifyVertices(edges, drop);
    AssignColumns();
    for (const auto& edge : edges) AddEdge(edge.get());
    return std::move(layout_);
  }

 private:
  // Fills kept, dropped and landmarks with the free vertices of the edges, and vertex_numbers_.
  void ClassifyVertices(const std::vector<std::shared_ptr<Edge>>& edges, const Vertices& drop) {
    for (const auto& vertex : drop) numbers_.Of(vertex.get());
    const int num_drop = numbers_.Size();
    std::vector<char> seen(static_cast<size_t>(num_drop), false);
    for (const auto& edge : edges) {
      for (const auto& vertex : edge->Vertices()) {
        const int number = numbers_.Of(vertex.get());
        vertex_numbers_.push_back(number);
        if (number >= static_cast<int>(seen.size())) seen.push_back(false);
        if (vertex->IsFixed() || seen[number]) continue;
        seen[number] = true;
        const bool is_dropped = number < num_drop, is_landmark = is_dropped && vertex->GetRole() == Role::kLandmark;
        (is_landmark ? layout_.landmarks : is_dropped ? layout_.dropped : layout_.kept).push_back(vertex);
      }
    }
  }

  void AssignColumns() {
    column_.assign(static_cast<size_t>(numbers_.Size()), Layout::kFixed);
    landmark_.assign(static_cast<size_t>(numbers_.Size()), -1);
    for (Vertices* vertices : {&layout_.kept, &layout_.dropped, &layout_.landmarks}) SortById(vertices);
    for (const Vertices* vertices : {&layout_.kept, &layout_.dropped}) {
      for (const auto& vertex : *vertices) {
        column_[numbers_.Of(vertex.get())] = layout_.size;
        layout_.size += vertex->LocalDimension();
      }
      if (vertices == &layout_.kept) layout_.kept_size = layout_.size;
    }
    for (size_t l = 0; l < layout_.landmarks.size(); ++l) {
      const int number = numbers_.Of(layout_.landmarks[l].get());
      column_[number] = Layout::kLandmark;
      landmark_[number] = static_cast<int>(l);
    }
    layout_.columns.reserve(vertex_numbers_.size());
    layout_.landmark_edges.resize(layout_.landmarks.size());
  }

  void AddEdge(Edge* edge) {
    const size_t first = layout_.columns.size();
    int landmark = -1;
    for (size_t i = 0; i < edge->Vertices().size(); ++i) {
      const int number = vertex_numbers_[first + i];
      layout_.columns.push_back(column_[number]);
      if (landmark_[number] < 0) continue;
      if (landmark >= 0) {
        throw std::invalid_argument("Marginalize: " + edge->TypeInfo() + " connects two dropped landmarks");
      }
      landmark = landmark_[number];
    }
    (landmark < 0 ? layout_.dense_edges : layout_.landmark_edges[static_cast<size_t>(landmark)])
        .push_back({edge, first});
  }

  Layout layout_;
  VertexTable numbers_;
  std::vector<int> vertex_numbers_;     // of the vertices of all edges, edge by edge
  std::vector<int> column_, landmark_;  // by number: the entry for Layout::columns; index of a dropped landmark or −1
};

}  // namespace

Layout MakeLayout(const std::vector<std::shared_ptr<Edge>>& edges, const Vertices& drop) {
  return LayoutBuilder().Build(edges, drop);
}

}  // namespace ch5
