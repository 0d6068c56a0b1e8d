#include "ch5_backend/initialize/spanning_tree.h"

#include <deque>
#include <functional>

#include "ch5_backend/types/pose_graph/as_transform.h"

namespace ch5 {
namespace {

using VertexPointer = std::shared_ptr<Vertex>;

// An edge on the way from one pose to another.
struct Step {
  VertexPointer from, to;
  Transform T_from_to;
  bool is_odometry;
  const Edge* edge;
};

// The steps from each pose, by its place among the graph's vertices.
std::vector<std::vector<Step>> FindSteps(const Graph& graph) {
  std::vector<std::vector<Step>> steps(graph.Vertices().size());
  const std::vector<int> number = NumberPoses(graph);
  for (const auto& edge : graph.Edges()) {
    const std::optional<Transform> T_i_j = MeasurementOf(*edge);
    if (!T_i_j) continue;
    const VertexPointer &i = edge->Vertices()[0], &j = edge->Vertices()[1];
    const size_t from = graph.PositionOf(*i), to = graph.PositionOf(*j);
    const bool is_odometry = std::abs(number[to] - number[from]) == 1;
    steps[from].push_back({i, j, *T_i_j, is_odometry, edge.get()});
    steps[to].push_back({j, i, Inverse(*T_i_j), is_odometry, edge.get()});
  }
  return steps;
}

// Prim's algorithm where edges have one of two lengths, so that a queue with two ends keeps them in order.
// @param place  called once for each pose that a step leads to
// @return the poses that none leads to
std::vector<VertexPointer> Walk(const Graph& graph, TreeOrder order, const std::function<void(const Step&)>& place) {
  const std::vector<std::vector<Step>> steps = FindSteps(graph);
  std::vector<bool> visited(steps.size(), false);
  std::deque<const Step*> next;
  const auto visit = [&](const VertexPointer& vertex) {
    visited[graph.PositionOf(*vertex)] = true;
    int num_first = 0;  // of two measured steps between neighbors, the one that the file has first is odometry
    for (const Step& step : steps[graph.PositionOf(*vertex)]) {
      const bool first = order == TreeOrder::kOdometryFirst && step.is_odometry;
      next.insert(first ? next.begin() + num_first++ : next.end(), &step);
    }
  };
  const auto follow = [&] {
    while (!next.empty()) {
      const Step& step = *next.front();
      next.pop_front();
      if (visited[graph.PositionOf(*step.to)]) continue;
      place(step);
      visit(step.to);
    }
  };
  std::vector<VertexPointer> roots;
  const auto begin_at = [&](const VertexPointer& vertex) {
    const size_t position = graph.PositionOf(*vertex);
    if (visited[position] || steps[position].empty()) return;
    roots.push_back(vertex);
    visit(vertex);
  };
  for (const VertexPointer& vertex : graph.Vertices()) {
    if (vertex->IsFixed()) begin_at(vertex);
  }
  for (const VertexPointer& vertex : graph.Vertices()) {
    follow();
    begin_at(vertex);
  }
  follow();
  return roots;
}

}  // namespace

std::vector<int> NumberPoses(const Graph& graph) {
  std::vector<int> numbers;
  int next = 0;
  for (const VertexPointer& vertex : graph.Vertices()) numbers.push_back(PoseOf(*vertex) ? next++ : next);
  return numbers;
}

std::vector<VertexPointer> FindRoots(const Graph& graph) {
  return Walk(graph, TreeOrder::kBreadthFirst, [](const Step&) {});
}

std::vector<const Edge*> TreeEdges(TreeOrder order, const Graph& graph) {
  std::vector<const Edge*> edges;
  Walk(graph, order, [&](const Step& step) { edges.push_back(step.edge); });
  return edges;
}

void PlaceAlongTree(TreeOrder order, Graph* graph) {
  Walk(*graph, order, [](const Step& step) { MoveTo(*PoseOf(*step.from) * step.T_from_to, step.to.get()); });
}

}  // namespace ch5
