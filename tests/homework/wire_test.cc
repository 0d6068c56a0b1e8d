/// What travels between judge and worker comes back as it was, and no bytes can do more than be refused.

#include <gtest/gtest.h>
#include <unistd.h>

#include <chrono>
#include <cstring>
#include <limits>

#include "ch5_backend/math/psd.h"
#include "ch5_backend/simulate/random.h"
#include "ch5_homework/judge/remote/functions/block_solver.h"
#include "ch5_homework/judge/remote/functions/gauge_prior.h"
#include "ch5_homework/judge/remote/functions/vins_window.h"
#include "ch5_homework/judge/stage_6_scene.h"

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

// What a worker has of a scene: built anew, as the judge's is by now.
Scene& Fetched(Scene* scene) {
  Writer out;
  SendScene(scene, &out);
  Reader in(out.Bytes());
  return *FetchScene(&in);
}

void ExpectTheSameBits(Scene* one, Scene* other) {
  EXPECT_EQ(Bytes(States(one->Vertices())), Bytes(States(other->Vertices())));
  ASSERT_EQ(one->Edges().size(), other->Edges().size());
  for (size_t k = 0; k < one->Edges().size(); ++k) {
    const auto a = one->Edges()[k], b = other->Edges()[k];
    EXPECT_EQ(a->TypeInfo(), b->TypeInfo());
    EXPECT_EQ(PlacesOf(VertexList(a->Vertices()), one->Vertices()),
              PlacesOf(VertexList(b->Vertices()), other->Vertices()));
    a->Linearize();
    b->Linearize();
    EXPECT_EQ(Bytes(a->Residual()), Bytes(b->Residual()));
    EXPECT_EQ(Bytes(a->Information()), Bytes(b->Information()));
    EXPECT_EQ(a->GetLossFunction() == nullptr, b->GetLossFunction() == nullptr);
    for (size_t i = 0; i < a->Vertices().size(); ++i) EXPECT_EQ(Bytes(a->Jacobian(i)), Bytes(b->Jacobian(i)));
  }
}

TEST(Wire, BothSidesHaveTheSameScene) {
  for (const bool drawn : {false, true}) {
    if (drawn) DrawnSeed() = 12345;
    GraphScene row("row", {1}), free("free graph", {static_cast<int>(GaugeGroup::kVisualInertial), 4, 6, 113});
    BundleScene bundle(4, 20, false);
    StartScene start;
    FactorGraph factors(FactorGraph::kRobust);
    WindowScene window("full window");
    for (Scene* scene : std::initializer_list<Scene*>{&row, &free, &bundle, &start, &factors, &window}) {
      ExpectTheSameBits(scene, &Fetched(scene));
    }
  }
  DrawnSeed().reset();
}

// Else the judge's own rounding is larger than what a check tolerates.
TEST(Wire, WhatTheFactorsDropIsFarFromSingularWithAnySeed) {
  for (DrawnSeed() = 0; *DrawnSeed() < 1000; ++*DrawnSeed()) {
    FactorScene scene;
    const int m = scene.DimDropped();
    const VecX S = DecomposeSymmetric(scene.Right().H.topLeftCorner(m, m)).S;
    EXPECT_GT(S.minCoeff(), 1e-5 * S.maxCoeff()) << *DrawnSeed();
  }
  DrawnSeed().reset();
}

TEST(Wire, ASceneFollowsTheJudges) {
  GraphScene row("row", {0});
  Scene& other = Fetched(&row);
  row.poses[2]->SetFixed();
  row.points[1]->Plus(Vec3(1, 2, 3).data());
  EXPECT_EQ(&Fetched(&row), &other);
  ExpectTheSameBits(&row, &other);
  WindowScene window("sliding window");
  window.Step();
  ExpectTheSameBits(&window, &Fetched(&window));
  EXPECT_THROW(Scene::Make("nowhere", {}), std::invalid_argument);
}

TEST(Wire, AnAgedEdgeShowsOldNumbersUntilItIsLinearized) {
  FactorGraph factors;
  Edge& edge = *factors.factors[0].edge;
  const auto& aged = dynamic_cast<const AgedEdge&>(edge);
  EXPECT_EQ(aged.Fresh(), 0);
  edge.ComputeResidual();
  EXPECT_EQ(aged.Fresh(), AgedEdge::kResidual);
  edge.ComputeJacobians();
  EXPECT_TRUE(aged.IsFresh());
}

TEST(Wire, ASlidWindowComesBackAsItWas) {
  WindowScene here("full window"), there("full window");
  const VertexList known = there.Vertices(), own = here.Vertices();
  Window& slid = there.window;
  slid.frames[5].imu->Append(*slid.frames[6].imu);
  slid.frames[6].imu = slid.frames[5].imu;
  slid.frames.erase(slid.frames.begin() + 5);
  slid.frames[2].pose->Plus(Vec6(Vec6::Constant(0.1)).data());
  slid.landmarks.at(kHostedByNext).inverse_depth = std::make_shared<VertexInverseDepth>(0.25);
  slid.landmarks.erase(kSeenTwice);
  SetInto(ReadAs<WindowNumbers>(Bytes(NumbersOf(slid, known))), own, &here.window);
  ASSERT_EQ(here.window.frames.size(), slid.frames.size());
  for (size_t k = 0; k < slid.frames.size(); ++k) {
    EXPECT_EQ(here.window.frames[k].id, slid.frames[k].id);
    EXPECT_EQ(PlaceOf<Vertex>(here.window.frames[k].pose, own), PlaceOf<Vertex>(slid.frames[k].pose, known));
    EXPECT_EQ(VecX(here.window.frames[k].pose->Parameters()), VecX(slid.frames[k].pose->Parameters()));
    EXPECT_EQ(here.window.frames[k].imu == nullptr, k == 0);
    if (k > 0) {
      EXPECT_EQ(here.window.frames[k].imu->Alpha(), slid.frames[k].imu->Alpha());
    }
  }
  EXPECT_EQ(here.window.landmarks.size(), slid.landmarks.size());
  EXPECT_EQ(here.window.landmarks.at(kHostedByNext).inverse_depth->InverseDepth(), 0.25);
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
  std::string bytes = Framed("abc") + "ch5";
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
  WindowScene window("full window");
  const VertexList known = window.Vertices();
  attempt([&] { SetInto(ReadAs<WindowNumbers>(bytes), known, &window.window); });
  attempt([&] { EdgePrior(MakePrior(ReadAs<PriorNumbers>(bytes), known, nullptr)); });
  attempt([&] { ReadAs<States>(bytes).SetInto(known); });
  attempt([&] { ReadAs<vins_window::Evaluated>(bytes); });
  attempt([&] { ReadAs<std::vector<gauge_prior::EdgeNumbers>>(bytes); });
  attempt([&] {
    SparseBlocks blocks("H_pp");
    Reader in(bytes);
    in >> blocks;
  });
  attempt([&] {
    std::string rest = bytes;
    while (TakeFrame(&rest)) {
    }
  });
}

TEST(Wire, RandomBytesAreRefusedForASecond) {
  Random random(3);
  WindowScene window("full window");
  const VertexList known = window.Vertices();
  const std::string whole = Bytes(NumbersOf(window.window, known)),
                    prior = Bytes(NumbersOf(window.window.prior->GetPrior(), known));
  const auto until = std::chrono::steady_clock::now() + std::chrono::seconds(1);
  int tries = 0;
  while (std::chrono::steady_clock::now() < until) {
    std::string bytes = tries % 3 == 0 ? whole : tries % 3 == 1 ? prior : std::string(random.Bits() % 300, 'c');
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
