/// What travels between judge and worker comes back as it was, and no bytes can do more than be refused.

#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstring>
#include <limits>

#include "ch5_backend/consistency/gauge_freedom.h"
#include "ch5_backend/simulate/random.h"
#include "ch5_homework/judge/remote/wire.h"
#include "ch5_homework/judge/scenes/bundle.h"
#include "ch5_homework/judge/scenes/windows.h"
#include "ch5_homework/judge/stage_6_scene.h"

namespace ch5::homework {
namespace {

template <typename T>
std::string Bytes(const T& value) {
  Writer out;
  if constexpr (std::is_integral_v<T>) {
    out.Int(static_cast<int64_t>(value));
  } else if constexpr (std::is_same_v<T, std::string>) {
    out.String(value);
  } else if constexpr (std::is_same_v<T, Values>) {
    out.All(value);
  } else {
    out.Matrix(value);
  }
  return out.Bytes();
}

// Reads what is one T, or throws.
template <typename T>
T ReadAs(const std::string& bytes) {
  Reader in(bytes);
  T value;
  if constexpr (std::is_same_v<T, bool>) {
    value = in.Bool();
  } else if constexpr (std::is_integral_v<T>) {
    value = in.Int();
  } else if constexpr (std::is_same_v<T, std::string>) {
    value = in.String();
  } else if constexpr (std::is_same_v<T, Values>) {
    in.All(&value);
  } else {
    value = in.Matrix();
  }
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
  EXPECT_EQ(ReadAs<int64_t>(Bytes(-5)), -5);
  EXPECT_EQ(ReadAs<bool>(Bytes(true)), true);
}

TEST(Wire, ValuesComeBackByName) {
  Transform T{Qd(0.5, 0.1, -0.7, 0.5), Vec3(1, 2, 3)};
  Values values{{"A", MatXX::Identity(2, 3)}, {"word", "a b"}, {"x", 0.1}, {"n", -3}, {"T", T}};
  values.Put("x", 7.0);  // a second one is not taken
  const Values back = ReadAs<Values>(Bytes(values));
  EXPECT_EQ(back.size(), 5u);
  EXPECT_EQ(back["A"], MatXX::Identity(2, 3));
  EXPECT_EQ(back.Word("word"), "a b");
  EXPECT_EQ(back.Number("x"), 0.1);
  EXPECT_EQ(back.Int("n"), -3);
  EXPECT_EQ(back.Pose("T").q.coeffs(), T.q.coeffs());
  EXPECT_EQ(back.Pose("T").p, T.p);
}

TEST(Wire, AValueThatDoesNotFitIsRefused) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const Values values{{"A", MatXX::Identity(2, 3)}, {"word", "x"}, {"half", 0.5}, {"nan", nan}, {"huge", 1e300}};
  EXPECT_THROW(values["B"], WireError);
  EXPECT_THROW(values["word"], WireError);
  EXPECT_THROW(values.Word("A"), WireError);
  EXPECT_THROW(values.Sized("A", 3, 2), WireError);
  EXPECT_THROW(values.Vector("A"), WireError);
  EXPECT_THROW(values.Number("A"), WireError);
  EXPECT_THROW(values.Pose("A"), WireError);
  for (const char* name : {"half", "nan", "huge"}) EXPECT_THROW(values.Int(name), WireError);
}

TEST(Wire, WhatAnExceptionHasEndedIsJudgedUpToThere) {
  Answer answer;
  answer.Put("first", 1.0);
  answer.SetFailure(std::make_exception_ptr(std::logic_error("TODO 3 is not started")));
  EXPECT_EQ(answer.Number("first"), 1.0);
  EXPECT_THROW(answer.Number("second"), std::logic_error);
}

TEST(Wire, WhatNobodyHasReadIsCounted) {
  Answer::Unread() = 0;
  {
    Answer answer;
    answer.Put("read", 1.0);
    answer.Put("not read", 1.0);
    answer.Number("read");
    const Answer moved = std::move(answer);
  }
  EXPECT_EQ(Answer::Unread(), 1);
}

// What a worker has of a scene: built anew.
std::unique_ptr<Scene> Fetched(Scene* scene) {
  Values given;
  scene->Describe(&given);
  return Scene::Make(ReadAs<Values>(Bytes(given)));
}

std::string StatesOf(const VertexList& vertices) {
  std::string states;
  for (const auto& vertex : vertices) states += Bytes(VecX(vertex->Parameters())) + Bytes(vertex->IsFixed());
  return states;
}

std::vector<size_t> PlacesOf(const VertexList& some, const VertexList& all) {
  std::vector<size_t> places;
  for (const auto& vertex : some) places.push_back(std::find(all.begin(), all.end(), vertex) - all.begin());
  return places;
}

void ExpectTheSameBits(Scene* one, Scene* other) {
  EXPECT_EQ(StatesOf(one->Vertices()), StatesOf(other->Vertices()));
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
      ExpectTheSameBits(scene, Fetched(scene).get());
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

TEST(Wire, ASceneHasTheJudgesStates) {
  GraphScene row("row", {0});
  row.poses[2]->SetFixed();
  row.points[1]->Plus(Vec3(1, 2, 3).data());
  ExpectTheSameBits(&row, Fetched(&row).get());
  Values given;
  row.Describe(&given);
  EXPECT_THROW(MakeScene<WindowScene>(given), std::bad_cast);
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
  EXPECT_THROW(ReadAs<MatXX>(Bytes(1 << 30) + Bytes(1 << 30)), WireError);
  EXPECT_THROW(ReadAs<MatXX>(Bytes(-1) + Bytes(3)), WireError);
  EXPECT_THROW(ReadAs<MatXX>(Bytes(4096) + Bytes(4096)), WireError);  // and no memory is taken for it
  EXPECT_THROW(ReadAs<Values>(Bytes(int64_t{1} << 40)), WireError);
  EXPECT_THROW(ReadAs<Values>(Bytes(kMaxValues + 1) + std::string(1 << 20, '\0')), WireError);
  const std::string name = Bytes(std::string("A")), two = name + Bytes(true) + Bytes(MatXX(0, 0));
  EXPECT_THROW(ReadAs<Values>(Bytes(2) + two + two), WireError);
  EXPECT_THROW(ReadAs<Values>(Bytes(1) + name + Bytes(2) + Bytes(MatXX(0, 0))), WireError);  // neither matrix nor word
  EXPECT_THROW(ReadAs<bool>(Bytes(2)), WireError);
  EXPECT_THROW(ReadAs<int64_t>(Bytes(1) + "x"), WireError);
}

// What both sides do with bytes; only exceptions may come of it.
void TryToRead(const std::string& bytes) {
  const auto attempt = [](const auto& read) {
    try {
      read();
    } catch (const std::exception&) {
    }
  };
  attempt([&] { Scene::Make(ReadAs<Values>(bytes)); });
  attempt([&] {
    const Values values = ReadAs<Values>(bytes);
    values.ForEach([&](const std::string& one, const Values::Value&) {
      attempt([&] { values.Int(one); });
      attempt([&] { values.Pose(one); });
      attempt([&] { values.Word(one); });
    });
  });
  attempt([&] {
    std::string rest = bytes;
    while (TakeFrame(&rest)) {
    }
  });
}

TEST(Wire, RandomBytesAreRefusedForASecond) {
  Random random(3);
  GraphScene row("row", {0});
  Values described;
  row.Describe(&described);
  const std::string whole = Bytes(described), few = Bytes(Values{{"A", MatXX::Ones(2, 2)}, {"word", "x"}});
  const auto until = std::chrono::steady_clock::now() + std::chrono::seconds(1);
  int tries = 0;
  while (std::chrono::steady_clock::now() < until) {
    std::string bytes = tries % 3 == 0 ? whole : tries % 3 == 1 ? few : std::string(random.Bits() % 300, 'c');
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
