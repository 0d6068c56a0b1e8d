#include "ch5_backend/files/window_dump.h"

#include <cmath>
#include <limits>
#include <set>

namespace ch5 {
namespace {

using Block = WindowDump::BlockKind;

// Reads the records in their order; each Read… stops where the next begins.
class WindowDumpReader {
 public:
  explicit WindowDumpReader(const std::string& path) : reader_(path) {}

  WindowDump Read() {
    reader_.ExpectWord("VIOWIN");
    reader_.ReadInt("version", 1, 1);
    ReadModel();
    ReadFrames();
    ReadImu();
    ReadLandmarks();
    ReadPrior();
    ReadFixedFrames();
    reader_.ExpectWord("END");
    reader_.ExpectEnd();
    return std::move(dump_);
  }

 private:
  static constexpr int kMost = std::numeric_limits<int>::max();

  double Number(const char* what) { return reader_.ReadDouble(what); }
  double Positive(const char* what) {
    const double x = Number(what);
    if (!(x > 0.0)) reader_.Fail(std::string(what) + ": must be positive, got " + std::to_string(x));
    return x;
  }
  // In braces one is read after the other.
  Vec2 Vector2(const char* what) { return {Number(what), Number(what)}; }
  Vec3 Vector3(const char* what) { return {Number(what), Number(what), Number(what)}; }
  int Frame(const char* what) { return reader_.ReadInt(what, 0, static_cast<int>(dump_.frames.size()) - 1); }

  // Each number takes at least a digit and a space: counts that the file cannot hold are refused at once.
  void RequireRoomFor(int64_t numbers, const char* what) {
    if (2 * numbers <= static_cast<int64_t>(reader_.BytesLeft()) + 1) return;
    reader_.Fail(std::string(what) + ": " + std::to_string(numbers) + " numbers cannot be in the " +
                 std::to_string(reader_.BytesLeft()) + " bytes that follow");
  }

  // A count of records of at least `numbers` numbers each.
  int Count(const char* what, int numbers) {
    const int count = reader_.ReadInt(what, 0, kMost);
    RequireRoomFor(static_cast<int64_t>(count) * numbers, what);
    return count;
  }

  // In seconds, such that nanoseconds fit into 64 bits.
  double Time() {
    const double t = Number("time");
    if (std::abs(t) > 9.2e9) reader_.Fail("time: must lie within ±9.2e9 s, got " + std::to_string(t));
    return t;
  }

  Transform Pose() {
    Transform T;
    T.p = Vector3("position");
    const Vec3 v = Vector3("quaternion");
    const double w = Number("quaternion");
    T.q = Qd(w, v.x(), v.y(), v.z());
    if (!(std::abs(T.q.norm() - 1.0) < 1e-3)) {
      reader_.Fail("quaternion: must be of length 1, got " + std::to_string(T.q.norm()));
    }
    T.q.normalize();
    return T;
  }

  StampedState State(double t) {
    return {t, Pose(), Vector3("velocity"), Vector3("accelerometer bias"), Vector3("gyroscope bias")};
  }

  void ReadModel() {
    reader_.ExpectWord("G");
    dump_.reaction = Vector3("gravity");
    reader_.ExpectWord("NOISE");
    dump_.noise.accelerometer = Positive("acc_n");
    dump_.noise.gyroscope = Positive("gyr_n");
    dump_.noise.accelerometer_walk = Positive("acc_w");
    dump_.noise.gyroscope_walk = Positive("gyr_w");
    reader_.ExpectWord("SQRTINFO");
    dump_.sqrt_information = Positive("sqrt information");
    reader_.ExpectWord("LOSS");
    dump_.loss = ReadLoss();
    dump_.loss_parameter = dump_.loss == WindowDump::Loss::kNone ? Number("loss") : Positive("loss");
    reader_.ExpectWord("EXT");
    dump_.T_B_C = Pose();
    dump_.extrinsic_fixed = reader_.ReadInt("fixed", 0, 1) == 1;
  }

  WindowDump::Loss ReadLoss() {
    const std::string_view name = reader_.ReadWord("loss");
    if (name == "none") return WindowDump::Loss::kNone;
    if (name == "huber") return WindowDump::Loss::kHuber;
    if (name == "cauchy") return WindowDump::Loss::kCauchy;
    reader_.Fail("loss: must be none, huber or cauchy, got " + TextReader::Quote(name));
  }

  void ReadFrames() {
    reader_.ExpectWord("FRAMES");
    const int count = Count("number of frames", 35);
    for (int i = 0; i < count; ++i) {
      reader_.BeginRecord("frame", i);
      reader_.ExpectWord("F");
      reader_.ReadInt("index", i, i);
      dump_.frames.push_back(State(Time()));
      reader_.ExpectWord("T");
      reader_.ReadInt("index", i, i);
      dump_.truth.push_back(State(dump_.frames.back().t));
    }
    reader_.EndRecord();
  }

