#include "ch5_backend/initialize/incremental.h"

#include <algorithm>
#include <utility>
#include <vector>

#include "ch5_backend/initialize/landmark_places.h"
#include "ch5_backend/sparse/sparse_optimizer.h"
#include "ch5_backend/types/pose_graph/as_transform.h"

namespace ch5 {
namespace {

using EdgePointer = std::shared_ptr<Edge>;

class Walk {
 public:
  explicit Walk(Graph* graph) : graph_(*graph) {
    is_placed_.resize(graph->Vertices().size(), false);
    for (const EdgePointer& edge : graph->Edges()) missing_.push_back(edge->Vertices().size());
    for (const auto& vertex : graph->Vertices()) {
      if (vertex->IsFixed()) Take(vertex);
    }
  }

  /// @param solve  called after each pose
  template <typename Solve>
  void Go(const Solve& solve) {
    for (const auto& vertex : graph_.Vertices()) {
      if (!PoseOf(*vertex)) continue;
      if (!vertex->IsFixed()) PlacePose(vertex);
      PlaceNewLandmarks(*vertex);
      solve();
    }
  }

  const std::vector<std::shared_ptr<Vertex>>& Placed() const { return placed_; }
  /// The edges all of whose vertices have been placed since the last call.
  std::vector<EdgePointer> TakeEdges() { return std::exchange(edges_, {}); }

 private:
  void Take(const std::shared_ptr<Vertex>& vertex) {
    is_placed_[graph_.PositionOf(*vertex)] = true;
    placed_.push_back(vertex);
    for (const EdgePointer& edge : graph_.EdgesOf(*vertex)) {
      if (--missing_[graph_.PositionOf(*edge)] == 0) edges_.push_back(edge);
    }
  }

  void PlacePose(const std::shared_ptr<Vertex>& pose) {
    int last = -1;
    for (const EdgePointer& edge : graph_.EdgesOf(*pose)) {
      const std::optional<Transform> T_i_j = MeasurementOf(*edge);
      if (!T_i_j) continue;
      const bool is_second = edge->Vertices()[1] == pose;
      const Vertex& other = *edge->Vertices()[is_second ? 0 : 1];
      if (!is_placed_[graph_.PositionOf(other)] || other.Id() <= last) continue;
      last = other.Id();
      MoveTo(*PoseOf(other) * (is_second ? *T_i_j : Inverse(*T_i_j)), pose.get());
    }
    Take(pose);
  }

  void PlaceNewLandmarks(const Vertex& pose) {
    for (const EdgePointer& edge : graph_.EdgesOf(pose)) {
      if (MeasurementOf(*edge) || edge->Vertices().size() < 2) continue;
      const std::shared_ptr<Vertex>& landmark = edge->Vertices()[1];
      if (is_placed_[graph_.PositionOf(*landmark)] || edge->Vertices()[0].get() != &pose) continue;
      PlaceLandmark({edge}, landmark.get());
      Take(landmark);
    }
  }

  Graph& graph_;
  std::vector<bool> is_placed_;  // of each of the graph's vertices
  std::vector<size_t> missing_;  // of each of its edges: vertices that are not placed
  std::vector<EdgePointer> edges_;
  std::vector<std::shared_ptr<Vertex>> placed_;
};

}  // namespace

void PlaceIncrementally(Graph* graph, int threads) {
  constexpr size_t kLeast = 10, kShare = 50;
  Walk walk(graph);
  SparseOptimizer optimizer(graph, threads);
  size_t solved = walk.Placed().size();
  const auto solve = [&](int iterations) {
    SolveOptions options;
    options.max_iterations = iterations;
    options.cost_tolerance = 1e-6;
    if (optimizer.InitializeOptimization(walk.Placed())) optimizer.Solve(options);
    solved = walk.Placed().size();
  };
  walk.Go([&] {
    if (walk.Placed().size() >= solved + std::max(kLeast, solved / kShare)) solve(3);
  });
  solve(20);
}

void SolveIncrementally(Graph* graph, int every, const std::function<void(const UpdateSummary&)>& watch,
                        const IncrementalOptions& options) {
  Walk walk(graph);
  IncrementalSmoother smoother(graph, options);
  const auto update = [&] {
    const UpdateSummary summary = smoother.Update(walk.TakeEdges());
    if (watch) watch(summary);
  };
  int poses = 0;
  walk.Go([&] {
    if (++poses % every == 0) update();
  });
  update();
  update();
}

}  // namespace ch5
