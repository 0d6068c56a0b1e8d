#include "ch5_backend/initialize/initialize_pose_graph.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "ch5_backend/initialize/chordal.h"
#include "ch5_backend/initialize/incremental.h"
#include "ch5_backend/initialize/landmark_places.h"
#include "ch5_backend/initialize/spanning_tree.h"

namespace ch5 {

void InitializePoseGraph(PoseGraphStart start, Graph* graph, int threads) {
  if (!graph) throw GraphError("InitializePoseGraph: the graph is null");
  switch (start) {
    case PoseGraphStart::kGiven: return;
    case PoseGraphStart::kOdometry: PlaceAlongTree(TreeOrder::kOdometryFirst, graph); break;
    case PoseGraphStart::kSpanningTree: PlaceAlongTree(TreeOrder::kBreadthFirst, graph); break;
    case PoseGraphStart::kChordal: PlaceByChordalRelaxation(graph, threads); break;
    case PoseGraphStart::kIncremental: PlaceIncrementally(graph, threads); break;
  }
  if (start != PoseGraphStart::kIncremental) PlaceLandmarks(graph);
}

std::vector<double> InitializeAtLeastCost(const std::vector<PoseGraphStart>& starts, Graph* graph, int threads) {
  if (!graph) throw GraphError("InitializeAtLeastCost: the graph is null");
  std::vector<double> costs;
  graph->Push();
  const auto start_again = [&](PoseGraphStart start) {
    graph->Pop();
    graph->Push();
    InitializePoseGraph(start, graph, threads);
  };
  for (const PoseGraphStart start : starts) {
    start_again(start);
    const double cost = Cost(*graph);
    costs.push_back(std::isfinite(cost) ? cost : std::numeric_limits<double>::infinity());
  }
  const size_t best = std::min_element(costs.begin(), costs.end()) - costs.begin();
  if (best + 1 < starts.size()) start_again(starts[best]);  // the last one is still there
  graph->DiscardTop();
  return costs;
}

}  // namespace ch5
