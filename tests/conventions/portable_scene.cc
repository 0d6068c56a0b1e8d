// Prints one hash per part of the course's scene, over the bits of its doubles. Every compiler must print the same.
//
// The sources are included, not linked: one translation unit compiles twice as fast, and this test compiles it
// for six settings.
#include <cstdio>
#include <cstring>

#include "ch5_backend/math/option_checks.cc"  // NOLINT(bugprone-suspicious-include)
#include "ch5_backend/math/so3.cc"            // NOLINT(bugprone-suspicious-include)
#include "ch5_backend/simulate/mono_ba.cc"    // NOLINT(bugprone-suspicious-include)

namespace {

// FNV-1a, 64 bits.
class Hash {
 public:
  void Add(double value) {
    unsigned char bytes[sizeof value];
    std::memcpy(bytes, &value, sizeof value);
    for (const unsigned char byte : bytes) hash_ = (hash_ ^ byte) * 0x100000001b3u;
  }
  template <typename Matrix>
  void AddAll(const Matrix& m) {
    for (Eigen::Index i = 0; i < m.size(); ++i) Add(m[i]);
  }
  void Print(const char* scene, const char* part) const {
    std::printf("%s %s %016llx\n", scene, part, static_cast<unsigned long long>(hash_));
  }

 private:
  uint64_t hash_ = 0xcbf29ce484222325u;
};

void PrintScene(const char* name, const ch5::MonoBaOptions& options) {
  const ch5::MonoBaScene scene = ch5::SimulateMonoBa(options);
  Hash points, frames, pixels, depths, initial_frames;
  for (const auto& p : scene.points) points.AddAll(p);
  for (const auto& T : scene.frames) frames.AddAll(T.q.coeffs()), frames.AddAll(T.p);
  for (const auto& image : scene.pixels) {
    for (const auto& u : image) pixels.AddAll(u);
  }
  for (const double inverse_depth : scene.initial_inverse_depths) depths.Add(inverse_depth);
  for (const auto& T : scene.initial_frames) initial_frames.AddAll(T.q.coeffs()), initial_frames.AddAll(T.p);
  points.Print(name, "points");
  frames.Print(name, "frames");
  pixels.Print(name, "pixels");
  depths.Print(name, "initial-inverse-depths");
  initial_frames.Print(name, "initial-frames");
}

}  // namespace

int main() {
  PrintScene("course", {});
  ch5::MonoBaOptions large;
  large.frames = 30;
  large.points = 1000;
  large.position_sigma = 0.1;
  large.rotation_sigma = 0.05;
  PrintScene("large", large);
}
