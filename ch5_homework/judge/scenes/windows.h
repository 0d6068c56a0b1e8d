#pragma once
/// Windows for stage 6 of which everything is known.

#include "ch5_backend/window/window.h"
#include "ch5_homework/judge/scenes/scene.h"

namespace ch5::homework {

constexpr int kFirstId = 20;  // ids are no positions

constexpr int kHostedByOldest = 1, kHostedByNext = 2, kWithoutDepth = 3, kSeenTwice = 4, kHostedBySecondNew = 5,
              kHostedEarlier = 6;

/// All vertices of a window, those of its frames first.
VertexList VerticesOf(const Window& window);

///   "full window"                 eleven frames, of which the prior knows the first two and the second newest;
///                                 landmarks of each kind; as in all that say nothing else, the extrinsic is free
///   "full window without prior"   the extrinsic is fixed: no edge knows it; of what the oldest frame hosts one landmark is seen
///                                 up to the newest frame, one has a negative depth
///   "full window, other prior"    the prior knows neither of the frames that may leave
///   "long window"                 twelve frames, of which the prior knows the third and second newest; no landmarks
///   "landmark behind"             eleven frames, a landmark behind all that see it
///   "frames"                      eleven frames alone
///   "sliding window"              six frames, a prior, few landmarks; each step brings a landmark and the graph, each but
///                                 the first one a frame too
class WindowScene : public Scene {
 public:
  explicit WindowScene(const std::string& name);
  Graph& GetGraph() override { return window.graph; }
  VertexList Vertices() override { return VerticesOf(window); }

  /// Goes on to the scene's next state, as both sides do.
  void Step();

  Window window;

 private:
  Random random_;
  int steps_ = 0;
};

}  // namespace ch5::homework
