/// Small graphs of random edges: stages 1.1, 1.2, 5 and 7.

#include "ch5_homework/judge/scenes/scene.h"

namespace ch5::homework {
namespace {

// ---- stage 1.1 -------------------------------------------------------------------------------------------------------

void OneEdge(GraphScene* s) {
  s->poses = AddPoses(&s->graph, 2);
  AddRandomEdge<4>(&s->graph, &s->random, s->poses[0], s->poses[1]);
}

void OnePair(GraphScene* s) {
  const auto& poses = s->poses = AddPoses(&s->graph, 3);
  for (int k = 0; k < 3; ++k) AddRandomEdge<4>(&s->graph, &s->random, poses[0], poses[2]);
  AddRandomEdge<6>(&s->graph, &s->random, poses[2], poses[0]);  // the vertices in the other order
  AddRandomEdge<6>(&s->graph, &s->random, poses[1]);
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
    for (const auto& pose : poses) AddRandomEdge<2>(&s->graph, &s->random, point, pose);
  }
  AddRandomEdge<2>(&s->graph, &s->random, poses[1], points[1]);
  AddRandomEdge<2>(&s->graph, &s->random, depths[0], poses[0], poses[2], poses[1]);
}

void FixedVertices(GraphScene* s) {
  const auto& poses = s->poses = AddPoses(&s->graph, 4);
  const auto& points = s->points = AddPoints(&s->graph, 3);
  poses[0]->SetFixed();
  poses[2]->SetFixed();
  points[1]->SetFixed();
  for (const auto& point : points) {
    for (const auto& pose : poses) AddRandomEdge<2>(&s->graph, &s->random, point, pose);
  }
  AddRandomEdge<6>(&s->graph, &s->random, poses[3], poses[0], poses[1]);
}

// On edges of each kind, beside others without a loss.
void CauchyLosses(GraphScene* s) {
  const auto& poses = s->poses = AddPoses(&s->graph, 3);
  s->points = AddPoints(&s->graph, 2);
  const auto depths = AddInverseDepths(&s->graph, 2);
  poses[2]->SetFixed();
  for (const auto& point : s->points) {
    for (const auto& pose : poses) AddRandomEdge<2>(&s->graph, &s->random, point, pose);
  }
  for (const auto& depth : depths) {
    AddRandomEdge<2>(&s->graph, &s->random, depth, poses[0], poses[1]);
    AddRandomEdge<2>(&s->graph, &s->random, depth, poses[2], poses[1]);
  }
  dynamic_cast<Enlarged&>(*s->graph.Edges().back()).Enlarge(20.0);  // an outlier counts, a little
  AddRandomEdge<6>(&s->graph, &s->random, poses[1], poses[0]);
  AddRandomEdge<6>(&s->graph, &s->random, poses[0]);
  for (const auto& edge : s->graph.Edges()) edge->SetLossFunction(std::make_shared<CauchyLoss>(kCauchyScale));
  AddRandomEdge<6>(&s->graph, &s->random, poses[1]);
  AddRandomEdge<2>(&s->graph, &s->random, depths[0], poses[1], poses[0]);
}

// ---- stage 1.2 -------------------------------------------------------------------------------------------------------

// So many points, poses, inverse depths and again points, with an edge each.
void EdgesOfOneVertex(GraphScene* s) {
  AddPoints(&s->graph, s->GetSizes().at(0));
  AddPoses(&s->graph, s->GetSizes().at(1));
  AddInverseDepths(&s->graph, s->GetSizes().at(2));
  AddPoints(&s->graph, s->GetSizes().at(3));
  for (const auto& vertex : s->graph.Vertices()) {
    if (auto pose = std::dynamic_pointer_cast<VertexPose>(vertex)) AddRandomEdge<1>(&s->graph, &s->random, pose);
    if (auto depth = std::dynamic_pointer_cast<VertexInverseDepth>(vertex)) {
      AddRandomEdge<1>(&s->graph, &s->random, depth);
    }
    if (auto point = std::dynamic_pointer_cast<VertexPointXYZ>(vertex)) {
      AddRandomEdge<1>(&s->graph, &s->random, point);
    }
  }
}

// ---- stage 5 ---------------------------------------------------------------------------------------------------------

// Vertices in this order: 3 poses, 2 points, 2 inverse depths.
void PosesAndLandmarks(GraphScene* s) {
  const auto& poses = s->poses = AddPoses(&s->graph, 3);
  s->points = AddPoints(&s->graph, 2);
  const auto depths = AddInverseDepths(&s->graph, 2);
  for (const auto& pose : poses) {
    for (const auto& point : s->points) AddRandomEdge<4>(&s->graph, &s->random, point, pose);
  }
  for (const auto& depth : depths) AddRandomEdge<2>(&s->graph, &s->random, depth, poses[0], poses[2]);
  AddRandomEdge<6>(&s->graph, &s->random, poses[0], poses[1]);
}

// ---- stage 7 ---------------------------------------------------------------------------------------------------------

// Its residual is zero, its Jacobians are not.
struct FittingEdge : RandomEdge<3, VertexPose, VertexPose> {
  FittingEdge(Random* random, std::shared_ptr<VertexPose> a, std::shared_ptr<VertexPose> b)
      : RandomEdge(random, std::move(a), std::move(b)) {
    right_r_.setZero();
  }
};

// Five poses; point k is seen by poses k and k + 1, the last point by poses 4, 2 and 0, in this order. Every vertex has
// an edge of its own, so that H is positive definite.
void Row(GraphScene* s) {
  const auto& points = s->points = AddPoints(&s->graph, 5);  // smaller ids than the poses, later rows
  const auto& poses = s->poses = AddPoses(&s->graph, 5);
  poses[1]->SetFixed(s->GetSizes().at(0) > 0);
  for (const auto& pose : poses) AddRandomEdge<6>(&s->graph, &s->random, pose);
  for (const auto& point : points) AddRandomEdge<3>(&s->graph, &s->random, point);
  for (size_t k = 0; k < 4; ++k) {
    AddRandomEdge<2>(&s->graph, &s->random, points[k], poses[k + 1]);
    AddRandomEdge<2>(&s->graph, &s->random, poses[k], points[k]);
  }
  AddRandomEdge<2>(&s->graph, &s->random, points[3], poses[0]);  // three poses, two of them neighbors
  for (const size_t i : {4u, 2u, 0u}) AddRandomEdge<2>(&s->graph, &s->random, points[4], poses[i]);
  s->graph.AddEdge(
      std::make_shared<FittingEdge>(&s->random, poses[0], poses[3]));  // of two poses, the earlier one first
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
    dynamic_cast<Enlarged&>(*edge).Enlarge(1e6);
  }
}

