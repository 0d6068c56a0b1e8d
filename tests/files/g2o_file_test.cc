#include "ch5_backend/files/g2o_file.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <sstream>

#include "ch5_backend/files/text_reader.h"
#include "ch5_backend/math/so3.h"
#include "ch5_backend/simulate/random.h"
#include "ch5_backend/types/pose_graph/edge_between.h"
#include "tests/data_folder.h"
#include "tests/temporary_folder.h"

namespace ch5 {
namespace {

constexpr char kTwoPoses[] =
    "VERTEX_SE3:QUAT 3 1 2 3 0 0 0 1\n"
    "VERTEX_SE3:QUAT 7 2 2 3 0 0 0 1\n";
constexpr char kUnitW[] = "1 0 0 0 0 0 1 0 0 0 0 1 0 0 0 1 0 0 1 0 1";

class G2o : public testing::Test {
 protected:
  G2oFile Read(const std::string& text) const {
    std::ofstream(path_, std::ios::binary) << text;
    return ReadG2o(path_);
  }

  // The message must begin with "path:line: " and hold `part`.
  void ExpectError(const std::string& text, int line, const std::string& part) const {
    const std::string what = test::Refusal<FileError>([&] { Read(text); });
    EXPECT_EQ(what.find(path_ + ":" + std::to_string(line) + ": "), 0u) << what << text;
    EXPECT_NE(what.find(part), std::string::npos) << what;
  }

