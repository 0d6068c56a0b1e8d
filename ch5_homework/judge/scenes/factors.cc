#include "ch5_homework/judge/scenes/factors.h"

namespace ch5::homework {

AgedRandomEdge::AgedRandomEdge(int rows, Random* random, VertexList vertices)
    : RandomEdge(rows, random, std::move(vertices)), right_J_(J_) {
  r_ = RandomMatrix(rows, 1, random);
  for (MatXX& J : J_) {
    const MatXX old = RandomMatrix(rows, static_cast<int>(J.cols()), random);
    J = old;  // copied: the edge knows where it lies
  }
}

void AgedRandomEdge::ComputeJacobians() {
  for (size_t i = 0; i < J_.size(); ++i) J_[i] = right_J_[i];
}

int AgedRandomEdge::Fresh() const { return (r_ == right_r_ ? kResidual : 0) | (J_ == right_J_ ? kJacobians : 0); }

[[maybe_unused]] static const bool added = Scene::Add("factors", [](const std::string&, const Scene::Sizes& sizes) {
  return std::unique_ptr<Scene>(new FactorGraph(static_cast<FactorGraph::Kind>(sizes.at(0))));
});

FactorGraph::FactorGraph(Kind kind) : Scene("factors", {kind}) {
  Random random(Seed(67));
  Graph* graph = &graph_;
  const auto p = AddPoses(graph, 4);
  const auto speed_bias = AddVertices<VertexSpeedBias>(graph, 1, [] { return std::make_shared<VertexSpeedBias>(); });
  const auto d = AddInverseDepths(graph, 4);
  for (const auto& pose : p) pose->Plus(RandomMatrix(6, 1, &random).data());
  fixed = p[3];
  fixed->SetFixed();
  const auto cauchy = kind == kRobust ? std::make_shared<CauchyLoss>(kCauchyScale) : nullptr;
  AddFactor(6, &random, {1}, cauchy, {p[0], p[1]});
  if (kind == kOneEdge) return;
  // More rows than the speed-bias has: as many would be nearly singular for one seed in a hundred.
  AddFactor(12, &random, {2, 1}, nullptr, {p[2], speed_bias[0], p[1]});
  AddFactor(2, &random, {1}, cauchy, {d[0], p[1], p[2], p[3]});
  AddFactor(2, &random, {3, 0}, cauchy, {d[2], p[3], p[0], p[1], d[3]});  // d[3] is nowhere else, behind the fixed one
  AddFactor(2, &random, {0}, cauchy, {d[2], p[2]});                       // d[2] comes first wherever it is dropped
  AddFactor(3, &random, {}, cauchy, {p[0], d[1]}).Enlarge(20.0);          // drops nothing; an outlier counts, a little
  AddFactor(3, &random, {1}, nullptr, {d[1], p[1]}).Enlarge(0.0);
  std::sort(free.begin(), free.end(), [](const auto& a, const auto& b) { return a->Id() < b->Id(); });
}

EdgeList FactorGraph::Edges() {
  EdgeList edges;
  for (const auto& factor : factors) edges.push_back(factor.edge);
  return edges;
}

RandomEdge& FactorGraph::AddFactor(int rows, Random* random, std::vector<int> drop_set,
                                   std::shared_ptr<const LossFunction> loss, VertexList vertices) {
  auto edge = std::make_shared<AgedRandomEdge>(rows, random, std::move(vertices));
  edge->SetLossFunction(std::move(loss));
  for (const auto& vertex : edge->Vertices()) {
    if (!vertex->IsFixed() && std::find(free.begin(), free.end(), vertex) == free.end()) free.push_back(vertex);
  }
  for (const int position : drop_set) dropped_.push_back(edge->Vertices()[static_cast<size_t>(position)]);
  factors.push_back({edge, std::move(drop_set)});
  return *edge;
}

}  // namespace ch5::homework
