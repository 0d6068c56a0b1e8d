#include "ch5_backend/simulate/mono_ba.h"

#include <cmath>

#include "ch5_backend/math/option_checks.h"
#include "ch5_backend/simulate/random.h"

namespace ch5 {
namespace {

Transform FrameOnCircle(int n, int frames) {
  const double theta = 2.0 * M_PI * n / (4.0 * frames);
  const double radius = 8.0;
  Transform T_W_C;
  T_W_C.q = Qd(std::cos(0.5 * theta), 0.0, 0.0, std::sin(0.5 * theta));
  T_W_C.p = {radius * std::cos(theta) - radius, radius * std::sin(theta), std::sin(2.0 * theta)};
  return T_W_C;
}

std::vector<Vec2> PixelsOf(const std::vector<Vec3>& points, const Transform& T_W_C, double sigma, Random* random) {
  std::vector<Vec2> pixels;
  for (const Vec3& p_W : points) {
    const Vec3 p_C = T_W_C.q.conjugate() * (p_W - T_W_C.p);
    pixels.emplace_back(p_C.hnormalized() + NormalVector<2>(random, sigma));
  }
  return pixels;
}

}  // namespace

MonoBaScene SimulateMonoBa(const MonoBaOptions& options) {
  CheckOption("MonoBaOptions::frames", options.frames, 2);
  CheckOption("MonoBaOptions::points", options.points, 1);
  CheckNotNegative("MonoBaOptions::pixel_sigma", options.pixel_sigma);
  CheckNotNegative("MonoBaOptions::depth_sigma", options.depth_sigma);
  CheckNotNegative("MonoBaOptions::position_sigma", options.position_sigma);
  CheckNotNegative("MonoBaOptions::rotation_sigma", options.rotation_sigma);

  MonoBaScene scene;
  Random random(options.seed);
  for (int n = 0; n < options.frames; ++n) scene.frames.push_back(FrameOnCircle(n, options.frames));

  for (int k = 0; k < options.points; ++k) {
    scene.points.push_back(UniformVector(&random, Vec3(-4.0, -4.0, 4.0), Vec3(4.0, 4.0, 8.0)));
  }

  for (const Transform& T_W_C : scene.frames) {
    scene.pixels.push_back(PixelsOf(scene.points, T_W_C, options.pixel_sigma, &random));
  }

  for (const Vec3& p_W : scene.points) {
    const double depth = (scene.frames[0].q.conjugate() * (p_W - scene.frames[0].p)).z();
    // Depths are at least 4 m. Three sigmas of the course's 1 m keep them positive; the floor keeps any noise so.
    const double noisy = depth + options.depth_sigma * random.TruncatedNormal(3.0);
    scene.initial_inverse_depths.push_back(1.0 / std::max(noisy, 0.1 * depth));
  }

  for (const Transform& T_W_C : scene.frames) {
    const Vec3 dp = NormalVector(&random, options.position_sigma);
    const Vec3 dtheta = NormalVector(&random, options.rotation_sigma);
    scene.initial_frames.push_back({T_W_C.q * ExpSO3(dtheta), T_W_C.p + dp});
  }
  return scene;
}

}  // namespace ch5
