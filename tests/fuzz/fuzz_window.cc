// Any bytes as a window: it is refused with a FileError, or its indices and sizes can be relied on.
#include <cmath>

#include "ch5_backend/files/window_dump.h"
#include "tests/fuzz/memory_file.h"

namespace {

using namespace ch5;

void CheckPrior(const WindowDump& dump) {
  Eigen::Index columns = 0;
  for (const WindowDump::PriorBlock& block : dump.prior_blocks) {
    columns += block.LocalDimension();
    fuzz::Require(block.x0.allFinite() && block.x0.size() == (block.LocalDimension() == 9 ? 9 : 7), "x0 has its size");
  }
  const Eigen::Index rows = dump.prior_r.size();
  if (rows == 0) return;
  fuzz::Require(dump.prior_J.rows() == rows && dump.prior_J.cols() == columns, "J is as large as r and the blocks");
  fuzz::Require(dump.prior_J.allFinite() && dump.prior_r.allFinite(), "the prior's numbers are finite");
}

void Check(const WindowDump& dump) {
  const int frames = static_cast<int>(dump.frames.size());
  const auto require_frame = [&](int k) { fuzz::Require(k >= 0 && k < frames, "a frame that is named exists"); };
  fuzz::Require(dump.truth.size() == dump.frames.size(), "each frame has its truth");
  for (const StampedState& state : dump.frames) {
    fuzz::Require(std::abs(state.T_W_B.q.norm() - 1.0) < 1e-12, "rotations are of length 1");
  }
  for (const WindowDump::ImuInterval& interval : dump.imu) {
    require_frame(interval.i);
    require_frame(interval.j);
    for (size_t n = 1; n < interval.samples.size(); ++n) fuzz::Require(interval.samples[n].dt > 0.0, "time goes on");
  }
  for (const WindowDump::Landmark& landmark : dump.landmarks) {
    require_frame(landmark.host);
    fuzz::Require(std::isfinite(1.0 / landmark.inverse_depth), "a landmark has a depth");
    for (const WindowDump::Observation& observation : landmark.observations) require_frame(observation.frame);
  }
  for (const WindowDump::PriorBlock& block : dump.prior_blocks) {
    if (block.kind != WindowDump::BlockKind::kExtrinsic) require_frame(block.frame);
  }
  for (const int k : dump.fixed_frames) require_frame(k);
  CheckPrior(dump);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  static const fuzz::MemoryFile file;
  file.Set(fuzz::Text(data, size));
  try {
    Check(ReadWindowDump(file.Path()));
  } catch (const FileError&) {
  }
  return 0;
}
