#include "ch5_backend/marginalize/moved_vertices.h"

namespace ch5 {

MovedVertices::MovedVertices(const Prior* prior) {
  for (size_t i = 0; prior && i < prior->vertices.size(); ++i) Move(prior->vertices[i].get(), prior->x0[i]);
}

MovedVertices::~MovedVertices() {
  for (auto it = before_.rbegin(); it != before_.rend(); ++it) it->first->Parameters() = it->second;
}

void MovedVertices::Move(Vertex* vertex, const VecX& x) {
  before_.emplace_back(vertex, vertex->Parameters());
  vertex->Parameters() = x;
}

}  // namespace ch5