  void ReadImu() {
    reader_.ExpectWord("IMUS");
    const int count = Count("number of IMU intervals", 10);
    for (int k = 0; k < count; ++k) {
      reader_.BeginRecord("IMU interval", k);
      reader_.ExpectWord("I");
      WindowDump::ImuInterval& interval = dump_.imu.emplace_back();
      interval.i = Frame("frame i");
      interval.j = Frame("frame j");
      if (interval.i == interval.j)
        reader_.Fail("frame j: must differ from frame i, got " + std::to_string(interval.j));
      const int samples = Count("number of samples", 7);
      if (samples < 2) reader_.Fail("number of samples: must be 2 or more, got " + std::to_string(samples));
      interval.b_a = Vector3("accelerometer bias");
      interval.b_g = Vector3("gyroscope bias");
      for (int n = 0; n < samples; ++n) interval.samples.push_back(Sample(n == 0));
    }
    reader_.EndRecord();
  }

  ImuSample Sample(bool is_first) {
    ImuSample sample;
    sample.dt = is_first ? Number("dt") : Positive("dt");
    if (is_first && sample.dt != 0.0)
      reader_.Fail("dt: must be 0 in the first sample, got " + std::to_string(sample.dt));
    sample.acceleration = Vector3("acceleration");
    sample.gyroscope = Vector3("rate");
    return sample;
  }

  void ReadLandmarks() {
    reader_.ExpectWord("LANDMARKS");
    const int count = Count("number of landmarks", 8);
    for (int k = 0; k < count; ++k) {
      reader_.BeginRecord("landmark", k);
      reader_.ExpectWord("L");
      WindowDump::Landmark& landmark = dump_.landmarks.emplace_back();
      landmark.id = reader_.ReadInt("id", 0, kMost);
      landmark.host = Frame("host");
      const int observations = Count("number of observations", 3);
      landmark.inverse_depth = Number("inverse depth");
      if (!std::isfinite(1.0 / landmark.inverse_depth)) reader_.Fail("inverse depth: must not be 0");
      landmark.true_inverse_depth = Number("true inverse depth");
      landmark.x_host = Vector2("host's observation");
      std::set<int> seen = {landmark.host};
      for (int n = 0; n < observations; ++n) {
        const int frame = Frame("frame");
        if (!seen.insert(frame).second) reader_.Fail("frame: seen twice from it, got " + std::to_string(frame));
        landmark.observations.push_back({frame, Vector2("observation")});
      }
    }
    reader_.EndRecord();
  }

  void ReadPrior() {
    reader_.ExpectWord("PRIOR");
    const int rows = Count("rows of the prior", 1);
    const int blocks = Count("blocks of the prior", 10);
    int columns = 0;
    std::set<std::pair<Block, int>> seen;
    for (int k = 0; k < blocks; ++k) {
      reader_.BeginRecord("prior block", k);
      dump_.prior_blocks.push_back(PriorBlock());
      const WindowDump::PriorBlock& block = dump_.prior_blocks.back();
      if (!seen.emplace(block.kind, block.frame).second) reader_.Fail("the prior has this block already");
      columns += block.LocalDimension();
    }
    reader_.EndRecord();
    if (rows == 0) return;
    reader_.ExpectWord("R");
    dump_.prior_r.resize(rows);
    for (double& x : dump_.prior_r) x = Number("prior's residual");
    reader_.ExpectWord("J");
    RequireRoomFor(static_cast<int64_t>(rows) * columns, "prior's Jacobian");
    dump_.prior_J.resize(rows, columns);
    for (int i = 0; i < rows; ++i) {
      reader_.BeginRecord("prior's Jacobian, row", i);
      for (int j = 0; j < columns; ++j) dump_.prior_J(i, j) = Number("entry");
    }
    reader_.EndRecord();
  }

  WindowDump::PriorBlock PriorBlock() {
    WindowDump::PriorBlock block;
    reader_.ExpectWord("B");
    const std::string_view kind = reader_.ReadWord("kind");
    if (kind != "P" && kind != "S" && kind != "E") {
      reader_.Fail("kind: must be P, S or E, got " + TextReader::Quote(kind));
    }
    block.kind = kind == "P" ? Block::kPose : kind == "S" ? Block::kSpeedBias : Block::kExtrinsic;
    if (block.kind == Block::kSpeedBias && dump_.imu.empty()) {
      reader_.Fail("kind: speed and biases need an IMU, and this window has none, got " + TextReader::Quote(kind));
    }
    block.frame = block.kind == Block::kExtrinsic ? reader_.ReadInt("index", 0, 0) : Frame("frame");
    const int size = block.kind == Block::kSpeedBias ? 9 : 7;
    reader_.ReadInt("size", size, size);
    block.x0.resize(size);
    if (size == 7) {
      const Transform T = Pose();
      block.x0 << T.p, T.q.coeffs();
    } else {
      for (double& x : block.x0) x = Number("speed-bias");
    }
    return block;
  }

  void ReadFixedFrames() {
    reader_.ExpectWord("FIXED");
    const int count = Count("number of fixed frames", 1);
    for (int k = 0; k < count; ++k) dump_.fixed_frames.push_back(Frame("fixed frame"));
  }

  TextReader reader_;
  WindowDump dump_;
};

}  // namespace

WindowDump ReadWindowDump(const std::filesystem::path& path) { return WindowDumpReader(path.string()).Read(); }

}  // namespace ch5
