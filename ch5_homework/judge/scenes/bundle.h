#pragma once
/// The course's bundle adjustment (simulate/mono_ba.h): stages 1.1, 1.2, 3 and 7.

#include "ch5_backend/simulate/mono_ba.h"
#include "ch5_homework/judge/scenes/scene.h"

namespace ch5::homework {

class MonoScene : public Scene {
 public:
  Graph& GetGraph() override { return ba.graph; }
  /// An edge for each point and each frame but the first, which hosts them.
  void AddReprojections();

  MonoBaScene scene;
  MonoBa ba;

 protected:
  /// The vertices at their start, and no edges.
  MonoScene(std::string name, Sizes sizes, const MonoBaOptions& options);
};

/// Of stage 3: four frames and six points, to which the graded function adds the edges. The start is not the truth.
struct StartScene : MonoScene {
  static constexpr int kFrames = 4, kPoints = 6;

  StartScene();
};

/// With the reprojection edges. Either the first two frames are fixed, or the gauge is free and W is random.
struct BundleScene : MonoScene {
  BundleScene(int frames, int points, bool fixed);
};

}  // namespace ch5::homework
