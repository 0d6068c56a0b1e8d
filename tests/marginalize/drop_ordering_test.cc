#include "ch5_backend/marginalize/drop_ordering.h"

#include <algorithm>

#include "ch5_backend/marginalize/marginalize.h"
#include "tests/marginalize/small_graphs.h"

namespace ch5 {
namespace {

// Frame 0 and its landmarks are dropped: the rows of the kept vertices come first, then those of the dropped, by id.
TEST(DropOrdering, KeptRowsComeFirstThenDroppedOnesInOrderOfIds) {
  const SmallWindow window;
  const auto drop = window.Oldest();
  const DropOrdering order = MakeDropOrdering(window.EdgesAt(drop), drop);
  const std::vector<std::shared_ptr<Vertex>> poses{window.poses[1],       window.speed_biases[1], window.poses[2],
                                                   window.poses[3],       window.extrinsic,       window.poses[0],
                                                   window.speed_biases[0]};
  EXPECT_EQ(order.ordering.poses, poses);
  EXPECT_EQ(order.num_kept, 5);
  EXPECT_EQ(order.ordering.landmarks.size(), 6u);
  EXPECT_EQ(order.kept_size, 6 + 9 + 6 + 6 + 6);
  EXPECT_EQ(order.ordering.dim_poses, order.kept_size + 6 + 9);
  int row = 0;
  for (const auto* vertices : {&order.ordering.poses, &order.ordering.landmarks}) {
    for (const auto& vertex : *vertices) {
      EXPECT_EQ(vertex->OrderingId(), row);
      row += vertex->LocalDimension();
    }
  }
  EXPECT_EQ(row, order.ordering.Size());
}

TEST(DropOrdering, FixedVerticesHaveNoRows) {
  const SmallWindow window;
  window.poses[1]->SetFixed();
  const auto drop = window.Oldest();
  const auto edges = window.EdgesAt(drop);
  const DropOrdering order = MakeDropOrdering(edges, drop);
  EXPECT_EQ(window.poses[1]->OrderingId(), -1);
  EXPECT_EQ(order.num_kept, 4);
  const std::vector<int> landmarks = LandmarkOfEachEdge(order.ordering);
  EXPECT_EQ(std::count(landmarks.begin(), landmarks.end(), -1), 2) << "the prior and the IMU's";
  const Incidence& incidence = order.ordering.incidence;
  for (size_t e = 0; e < edges.size(); ++e) {
    const auto& vertices = edges[e]->Vertices();
    const auto free = std::count_if(vertices.begin(), vertices.end(), [](const auto& v) { return !v->IsFixed(); });
    EXPECT_EQ(incidence.begin[e + 1] - incidence.begin[e], free);
  }
}

TEST(DropOrdering, AnEdgeBetweenTwoDroppedLandmarksIsRefused) {
  std::vector<std::shared_ptr<Vertex>> points{std::make_shared<VertexPointXYZ>(Vec3::Zero()),
                                              std::make_shared<VertexPointXYZ>(Vec3::Ones())};
  auto edge = std::make_shared<LinearEdge>(points, std::vector<MatXX>(2, MatXX::Identity(3, 3)), VecX::Zero(3));
  EXPECT_THROW(EliminateVertices({edge}, points), std::invalid_argument);
}

}  // namespace
}  // namespace ch5
