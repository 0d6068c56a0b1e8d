/// Small graphs of random edges: stages 1.1, 1.2, 5 and 7.

#include "ch5_backend/graph/sized_edge.h"
#include "ch5_homework/judge/scenes/scene.h"

namespace ch5::homework {
namespace {

// ---- stage 1.1 -------------------------------------------------------------------------------------------------------

void OneEdge(GraphScene* s) {
  s->poses = AddPoses(&s->graph, 2);
  s->AddRandomEdge(4, {s->poses[0], s->poses[1]});
}

void OnePair(GraphScene* s) {
  const auto& poses = s->poses = AddPoses(&s->graph, 3);
  for (int k = 0; k < 3; ++k) s->AddRandomEdge(4, {poses[0], poses[2]});
  s->AddRandomEdge(6, {poses[2], poses[0]});  // the vertices in the other order
  s->AddRandomEdge(6, {poses[1]});
}

class Difference : public SizedEdge<1, VertexScalar, VertexScalar> {
 public:
  Difference(std::shared_ptr<VertexScalar> a, std::shared_ptr<VertexScalar> b, double sigma)
      : SizedEdge(std::move(a), std::move(b)) {
    SetInformation(MatXX::Constant(1, 1, 1.0 / (sigma * sigma)));
  }
  void ComputeResidual() override {
    r_ = GetVertex<1>().GetEstimate() - GetVertex<0>().GetEstimate();
    r_[0] -= 1.0;
  }
  void ComputeJacobians() override {
    J<0>()(0) = -1.0;
    J<1>()(0) = 1.0;
  }
  std::string TypeInfo() const override { return "Difference"; }
};

void Chain(GraphScene* s) {
  const auto x = AddVertices<VertexScalar>(&s->graph, 4,
                                           [] { return std::make_shared<VertexScalar>(VertexScalar::Estimate(0.0)); });
  x[3]->SetFixed();  // the origin, from which x_1 is measured with σ = 0.2
  x[2]->SetEstimate(
      VertexScalar::Estimate(1.0));  // fits the last measurement, whose part of H is the same nevertheless
  s->graph.AddEdge(std::make_shared<Difference>(x[0], x[1], 0.1));
  s->graph.AddEdge(std::make_shared<Difference>(x[3], x[1], 0.2));
  s->graph.AddEdge(std::make_shared<Difference>(x[1], x[2], 0.3));
}

void PointsAndADepth(GraphScene* s) {
  const auto& points = s->points = AddPoints(&s->graph, 2);  // smaller ids than the poses, later rows
  const auto& poses = s->poses = AddPoses(&s->graph, 3);
  const auto depths = AddInverseDepths(&s->graph, 1);
  for (const auto& point : points) {
    for (const auto& pose : poses) s->AddRandomEdge(2, {point, pose});
  }
  s->AddRandomEdge(2, {poses[1], points[1]});
  s->AddRandomEdge(2, {depths[0], poses[0], poses[2], poses[1]});
}

void FixedVertices(GraphScene* s) {
  const auto& poses = s->poses = AddPoses(&s->graph, 4);
  const auto& points = s->points = AddPoints(&s->graph, 3);
  poses[0]->SetFixed();
  poses[2]->SetFixed();
  points[1]->SetFixed();
  for (const auto& point : points) {
    for (const auto& pose : poses) s->AddRandomEdge(2, {point, pose});
  }
  s->AddRandomEdge(6, {poses[3], poses[0], poses[1]});
}

// On edges of each kind, beside others without a loss.
void CauchyLosses(GraphScene* s) {
  const auto& poses = s->poses = AddPoses(&s->graph, 3);
  s->points = AddPoints(&s->graph, 2);
  const auto depths = AddInverseDepths(&s->graph, 2);
  poses[2]->SetFixed();
  for (const auto& point : s->points) {
    for (const auto& pose : poses) s->AddRandomEdge(2, {point, pose});
  }
  for (const auto& depth : depths) {
    s->AddRandomEdge(2, {depth, poses[0], poses[1]});
    s->AddRandomEdge(2, {depth, poses[2], poses[1]});
  }
  dynamic_cast<RandomEdge&>(*s->graph.Edges().back()).Enlarge(20.0);  // an outlier counts, a little
  s->AddRandomEdge(6, {poses[1], poses[0]});
  s->AddRandomEdge(6, {poses[0]});
  for (const auto& edge : s->graph.Edges()) edge->SetLossFunction(std::make_shared<CauchyLoss>(kCauchyScale));
  s->AddRandomEdge(6, {poses[1]});
  s->AddRandomEdge(2, {depths[0], poses[1], poses[0]});
}

// ---- stage 1.2 -------------------------------------------------------------------------------------------------------

// So many points, poses, inverse depths and again points, with an edge each.
void EdgesOfOneVertex(GraphScene* s) {
  AddPoints(&s->graph, s->GetSizes().at(0));
  AddPoses(&s->graph, s->GetSizes().at(1));
  AddInverseDepths(&s->graph, s->GetSizes().at(2));
  AddPoints(&s->graph, s->GetSizes().at(3));
  for (const auto& vertex : s->graph.Vertices()) s->AddRandomEdge(1, {vertex});
}

// ---- stage 5 ---------------------------------------------------------------------------------------------------------

// Vertices in this order: 3 poses, 2 points, 2 inverse depths.
void PosesAndLandmarks(GraphScene* s) {
  const auto& poses = s->poses = AddPoses(&s->graph, 3);
  s->points = AddPoints(&s->graph, 2);
  const auto depths = AddInverseDepths(&s->graph, 2);
  for (const auto& pose : poses) {
    for (const auto& point : s->points) s->AddRandomEdge(4, {point, pose});
  }
  for (const auto& depth : depths) s->AddRandomEdge(2, {depth, poses[0], poses[2]});
  s->AddRandomEdge(6, {poses[0], poses[1]});
}

// ---- stage 7 ---------------------------------------------------------------------------------------------------------

// Five poses; point k is seen by poses k and k + 1, the last point by poses 4, 2 and 0, in this order. Every vertex has
// an edge of its own, so that H is positive definite.
void Row(GraphScene* s) {
  const auto& points = s->points = AddPoints(&s->graph, 5);  // smaller ids than the poses, later rows
  const auto& poses = s->poses = AddPoses(&s->graph, 5);
  poses[1]->SetFixed(s->GetSizes().at(0) > 0);
  for (const auto& pose : poses) s->AddRandomEdge(6, {pose});
  for (const auto& point : points) s->AddRandomEdge(3, {point});
  for (size_t k = 0; k < 4; ++k) {
    s->AddRandomEdge(2, {points[k], poses[k + 1]});
    s->AddRandomEdge(2, {poses[k], points[k]});
  }
  s->AddRandomEdge(2, {points[3], poses[0]});  // three poses, two of them neighbors
  for (const size_t i : {4u, 2u, 0u}) s->AddRandomEdge(2, {points[4], poses[i]});
  s->AddRandomEdge(3, {poses[0], poses[3]}).Enlarge(0.0);  // of two poses, the earlier one first; J is not zero
}

// A row whose measurements weigh little: small numbers are not to be taken for none.
void LightRow(GraphScene* s) {
  Row(s);
  for (const auto& edge : s->graph.Edges()) edge->SetInformation(1e-9 * edge->Information());
}

// All numbers are large, those of the step too: none may have a limit.
void HeavyRow(GraphScene* s) {
  Row(s);
  for (const auto& edge : s->graph.Edges()) {
    edge->SetInformation(1e9 * edge->Information());
    dynamic_cast<RandomEdge&>(*edge).Enlarge(1e6);
  }
}

void WithoutLandmarks(GraphScene* s) {
  s->poses = AddPoses(&s->graph, 3);
  for (const auto& pose : s->poses) s->AddRandomEdge(6, {pose});
  s->AddRandomEdge(2, {s->poses[2], s->poses[0]});
}

void MixedLandmarks(GraphScene* s) {
  const auto& poses = s->poses = AddPoses(&s->graph, 3);
  const auto depths = AddInverseDepths(&s->graph, 3);
  s->points = AddPoints(&s->graph, 2);
  for (const auto& depth : depths) {
    s->AddRandomEdge(2, {depth, poses[0], poses[2]});
    s->AddRandomEdge(2, {poses[2], depth, poses[1]});  // the later pose first
    s->graph.Edges().back()->SetLossFunction(std::make_shared<CauchyLoss>(kCauchyScale));
  }
  dynamic_cast<RandomEdge&>(*s->graph.Edges().back()).Enlarge(20.0);  // an outlier counts, a little
  for (const auto& point : s->points) s->AddRandomEdge(2, {poses[1], point});
  s->graph.Edges().back()->SetLossFunction(std::make_shared<CauchyLoss>(kCauchyScale));
  s->AddRandomEdge(2, {poses[2], poses[0]});
  s->graph.Edges().back()->SetLossFunction(std::make_shared<CauchyLoss>(kCauchyScale));
}

// A speed with its biases, nine rows, between poses of six. Every vertex has an edge of its own.
void PosesOfTwoSizes(GraphScene* s) {
  s->poses = AddPoses(&s->graph, 1);
  const auto speed = AddVertices<VertexSpeedBias>(&s->graph, 1, [] { return std::make_shared<VertexSpeedBias>(); })[0];
  for (const auto& pose : AddPoses(&s->graph, 2)) s->poses.push_back(pose);
  s->points = AddPoints(&s->graph, 2);
  s->AddRandomEdge(9, {speed});
  for (const auto& pose : s->poses) s->AddRandomEdge(6, {pose});
  for (const auto& point : s->points) {
    s->AddRandomEdge(3, {point});
    for (const auto& pose : s->poses) s->AddRandomEdge(2, {pose, point});
  }
  s->AddRandomEdge(6, {s->poses[0], speed, s->poses[1]});
}

[[maybe_unused]] const bool graphs_added = GraphScene::Add({{"one edge", &OneEdge, 11},
                                                            {"one pair", &OnePair, 12},
                                                            {"chain", &Chain},
                                                            {"points and a depth", &PointsAndADepth, 14},
                                                            {"fixed vertices", &FixedVertices, 15},
                                                            {"Cauchy losses", &CauchyLosses, 16},
                                                            {"edges of one vertex", &EdgesOfOneVertex, 21},
                                                            {"poses and landmarks", &PosesAndLandmarks, 61},
                                                            {"row", &Row, 71},
                                                            {"light row", &LightRow, 71},
                                                            {"heavy row", &HeavyRow, 71},
                                                            {"without landmarks", &WithoutLandmarks, 72},
                                                            {"mixed landmarks", &MixedLandmarks, 73},
                                                            {"poses of two sizes", &PosesOfTwoSizes, 75}});

}  // namespace
}  // namespace ch5::homework
