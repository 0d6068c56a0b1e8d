/// What travels between judge and worker comes back as it was, and no bytes can do more than be refused.

#include <gtest/gtest.h>
#include <unistd.h>

#include <chrono>
#include <cstring>
#include <limits>

#include "ch5_backend/simulate/random.h"
#include "ch5_homework/judge/remote/members.h"
#include "ch5_homework/judge/remote/mono_ba_wire.h"
#include "ch5_homework/judge/remote/window_wire.h"
#include "ch5_homework/judge/scenes.h"
#include "ch5_homework/judge/stage_6_window.h"

namespace ch5::homework {
namespace {

template <typename T>
std::string Bytes(const T& value) {
  return Pack(value).Bytes();
}

// Reads what is one T, or throws.
template <typename T>
T ReadAs(const std::string& bytes) {
  Reader in(bytes);
  T value;
  in >> value;
  in.End();
  return value;
}

TEST(Wire, NumbersComeBackToTheBit) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  MatXX A(2, 3);
  A << 0.1, -0.0, nan, 1e308, std::numeric_limits<double>::infinity(), 5e-324;
  const MatXX B = ReadAs<MatXX>(Bytes(A));
  ASSERT_EQ(B.rows(), 2);
  EXPECT_EQ(std::memcmp(A.data(), B.data(), sizeof(double) * 6), 0);  // NOLINT: the bits, also of −0 and NaN
  EXPECT_EQ(ReadAs<MatXX>(Bytes(MatXX(0, 7))).cols(), 7);
  EXPECT_EQ(ReadAs<std::string>(Bytes(std::string("a\0b", 3))), std::string("a\0b", 3));
  EXPECT_EQ(ReadAs<int>(Bytes(-5)), -5);
  EXPECT_EQ(ReadAs<bool>(Bytes(true)), true);
}

TEST(Wire, AGraphComesBackAsItWas) {
  Random random(1);
  Graph graph;
  const auto poses = AddPoses(&graph, 2);
  const auto depths = AddInverseDepths(&graph, 1);
  poses[1]->SetFixed();
  AddRandomEdge<2>(&graph, &random, poses[0], depths[0], poses[1]);
  graph.Edges()[0]->SetLossFunction(std::make_shared<CauchyLoss>(0.7));
  const GraphNumbers sent = NumbersOf(graph.Vertices(), graph.Edges());
  const WireGraph came(ReadAs<GraphNumbers>(Bytes(sent)));
  EXPECT_EQ(Bytes(NumbersOf(came.AllVertices())), Bytes(sent.vertices));
  const Edge &edge = *graph.Edges()[0], &other = *came.AllEdges()[0];
  double drho, other_drho;
  MatXX W, other_W;
  edge.RobustInfo(&drho, &W);
  other.RobustInfo(&other_drho, &other_W);
  EXPECT_NEAR(drho, other_drho, 1e-14);
  EXPECT_TRUE(other_W.isApprox(W, 1e-14));
  EXPECT_EQ(other.Jacobian(2), edge.Jacobian(2));
}

TEST(Wire, AnEdgeShowsOldNumbersUntilItIsLinearised) {
  Random random(2);
  Graph graph;
  const auto poses = AddPoses(&graph, 1);
  AddRandomEdge<2>(&graph, &random, poses[0]);
  GraphNumbers numbers = NumbersOf(graph.Vertices(), graph.Edges());
  numbers.edges[0].before.r << 7, 8;
  const WireGraph came(numbers);
  WireEdge& edge = *came.AllEdges()[0];
  EXPECT_EQ(edge.Residual(), VecX(Vec2(7, 8)));
  EXPECT_EQ(edge.Linearised(), 0);
  edge.ComputeResidual();
  EXPECT_EQ(edge.Residual(), graph.Edges()[0]->Residual());
  EXPECT_EQ(edge.Linearised(), WireEdge::kResidual);
}

TEST(Wire, AWindowComesBackAsItWas) {
  const Window window = FullWindow();
  const WindowNumbers sent = NumbersOf(window);
  const WireWindow came(ReadAs<WindowNumbers>(Bytes(sent)));
  EXPECT_EQ(Bytes(StatesOf(came.window, came.vertices)), Bytes(StatesOf(window, VerticesOf(window))));
  ASSERT_EQ(came.edges.size(), window.graph.Edges().size());
  for (size_t k = 0; k < came.edges.size(); ++k) {
    EXPECT_EQ(came.edges[k]->TypeInfo(), window.graph.Edges()[k]->TypeInfo());
    EXPECT_EQ(came.edges[k] == came.window.prior, window.graph.Edges()[k] == window.prior);
  }
  EXPECT_EQ(came.window.prior->GetPrior().J, window.prior->GetPrior().J);
}

TEST(Wire, FramesGoThroughAPipe) {
  int ends[2];
  ASSERT_EQ(pipe(ends), 0);
  const std::string first(10000, 'x');
  std::string read;
  ASSERT_TRUE(WriteFrame(ends[1], first) && WriteFrame(ends[1], ""));
  close(ends[1]);
  EXPECT_TRUE(ReadFrame(ends[0], &read) && read == first);
  EXPECT_TRUE(ReadFrame(ends[0], &read) && read.empty());
  EXPECT_FALSE(ReadFrame(ends[0], &read));
  close(ends[0]);
  std::string bytes = Frame("abc") + "ch5";
  EXPECT_EQ(TakeFrame(&bytes), "abc");
  EXPECT_EQ(TakeFrame(&bytes), std::nullopt);  // incomplete
}

TEST(Wire, ImpossibleSizesAreRefused) {
  std::string long_frame("ch5!\xff\xff\xff\xff", 8), no_frame = "hello";
  EXPECT_THROW(TakeFrame(&long_frame), WireError);
  EXPECT_THROW(TakeFrame(&no_frame), WireError);
  EXPECT_THROW(ReadAs<MatXX>(Pack(1 << 30, 1 << 30).Bytes()), WireError);
  EXPECT_THROW(ReadAs<MatXX>(Pack(-1, 3).Bytes()), WireError);
  EXPECT_THROW(ReadAs<MatXX>(Pack(4096, 4096).Bytes()), WireError);  // and no memory is taken for it
  EXPECT_THROW(ReadAs<VecX>(Bytes(MatXX(2, 2))), WireError);
  EXPECT_THROW(ReadAs<std::vector<int>>(Bytes(int64_t{1} << 40)), WireError);
  EXPECT_THROW(ReadAs<int>(Bytes(int64_t{1} << 40)), WireError);
  EXPECT_THROW(ReadAs<int>(Bytes(1) + "x"), WireError);
}

// What both sides do with bytes; only exceptions may come of it.
void TryToRead(const std::string& bytes) {
  const auto attempt = [](const auto& read) {
    try {
      read();
    } catch (const std::exception&) {
    }
  };
  attempt([&] { WireGraph graph(ReadAs<GraphNumbers>(bytes)); });
  attempt([&] { WireWindow window(ReadAs<WindowNumbers>(bytes)); });
  attempt([&] { ReadAs<MonoBaScene>(bytes); });
  attempt([&] { ReadAs<SolverNumbers>(bytes); });
  attempt([&] {
    std::string rest = bytes;
    while (TakeFrame(&rest)) {
    }
  });
}

TEST(Wire, RandomBytesAreRefusedForASecond) {
  Random random(3);
  Window window = FullWindow();
  const std::string whole = Bytes(NumbersOf(window)), graph = Bytes(NumbersOf(window).graph);
  const auto until = std::chrono::steady_clock::now() + std::chrono::seconds(1);
  int tries = 0;
  while (std::chrono::steady_clock::now() < until) {
    std::string bytes = tries % 3 == 0 ? whole : tries % 3 == 1 ? graph : std::string(random.Bits() % 300, 'c');
    for (uint64_t changes = random.Bits() % 20 + 1; changes > 0 && !bytes.empty(); --changes) {
      bytes[random.Bits() % bytes.size()] =
          static_cast<char>(random.Bits() % 4 == 0 ? random.Bits() : random.Bits() % 3);
    }
    if (random.Bits() % 4 == 0) bytes.resize(random.Bits() % (bytes.size() + 1));
    TryToRead(bytes);
    ++tries;
  }
  EXPECT_GT(tries, 10);
}

}  // namespace
}  // namespace ch5::homework
