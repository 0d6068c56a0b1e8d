#include "ch5_backend/initialize/incremental.h"

#include <algorithm>
#include <vector>

#include "ch5_backend/initialize/landmark_places.h"
#include "ch5_backend/sparse/sparse_optimizer.h"
#include "ch5_backend/types/pose_graph/as_transform.h"

namespace ch5 {
namespace {

using EdgePointer = std::shared_ptr<Edge>;

class Walk {
 public:
  Walk(Graph* graph, int threads) : graph_(*graph), optimizer_(graph, threads) {
    optimizer_.SetDamping(Damping::kDiagonal);
    edges_.resize(graph->Vertices().empty() ? 0 : graph->Vertices().back()->Id() + 1);
    is_placed_.resize(edges_.size(), false);
    for (const auto& edge : graph->Edges()) {
      for (const auto& vertex : edge->Vertices()) edges_[vertex->Id()].push_back(edge);
    }
    for (const auto& vertex : graph->Vertices()) {
      if (vertex->IsFixed()) Take(vertex);
    }
  }

  void Go() {
    constexpr size_t kLeast = 10, kShare = 50;
    size_t solved = placed_.size();
    for (const auto& vertex : graph_.Vertices()) {
      if (!PoseOf(*vertex)) continue;
      if (!vertex->IsFixed()) PlacePose(vertex);
      PlaceNewLandmarks(*vertex);
      if (placed_.size() < solved + std::max(kLeast, solved / kShare)) continue;
      Solve(3);
      solved = placed_.size();
    }
    Solve(20);
  }

 private:
  void Take(const std::shared_ptr<Vertex>& vertex) {
    is_placed_[vertex->Id()] = true;
    placed_.push_back(vertex);
  }

  void PlacePose(const std::shared_ptr<Vertex>& pose) {
    int last = -1;
    for (const EdgePointer& edge : edges_[pose->Id()]) {
      const std::optional<Transform> T_i_j = MeasurementOf(*edge);
      if (!T_i_j) continue;
      const bool is_second = edge->Vertices()[1] == pose;
      const Vertex& other = *edge->Vertices()[is_second ? 0 : 1];
      if (!is_placed_[other.Id()] || other.Id() <= last) continue;
      last = other.Id();
      MoveTo(*PoseOf(other) * (is_second ? *T_i_j : Inverse(*T_i_j)), pose.get());
    }
    Take(pose);
  }

  void PlaceNewLandmarks(const Vertex& pose) {
    for (const EdgePointer& edge : edges_[pose.Id()]) {
      if (MeasurementOf(*edge) || edge->Vertices().size() < 2) continue;
      const std::shared_ptr<Vertex>& landmark = edge->Vertices()[1];
      if (is_placed_[landmark->Id()] || edge->Vertices()[0].get() != &pose) continue;
      PlaceLandmark({edge}, landmark.get());
      Take(landmark);
    }
  }

  void Solve(int iterations) {
    SolveOptions options;
    options.max_iterations = iterations;
    options.cost_tolerance = 1e-6;
    if (optimizer_.InitializeOptimization(placed_)) optimizer_.Solve(options);
  }

  Graph& graph_;
  SparseOptimizer optimizer_;
  std::vector<std::vector<EdgePointer>> edges_;  // by the ids of their vertices
  std::vector<bool> is_placed_;                  // by id
  std::vector<std::shared_ptr<Vertex>> placed_;
};

}  // namespace

void PlaceIncrementally(Graph* graph, int threads) { Walk(graph, threads).Go(); }

}  // namespace ch5
