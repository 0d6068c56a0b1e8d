#pragma once
/// The scene of stage 7.

#include <memory>
#include <vector>

#include "ch5_homework/judge/scenes.h"
#include "ch5_homework/judge/submission.h"

namespace ch5::homework {

using Points = std::vector<std::shared_ptr<VertexPointXYZ>>;
using Poses = std::vector<std::shared_ptr<VertexPose>>;

// The student's solver; this is where BuildStructure runs.
inline std::unique_ptr<PlainBlockSolver> MakeSolver(Graph* graph) {
  auto solver = Chosen().make_block_solver(graph);
  solver->SetOrdering();
  return solver;
}

// Five poses; point k is seen by poses k and k + 1, the last point by poses 4, 2 and 0, in this order. Every vertex has
// an edge of its own, so that H is positive definite.
struct Row {
  Graph graph;
  Poses poses;
  Points points;

  explicit Row(bool fix_one = false) {
    Random random(Seed(71));
    points = AddPoints(&graph, 5);  // smaller ids than the poses, later rows
    poses = AddPoses(&graph, 5);
    poses[1]->SetFixed(fix_one);
    for (const auto& pose : poses) AddRandomEdge<6>(&graph, &random, pose);
    for (const auto& point : points) AddRandomEdge<3>(&graph, &random, point);
    for (size_t k = 0; k < 4; ++k) {
      AddRandomEdge<2>(&graph, &random, points[k], poses[k + 1]);
      AddRandomEdge<2>(&graph, &random, poses[k], points[k]);
    }
    for (const size_t i : {4u, 2u, 0u}) AddRandomEdge<2>(&graph, &random, points[4], poses[i]);
    AddRandomEdge<3>(&graph, &random, poses[0], poses[3]);  // an edge of two poses, the earlier one first
  }
};

}  // namespace ch5::homework