  test::TemporaryFolder folder_;
  std::string path_ = folder_ / "graph.g2o";
};

TEST_F(G2o, ReadsPosesEdgesAndFixed) {
  const G2oFile file = Read(std::string("# made by hand\r\n") + kTwoPoses +
                            "EDGE_SE3:QUAT 3 7 1.5 0 0 0 0 0.6 0.8 "
                            "1 2 0 0 0 0 9 0 0 0 0 3 0 0 0 4 0 0 5 0.5 6\n"
                            "FIX 7\n\n"
                            "VERTEX_SE2 1 4 5 0.25\nVERTEX_SE2 0 4 6 0.5\n"
                            "EDGE_SE2 1 0 0 1 -0.25 1 0 0 2 0.1 3\n");
  ASSERT_EQ(file.graph.Vertices().size(), 4u);
  EXPECT_EQ(file.ids, (std::vector<int64_t>{0, 1, 3, 7}));
  EXPECT_FALSE(file.graph.Vertices()[2]->IsFixed());
  EXPECT_TRUE(file.graph.Vertices()[3]->IsFixed());
  EXPECT_TRUE(file.unknown.empty());

  const auto& edge = dynamic_cast<const EdgeSE3Between&>(*file.graph.Edges()[0]);
  EXPECT_EQ(edge.Vertices()[1], file.graph.Vertices()[3]);
  EXPECT_EQ(edge.p_z(), Vec3(1.5, 0, 0));
  EXPECT_EQ(edge.q_z().z(), 0.6);
  EXPECT_EQ(edge.q_z().w(), 0.8);
  Mat66 W = Mat66::Zero();
  W.diagonal() << 1, 9, 3, 4, 5, 6;
  W(0, 1) = W(1, 0) = 2;
  W(4, 5) = W(5, 4) = 0.5;
  EXPECT_EQ(edge.W(), W);

  const auto& planar = dynamic_cast<const EdgeSE2Between&>(*file.graph.Edges()[1]);
  EXPECT_EQ(planar.p_z(), Vec2(0, 1));
  EXPECT_EQ(planar.ThetaZ(), -0.25);
  EXPECT_EQ(planar.W()(2, 1), 0.1);
  EXPECT_EQ(planar.GetVertex<0>().Theta(), 0.25);
}

// A path of twelve poses that turn by half a radian about changing axes; `guess` turns each pose further.
std::string Path(double guess, bool poses_w_first, bool edges_w_first) {
  std::ostringstream poses, edges;
  const auto write = [](std::ostream& out, const Qd& q, bool w_first) {
    if (w_first) out << q.w() << ' ' << q.x() << ' ' << q.y() << ' ' << q.z();
    if (!w_first) out << q.x() << ' ' << q.y() << ' ' << q.z() << ' ' << q.w();
  };
  Qd q = ExpSO3(Vec3(0.3, -0.8, 1.1));
  for (int k = 0; k < 12; ++k) {
    poses << "VERTEX_SE3:QUAT " << k << ' ' << k << " 0 0 ";
    write(poses, q * ExpSO3(guess * Vec3(std::sin(k), std::cos(3 * k), std::sin(2 * k))), poses_w_first);
    poses << '\n';
    const Qd turn = ExpSO3(0.5 * Vec3(std::cos(k), std::sin(2 * k), std::cos(5 * k)).normalized());
    if (k < 11) edges << "EDGE_SE3:QUAT " << k << ' ' << k + 1 << " 1 0 0 ";
    if (k < 11) write(edges, turn, edges_w_first);
    if (k < 11) edges << ' ' << kUnitW << '\n';
    q = q * turn;
  }
  return poses.str() + edges.str();
}

TEST_F(G2o, QuaternionsWithTheScalarFirstAreRefused) {
  for (const double guess : {0.0, 0.2, 2.0}) {
    EXPECT_NO_THROW(Read(Path(guess, false, false))) << guess;
    for (const bool poses : {false, true}) {
      const std::string what = test::Refusal<FileError>([&] { Read(Path(guess, poses, true)); });
      EXPECT_EQ(what.find(path_ + ": the quaternions stand as w x y z, but g2o's order is x y z w"), 0u) << what;
    }
  }
  const std::string path = Path(0.0, false, true), edges = path.substr(path.find("EDGE"));
  EXPECT_THROW(Read(edges), FileError) << "edges alone tell it too";
}

// A ring of 12 poses, `pose` and `edge` being what stands for a radian; each pose's angle has `turns` full turns more.
std::string Ring(double pose, double edge, int turns, const std::string& pose_tag, const std::string& edge_tag) {
  std::ostringstream poses, edges;
  for (int k = 0; k < 12; ++k) {
    const double theta = k * M_PI / 6;
    poses << pose_tag << ' ' << k << ' ' << std::sin(theta) << ' ' << -std::cos(theta) << ' '
          << pose * theta + 2 * M_PI * turns << '\n';
    edges << edge_tag << ' ' << k << ' ' << (k + 1) % 12 << " 0.5 0.133975 " << edge * M_PI / 6
          << " 2 0 1 2 0 1\n";  // W in either order
  }
  return poses.str() + edges.str();
}

TEST_F(G2o, AnglesInDegreesAreRefused) {
  const double degrees = 180 / M_PI;
  const auto se2 = [](double pose, double edge, int turns) {
    return Ring(pose, edge, turns, "VERTEX_SE2", "EDGE_SE2");
  };
  ExpectError(se2(degrees, degrees, 0), 2, "the angle 30.000000 is beyond a full turn: g2o's angles are in radians");
  ExpectError(se2(degrees, 1, 0), 2, "the angle 30");
  ExpectError(se2(1, degrees, 0), 13, "the angle 30");
  ExpectError(Ring(degrees, degrees, 0, "VERTEX2", "EDGE2"), 2, "the angle 30");
  const std::string both = se2(degrees, degrees, 0), edges = both.substr(both.find("EDGE"));
  ExpectError(edges, 1, "the angle 30");
  std::string spot;  // turned on the spot, no step tells, and poses and edges agree
  for (int i = 0; i < 4; ++i) spot += "VERTEX_SE2 " + std::to_string(i) + " 0 0 " + std::to_string(90 * i) + "\n";
  ExpectError(spot + "EDGE_SE2 0 1 0 0 90 1 0 0 1 0 1\nEDGE_SE2 3 0 0 0 90 1 0 0 1 0 1\n", 5, "the angle 90");
  ExpectError("VERTEX3 0 1 2 3 0 0 90\n", 1, "VERTEX3: roll, pitch and yaw must be in radians, got 90");
  for (const int turns : {0, 1, 50}) EXPECT_NO_THROW(Read(se2(1, 1, turns))) << "an angle may count its turns";
  const std::string counted = "EDGE_SE2 3 2 -0.5 0.133975 " + std::to_string(-M_PI / 6 - 8 * M_PI) + " 1 0 0 1 0 1\n";
  EXPECT_NO_THROW(Read(se2(1, 1, 0) + counted)) << "an edge's too, if the poses show it";
}

TEST_F(G2o, AVertexMayStandAgainWithTheSameNumbers) {
  const std::string edge = std::string("EDGE_SE3:QUAT 3 7 1 0 0 0 0 0 1 ") + kUnitW + "\n";
  const G2oFile file = Read(std::string(kTwoPoses) + kTwoPoses + edge);
  EXPECT_EQ(file.repeated_vertices, 2);
  EXPECT_EQ(file.first_repeated_vertex, 3);
  EXPECT_EQ(FormatG2o(file), kTwoPoses + edge);
}

TEST_F(G2o, ALastLineWithoutItsEndIsTold) {
  EXPECT_EQ(Read(kTwoPoses).unended, "");
  EXPECT_EQ(Read(kTwoPoses + std::string("VERTEX_SE2 9 0 0 0.12")).unended,
            path_ + ":3: the file ends without a line's end; if it is cut, so may be its last number, \"0.12\"");
}

TEST_F(G2o, AnEdgeMayComeBeforeItsVertices) {
  EXPECT_EQ(Read("EDGE_SE2 0 1 1 0 0 1 0 0 1 0 1\nVERTEX_SE2 0 0 0 0\nVERTEX_SE2 1 1 0 0\n").graph.Edges().size(), 1u);
}

// g2o writes them as they lie in a hash table. Ids are the path, which --gnc trusts; the lines keep their order.
TEST_F(G2o, VerticesInAnyOrderAreNumberedByTheirIds) {
  const std::string edges = "EDGE_SE2 4 9 1 0 0 1 0 0 1 0 1\nEDGE_SE2 9 12 1 0 0 1 0 0 1 0 1\n";
  const std::string text = "VERTEX_SE2 12 2 0 0.5\nVERTEX_SE2 4 0 0 0\nVERTEX_SE2 9 1 0 0\nFIX 12\n" + edges;
  const G2oFile file = Read(text);
  EXPECT_EQ(file.ids, (std::vector<int64_t>{4, 9, 12}));
  for (int k = 0; k < 3; ++k) EXPECT_EQ(file.graph.Vertices()[k]->Parameters()[0], k);
  EXPECT_TRUE(file.graph.Vertices()[2]->IsFixed());
  EXPECT_EQ(file.graph.Edges()[0]->Vertices()[1], file.graph.Vertices()[1]);
  EXPECT_EQ(FormatG2o(file), text);
  ExpectError("VERTEX_SE2 1 1 0 0\nVERTEX_SE2 0 0 0 90\nEDGE_SE2 0 1 0 -1 0 1 0 0 1 0 1\n", 2, "radians");
}

// GTSAM's id of x1 has the letter in its highest byte; twice the same edge is CSAIL's too.
TEST_F(G2o, IdsOfGtsamAndRepeatedEdgesAreRead) {
  const std::string x0 = "8646911284551352320", x1 = "8646911284551352321", edge = " 1 0 0 1 0 0 1 0 1\n";
  const std::string text = "VERTEX_SE2 " + x0 + " 0 0 0\nVERTEX_SE2 " + x1 + " 1 0 0\nFIX " + x1 + "\nEDGE_SE2 " + x0 +
                           " " + x1 + edge + "EDGE_SE2 " + x1 + " " + x0 + edge + "EDGE_SE2 " + x0 + " " + x1 + edge;
  const G2oFile file = Read(text);
  EXPECT_EQ(std::to_string(file.ids[1]), x1);
  EXPECT_EQ(file.repeated, 1);
  EXPECT_EQ(file.first_repeated, 6);
  EXPECT_EQ(FormatG2o(file), text);
}

// The information is xx xy yy θθ xθ yθ.
TEST_F(G2o, TorosFilesInThePlaneAreRead) {
  EXPECT_EQ(FormatG2o(Read("VERTEX2 0 0 0 0\nVERTEX2 1 1 0 0\nEDGE2 0 1 1 0 0 11 1 12 13 2 3\n")),
            "VERTEX_SE2 0 0 0 0\nVERTEX_SE2 1 1 0 0\nEDGE_SE2 0 1 1 0 0 11 1 2 12 3 13\n");
}

// As CSAIL's is published. The ids' order is the poses'; written, they stand before the edges.
TEST_F(G2o, EdgesAloneMakeTheirPoses) {
  const G2oFile file = Read("# edges\nEDGE_SE2 7 2 1 0 0 1 0 0 1 0 1\nEDGE_SE2 2 5 1 0 0 1 0 0 1 0 1\nFIX 5\n");
  EXPECT_FALSE(file.has_poses);
  EXPECT_EQ(file.ids, (std::vector<int64_t>{2, 5, 7}));
  EXPECT_TRUE(file.graph.Vertices()[1]->IsFixed());
  EXPECT_EQ(file.graph.Edges()[0]->Vertices()[0], file.graph.Vertices()[2]);
  EXPECT_EQ(FormatG2o(file),
            "VERTEX_SE2 2 0 0 0\nVERTEX_SE2 5 0 0 0\nVERTEX_SE2 7 0 0 0\n# edges\n"
            "EDGE_SE2 7 2 1 0 0 1 0 0 1 0 1\nEDGE_SE2 2 5 1 0 0 1 0 0 1 0 1\nFIX 5\n");
  EXPECT_TRUE(Read(FormatG2o(file)).has_poses);
  ExpectError("EDGE_SE2 0 1 1 0 0 1 0 0 1 0 1\nEDGE_SE3:QUAT 1 2 1 0 0 0 0 0 1 " + std::string(kUnitW), 2,
              "vertex 1 is of another type");
  ExpectError("EDGE_SE2 0 1 1 0 0 1 0 0 1 0 1\nFIX 2\n", 2, "no vertex with the id 2");
}

// W = [1 2; 2 1] has the eigenvalues 3 and −1, so that the nearest one is 3 v vᵀ with v = (1, 1)/√2.
TEST_F(G2o, InformationThatIsNoneIsRefusedOrProjected) {
  const std::string text =
      "VERTEX_SE2 0 0 0 0\nVERTEX_SE2 1 1 0 0\nEDGE_SE2 0 1 1 0 0 1 2 0 1 0 1\n"
      "EDGE_SE2 1 0 -1 0 0 1 0 0 1 0 1\n";
  ExpectError(text, 3,
              "its smallest eigenvalue is -1 (g2o gives its upper half row by row); --project-information takes the "
              "nearest one that is");
  std::ofstream(path_, std::ios::binary) << text;
  const G2oFile file = ReadG2o(path_, {true});
  EXPECT_EQ(file.projected, 1);
  Mat33 W;
  W << 1.5, 1.5, 0, 1.5, 1.5, 0, 0, 0, 1;
  EXPECT_LT((file.graph.Edges()[0]->Information() - W).norm(), 1e-14);
  EXPECT_EQ(MatXX(file.graph.Edges()[1]->Information()), MatXX::Identity(3, 3));
}

TEST_F(G2o, UnknownTagsAreRefusedOrLeftOut) {
  const std::string text = std::string(kTwoPoses) + "FIX 3\n# half-way\nEDGE_SE2_SWITCHABLE 3 7 1\n" +
                           "EDGE_SE3:QUAT 3 7 1 0 0 0 0 0 1 " + kUnitW + "\nVERTEX_SE2 1 0.1 5 0.25\n";
  ExpectError(text, 5, "EDGE_SE2_SWITCHABLE: not known, so what it says would be missing; --leave-out");
  const G2oFile file = ReadG2o(path_, {false, true});
  EXPECT_EQ(FormatG2o(file), text) << "it is written again, where it stood";
  ASSERT_EQ(file.unknown.size(), 1u);
  EXPECT_EQ(file.unknown[0].number, 5);
  EXPECT_EQ(file.unknown[0].text, "EDGE_SE2_SWITCHABLE 3 7 1");
}

// A robot at (1, 2) that looks along y, and another 2 m ahead of it; what they and their sensors see is exact.
constexpr char kInPlane[] =
    "PARAMS_SE2OFFSET 4 1 0 0.5\nVERTEX_SE2 0 1 2 1.5707963267948966\nVERTEX_SE2 1 1 4 1.5707963267948966\n"
    "VERTEX_XY 7 -2 7\nVERTEX_XY 8 1 9\nVERTEX_SE2 9 1 0 0.5\nFIX 8\n"
    "EDGE_SE2_OFFSET 0 1 4 4 1.7551651237807455 -0.958851077208406 0 1 0 0 1 0 1\n"
    "EDGE_SE2_XY 0 7 5 3 1 0 1\n"
    "EDGE_SE2_POINTXY_OFFSET 0 7 4 4.9486068633741 0.7150455312543063 1 0 1\n"
    "EDGE_SE2_XY_CALIB 0 7 9 4.9486068633741 0.7150455312543063 1 0 1\n"
    "EDGE_BEARING_SE2_XY 0 7 0.5404195002705842 1\n"
    "EDGE_POINTXY 7 8 3 2 1 0 1\n"
    "EDGE_PRIOR_SE2 0 1 2 1.5707963267948966 1 0 0 1 0 1\n"
    "EDGE_PRIOR_SE2_XY 1 1 4 1 0 1\nEDGE_PRIOR_XY 7 -2 7 1 0 1\n";
// A camera turned by 90° about z at (1, 2, 3), so that its x is the world's y.
constexpr char kInSpace[] =
    "PARAMS_SE3OFFSET 0 1 0 0 0 0 0 1\n"
    "VERTEX_SE3:QUAT 0 1 2 3 0 0 0.7071067811865476 0.7071067811865476\nVERTEX_SE3:QUAT 1 1 4 3 0 0 0 1\n"
    "VERTEX_TRACKXYZ 7 1 7 5\nVERTEX_TRACKXYZ 8 1 7 6\n"
    "EDGE_SE3_OFFSET 0 1 0 0 1 -1 0 0 0 -0.7071067811865476 0.7071067811865476 $\n"
    "EDGE_SE3_TRACKXYZ 0 7 0 4 0 2 1 0 0 1 0 1\nEDGE_POINTXYZ 7 8 0 0 1 1 0 0 1 0 1\n"
    "EDGE_SE3_PRIOR 1 0 2 4 3 0 0 0 1 $\nEDGE_SE3_XYZ_PRIOR 1 0 1 4 3 1 0 0 1 0 1\n"
    "EDGE_POINTXYZ_PRIOR 7 1 7 5 1 0 0 1 0 1\n";

TEST_F(G2o, AllTagsAreReadAndWritten) {
  std::string in_space = kInSpace;
  for (size_t at; (at = in_space.find('$')) != std::string::npos;) in_space.replace(at, 1, kUnitW);
  for (const std::string& text : {std::string(kInPlane), in_space}) {
    const G2oFile file = Read(text);
    EXPECT_EQ(FormatG2o(file), text);
    EXPECT_EQ(FormatG2o(Read(FormatG2o(file))), text);
    for (const auto& edge : file.graph.Edges()) {
      edge->ComputeResidual();
      EXPECT_LT(edge->Residual().norm(), 1e-12) << edge->Name() << ": " << edge->Residual().transpose();
    }
  }
  const G2oFile file = Read(kInPlane);
  EXPECT_TRUE(file.graph.Vertices()[3]->IsFixed()) << "a landmark can be fixed";
  ExpectError(std::string(kInPlane) + "EDGE_SE2_POINTXY_OFFSET 0 7 5 1 1 1 0 1\n", 17,
              "no PARAMS_SE2OFFSET with the id 5");
  ExpectError(std::string(kInPlane) + "EDGE_SE2_XY 0 1 5 3 1 0 1\n", 17, "EDGE_SE2_XY: vertex 1 is of another type");
  ExpectError(std::string(kInPlane) + "PARAMS_SE2OFFSET 4 1 0 0.5\n", 17, "two with the id 4");
}

// R_z(yaw) R_y(pitch) R_x(roll), and W in radians where ours is in halves: 4 times as much, and twice beside meters.
TEST_F(G2o, TorosFilesInSpaceAreRead) {
  const double h = M_PI / 2;
  std::ostringstream text;
  text.precision(17);
  text << "VERTEX3 0 0 0 0 0 0 0\nVERTEX3 1 1 2 3 " << h << " 0 " << h << "\nEDGE3 0 1 1 2 3 " << h << " 0 " << h
       << " 10 0 0 1 0 0 11 0 0 0 0 12 0 0 0 13 0 0 14 0 15\n";
  const G2oFile file = Read(text.str());
  const auto& edge = dynamic_cast<const EdgeSE3Between&>(*file.graph.Edges()[0]);
  // x stays, turned about z: y; y turned about x: z.
  EXPECT_LT((edge.q_z() * Vec3::UnitX() - Vec3::UnitY()).norm(), 1e-15);
  EXPECT_LT((edge.q_z() * Vec3::UnitY() - Vec3::UnitZ()).norm(), 1e-15);
  EXPECT_LT(edge.q_z().angularDistance(edge.GetVertex<1>().q()), 1e-7);
  EXPECT_EQ(edge.W()(0, 0), 10);
  EXPECT_EQ(edge.W()(0, 3), 2);
  EXPECT_EQ(Vec3(edge.W().diagonal().tail<3>()), Vec3(52, 56, 60));
}

// iSAM's numbers are roots of W, along the first pose's axes; GTSAM's covariances. Landmarks are counted apart.
TEST_F(G2o, ListsOfIsamAreRead) {
  const G2oFile roots = Read("ODOMETRY 0 1 1 0 1.5707963267948966 2 0 0 3 0 5\nLANDMARK 1 1 4 0 7 0 8\n");
  EXPECT_FALSE(roots.has_poses);
  EXPECT_EQ(roots.lists, G2oFile::Lists::kRoots);
  EXPECT_EQ(roots.ids, (std::vector<int64_t>{0, 1, 3})) << "landmark 1 is not pose 1";
  EXPECT_LT((roots.graph.Edges()[0]->Information().diagonal() - Vec3(9, 4, 25)).norm(), 1e-12)
      << "turned by 90 degrees";
  EXPECT_LT((roots.graph.Edges()[1]->Information().diagonal() - Vec2(49, 64)).norm(), 1e-12);
  const G2oFile covariances = Read("ODOMETRY 0 1 1 0 1.5 0.5 0 0 0.25 0 0.125\nLANDMARK 1 5 4 0 0.1 0 0.1\n");
  EXPECT_EQ(covariances.lists, G2oFile::Lists::kCovariances);
  EXPECT_EQ(covariances.ids, (std::vector<int64_t>{0, 1, 5}));
  EXPECT_LT((covariances.graph.Edges()[0]->Information().diagonal() - Vec3(2, 4, 8)).norm(), 1e-12);
  ExpectError("ODOMETRY 0 1 1 0 1.5 0.5 0 0 0 0 0.125\n", 1, "ODOMETRY: the covariance is singular");
}

TEST_F(G2o, WritesTheGraphAsItHasBecome) {
  G2oFile file = Read(
      "VERTEX_SE2 1 1 0 0\nVERTEX_SE2 0 0 0 0\nVERTEX_SE2 5 5 0 0\nFIX 1 0\nFIX 1\n"
      "EDGE_SE2 1 0 1 0 0 1 0 0 1 0 1\nEDGE_SE2 0 5 1 0 0 1 0 0 1 0 1\n");
  file.graph.RemoveVertex(file.graph.Vertices()[1]);
  const auto pose = std::make_shared<VertexSE2>(Vec2(2, 3), 0.5);
  pose->SetFixed();
  file.graph.AddVertex(pose);
  const auto last = std::dynamic_pointer_cast<VertexSE2>(file.graph.Vertices()[1]);
  file.graph.AddEdge(std::make_shared<EdgeSE2Between>(last, pose, Vec2(4, 0), 0.25));
  EXPECT_EQ(FormatG2o(file),
            "VERTEX_SE2 0 0 0 0\nVERTEX_SE2 5 5 0 0\nFIX 0\nEDGE_SE2 0 5 1 0 0 1 0 0 1 0 1\n"
            "VERTEX_SE2 2 2 3 0.5\nFIX 2\nEDGE_SE2 5 2 4 0 0.25 1 0 0 1 0 1\n");
  EXPECT_EQ(FormatG2o(Read(FormatG2o(file))), FormatG2o(file));

  file.graph.AddVertex(std::make_shared<VertexScalar>(VertexScalar::Estimate(0.0)));
  EXPECT_THROW(FormatG2o(file), std::invalid_argument) << "the format has no record for it";
  G2oFile own;
  own.graph.AddVertex(std::make_shared<VertexPose>());
  EXPECT_EQ(FormatG2o(own), "VERTEX_SE3:QUAT 0 0 0 0 0 0 0 1\n");
}

TEST_F(G2o, NearlyUnitQuaternionsAreNormalized) {
  const G2oFile file = Read("VERTEX_SE3:QUAT 0 0 0 0 0 0 0.6004 0.8004\n");
  EXPECT_NEAR(static_cast<const VertexPose&>(*file.graph.Vertices()[0]).q().norm(), 1.0, 1e-15);
  ExpectError("VERTEX_SE3:QUAT 0 0 0 0 0 0 0.61 0.8\n", 1, "length 1");
  ExpectError("VERTEX_SE3:QUAT 0 0 0 0 0 0 0 0\n", 1, "length 1, got 0.000000");
  ExpectError(std::string(kTwoPoses) + "EDGE_SE3:QUAT 3 7 0 0 0 0 0 0 2 " + kUnitW, 3, "got 2.000000");
}

TEST_F(G2o, ErrorsNameLineAndValue) {
  for (const auto& row : Cases("files/g2o_file.cases")) {
    const bool has_poses = row.at(0).rfind("TWO", 0) == 0;
    ExpectError(has_poses ? kTwoPoses + row[0].substr(3) : row[0], std::stoi(row.at(1)), row.at(2));
  }
}

TEST_F(G2o, OtherFilesAreRefused) {
  ExpectError("49 7776 31843\n0 0 1.0 2.0\n", 1, "got \"49\"");
  ExpectError(std::string("\x7f"
                          "ELF\x02\x01\x01\0\0\0",
                          10),
              1, "expected a tag");
  ExpectError(std::string(kTwoPoses) + std::string("\0\0\0", 3) + "\n", 3, "\\x00");
  ExpectError("version https://git-lfs.github.com/spec/v1\noid sha256:4d7a\nsize 123\n", 1, "a pointer of Git LFS");
  ExpectError("<!DOCTYPE html>\n<html>404</html>\n", 1, "a web page");
  EXPECT_THROW(Read(""), FileError);
  EXPECT_THROW(Read("# nothing\n\n"), FileError);
  std::ofstream(path_, std::ios::binary) << "VERTEX_CAM 0 1 2 3 0 0 0\n";  // a tag that is not known, and nothing else
  const std::string what = test::Refusal<FileError>([&] { ReadG2o(path_, {false, true}); });
  EXPECT_NE(what.find("VERTEX_SE2, not with VERTEX_CAM"), std::string::npos) << what;
  EXPECT_THROW(ReadG2o("/nowhere/graph.g2o"), FileError);
}

// Written and read again, a file is the same graph to the last bit but for the unit length of quaternions.
void ExpectSame(const G2oFile& first, const G2oFile& second) {
  EXPECT_EQ(first.ids, second.ids);
  ASSERT_EQ(second.graph.Edges().size(), first.graph.Edges().size());
  for (size_t i = 0; i < first.ids.size(); ++i) {
    const VecX a = first.graph.Vertices()[i]->Parameters(), b = second.graph.Vertices()[i]->Parameters();
    EXPECT_LT((a - b).cwiseAbs().maxCoeff(), 1e-15);
  }
  for (size_t i = 0; i < first.graph.Edges().size(); ++i) {
    EXPECT_EQ(MatXX(first.graph.Edges()[i]->Information()), MatXX(second.graph.Edges()[i]->Information()));
  }
}

TEST_F(G2o, RealGraphSurvivesTheRoundTrip) {
  const std::filesystem::path real = DataFolder() / "posegraph" / "parking-garage.g2o";
  CH5_NEEDS(real);
  const G2oFile first = ReadG2o(real.string());
  EXPECT_EQ(first.graph.Vertices().size(), 1661u);
  EXPECT_EQ(first.graph.Edges().size(), 6275u);
  ExpectSame(first, Read(FormatG2o(first)));
}

// Numbers of all sizes, and of all digits.
TEST_F(G2o, AMadeUpGraphSurvivesTheRoundTrip) {
  Random random(8);
  std::ostringstream text;
  text.precision(17);
  const auto transform = [&](double size) {
    const Vec3 p = size * NormalVector(&random, 1.0);
    const Qd q = ExpSO3(NormalVector(&random, 2.0));
    text << p.x() << ' ' << p.y() << ' ' << p.z() << ' ' << q.x() << ' ' << q.y() << ' ' << q.z() << ' ' << q.w();
  };
  for (int64_t i = 0; i < 60; ++i) {
    text << "VERTEX_SE3:QUAT " << 7 * i << ' ';
    transform(std::pow(10.0, random.Uniform(-9, 9)));
    text << "\nEDGE_SE3:QUAT " << 7 * (i / 2) << ' ' << 7 * (i + 1) % 420 << ' ';
    transform(5.0);
    for (int row = 0; row < 6; ++row) {
      for (int column = row; column < 6; ++column)
        text << ' ' << (row == column ? 10.0 : 1.0) * random.Uniform(0.8, 1.0);
    }
    text << '\n';
  }
  const G2oFile first = Read(text.str());
  EXPECT_EQ(first.graph.Edges().size(), 60u);
  ExpectSame(first, Read(FormatG2o(first)));
}

}  // namespace
}  // namespace ch5
