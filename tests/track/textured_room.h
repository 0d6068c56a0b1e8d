#pragma once
/// Images of a room with painted walls, by casting one ray a pixel through the lens: what a tracker is tried on. The room is
/// the one of SimulateInRoom, 10 m × 10 m × 5 m.

#include <cstdint>
#include <filesystem>
#include <vector>

#include "ch5_backend/simulate/sensors/simulation.h"
#include "ch5_backend/track/lens.h"

namespace ch5 {

/// Where a ray from a point in the room meets a wall [m], in W.
Vec3 WallPoint(const Vec3& from, const Vec3& direction);

class RoomRenderer {
 public:
  RoomRenderer(const Camera& camera, const Lens& lens);
  /// Gray values row by row, with noise of σ ≈ 2.
  std::vector<uint8_t> Render(const Transform& T_W_B, uint32_t seed) const;

 private:
  Camera camera_;
  std::vector<Vec3> rays_;  ///< of the pixels, in C; 0 where the lens has none
};

struct RenderOptions {
  Lens lens;
  Calibration calibration = ForwardCamera();
  HandheldOptions path;
  bool with_truth = true;
};

/// Flies and writes a folder in EuRoC's layout: folder/mav0, with cam1 if the calibration has camera1.
void WriteRenderedFlight(const RenderOptions& options, const std::filesystem::path& folder);

}  // namespace ch5
