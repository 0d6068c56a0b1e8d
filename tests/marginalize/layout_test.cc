#include "ch5_backend/marginalize/layout.h"

#include "tests/marginalize/scenes.h"

namespace ch5 {
namespace {

// Frame 0 and its landmarks are dropped: dense columns of the kept vertices first, then those of the dropped, by id.
TEST(Layout, KeptColumnsComeFirstThenDroppedOnesInOrderOfIds) {
  const SmallWindow window;
  const auto drop = window.Oldest();
  const Layout layout = MakeLayout(window.EdgesAt(drop), drop);
  const std::vector<std::shared_ptr<Vertex>> kept{window.poses[1], window.speed_biases[1], window.poses[2],
                                                  window.poses[3], window.extrinsic};
  EXPECT_EQ(layout.kept, kept);
  EXPECT_EQ(layout.dropped, (std::vector<std::shared_ptr<Vertex>>{window.poses[0], window.speed_biases[0]}));
  EXPECT_EQ(layout.landmarks.size(), 6u);
  EXPECT_EQ(layout.kept_size, 6 + 9 + 6 + 6 + 6);
  EXPECT_EQ(layout.size, layout.kept_size + 6 + 9);
}

TEST(Layout, EachEdgeBelongsToItsDroppedLandmarkOrToTheDensePart) {
  const SmallWindow window;
  window.poses[1]->SetFixed();
  const auto drop = window.Oldest();
  const auto edges = window.EdgesAt(drop);
  const Layout layout = MakeLayout(edges, drop);
  EXPECT_EQ(layout.dense_edges.size(), 2u);  // the prior and the IMU's
  size_t count = layout.dense_edges.size();
  for (size_t l = 0; l < layout.landmarks.size(); ++l) {
    for (const Layout::EdgeColumns& entry : layout.landmark_edges[l]) {
      EXPECT_EQ(entry.edge->Vertices()[0], layout.landmarks[l]);
      const int* columns = layout.ColumnsOf(entry);  // landmark, host, target, extrinsic
      EXPECT_EQ(columns[0], Layout::kLandmark);
      EXPECT_EQ(columns[1], layout.kept_size);
      EXPECT_EQ(columns[2] == Layout::kFixed, entry.edge->Vertices()[2] == window.poses[1]);
      ++count;
    }
  }
  EXPECT_EQ(count, edges.size());
}

// Many vertices make the table of numbers grow.
TEST(Layout, AThousandVerticesKeepTheirColumns) {
  std::vector<std::shared_ptr<Vertex>> x;
  std::vector<std::shared_ptr<Edge>> edges;
  const std::vector<MatXX> A{MatXX::Ones(1, 1)};
  for (int k = 0; k < 1000; ++k) {
    x.push_back(std::make_shared<VertexScalar>(VertexScalar::Estimate(0.0)));
    edges.push_back(std::make_shared<LinearEdge>(std::vector{x.back()}, A, VecX::Zero(1)));
  }
  const Layout layout = MakeLayout(edges, {x[0]});
  ASSERT_EQ(layout.size, 1000);
  EXPECT_EQ(layout.ColumnsOf(layout.dense_edges[0])[0], 999);
  for (int k = 1; k < 1000; ++k) EXPECT_EQ(layout.ColumnsOf(layout.dense_edges[static_cast<size_t>(k)])[0], k - 1);
}

TEST(Layout, RefusesAnEdgeBetweenTwoDroppedLandmarks) {
  std::vector<std::shared_ptr<Vertex>> points{std::make_shared<VertexPointXYZ>(Vec3::Zero()),
                                              std::make_shared<VertexPointXYZ>(Vec3::Ones())};
  auto edge = std::make_shared<LinearEdge>(points, std::vector<MatXX>(2, MatXX::Identity(3, 3)), VecX::Zero(3));
  EXPECT_THROW(MakeLayout({edge}, points), std::invalid_argument);
}

}  // namespace
}  // namespace ch5