void WithoutLandmarks(GraphScene* s) {
  s->poses = AddPoses(&s->graph, 3);
  for (const auto& pose : s->poses) AddRandomEdge<6>(&s->graph, &s->random, pose);
  AddRandomEdge<2>(&s->graph, &s->random, s->poses[2], s->poses[0]);
}

void MixedLandmarks(GraphScene* s) {
  const auto& poses = s->poses = AddPoses(&s->graph, 3);
  const auto depths = AddInverseDepths(&s->graph, 3);
  s->points = AddPoints(&s->graph, 2);
  for (const auto& depth : depths) {
    AddRandomEdge<2>(&s->graph, &s->random, depth, poses[0], poses[2]);
    AddRandomEdge<2>(&s->graph, &s->random, poses[2], depth, poses[1]);  // the later pose first
    s->graph.Edges().back()->SetLossFunction(std::make_shared<CauchyLoss>(kCauchyScale));
  }
  for (const auto& point : s->points) AddRandomEdge<2>(&s->graph, &s->random, poses[1], point);
  s->graph.Edges().back()->SetLossFunction(std::make_shared<CauchyLoss>(kCauchyScale));
  AddRandomEdge<2>(&s->graph, &s->random, poses[2], poses[0]);
  s->graph.Edges().back()->SetLossFunction(std::make_shared<CauchyLoss>(kCauchyScale));
}

// A speed with its biases, nine rows, between poses of six. Every vertex has an edge of its own.
void PosesOfTwoSizes(GraphScene* s) {
  s->poses = AddPoses(&s->graph, 1);
  const auto speed = AddVertices<VertexSpeedBias>(&s->graph, 1, [] { return std::make_shared<VertexSpeedBias>(); })[0];
  for (const auto& pose : AddPoses(&s->graph, 2)) s->poses.push_back(pose);
  s->points = AddPoints(&s->graph, 2);
  AddRandomEdge<9>(&s->graph, &s->random, speed);
  for (const auto& pose : s->poses) AddRandomEdge<6>(&s->graph, &s->random, pose);
  for (const auto& point : s->points) {
    AddRandomEdge<3>(&s->graph, &s->random, point);
    for (const auto& pose : s->poses) AddRandomEdge<2>(&s->graph, &s->random, pose, point);
  }
  AddRandomEdge<6>(&s->graph, &s->random, s->poses[0], speed, s->poses[1]);
}

[[maybe_unused]] const bool added = GraphScene::Add({{"one edge", &OneEdge, 11},
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
