/// Stage 6, TODOs 6g and 6h: what MARGIN_OLD and MARGIN_SECOND_NEW marginalise. stage_6_slide.cc goes on.

#include <gtest/gtest.h>

#include "ch5_homework/judge/narrate.h"
#include "ch5_homework/judge/stage_6_window.h"

namespace ch5::homework {
namespace {

std::string CauseOfVertices(const Window& window, const DropSet& drop) {
  const auto& frames = window.frames;
  const auto has = [&](const std::shared_ptr<Vertex>& vertex) { return Holds(drop.vertices, vertex); };
  const auto depth = [&](int track) { return has(window.landmarks.at(track).inverse_depth); };
  if (has(nullptr)) return "a landmark that has no depth yet has no vertex: ask for landmark.inverse_depth too";
  if (drop.vertices.empty()) return "no vertex is named: nothing would be dropped";
  if (!has(frames[0].pose) && has(frames[1].pose))
    return "frames[1] is the second oldest; the oldest is frames.front()";
  if (!has(frames[0].pose) && has(frames.back().pose))
    return "frames.back() is the newest; the oldest is frames.front()";
  if (!has(frames[0].pose)) return "the oldest frame's pose stays, but its frame goes";
  if (has(frames[1].speed_bias)) return "the speed and biases of the second oldest frame go, but that frame stays";
  if (has(frames[1].pose)) return "the second oldest frame's pose goes, but that frame stays";
  if (!has(frames[0].speed_bias)) return "the oldest frame's speed and biases stay, but their frame goes";
  if (depth(kHostedByNext)) return "a depth that another frame hosts goes: ask for landmark.Host() == oldest.id";
  if (!depth(kHostedByOldest)) return "the depths that the oldest frame hosts stay, but they stand in its camera";
  return "";
}

std::string CauseOfEdges(const DropSet& drop, const DropSet& right) {
  if (drop.edges.empty()) return "no edge is named: the frame would be thrown away, not marginalised";
  if (Count(drop, "EdgePrior") < 1) return "the old prior is missing: what it knew of this frame would be lost";
  if (Count(drop, "EdgeImu") < 1) return "the IMU between frames 0 and 1 is missing: nothing ties speed and biases";
  if (Count(drop, "EdgeImu") > 1) return "an IMU piece behind frame 1 is swallowed too; it stays in the window";
  const int seen = Count(drop, "EdgeReprojection"), wanted = Count(right, "EdgeReprojection");
  if (seen < wanted) return "observations of the landmarks hosted there are missing: they would be thrown away";
  if (seen > wanted) return "observations of landmarks that stay are swallowed too, and would count twice";
  return "an edge is named twice, or another edge stands in its place";
}

TEST(Stage6, MarginOldTakesTheOldestFrameAndWhatItHosts) {
  const Window window = FullWindow();
  const DropSet drop = Chosen().vins_window.margin_old(window), right = RightMarginOld(window);
  if (Same(drop, right)) return;
  std::string cause = CauseOfVertices(window, drop);
  if (cause.empty()) cause = CauseOfEdges(drop, right);
  FAIL() << Story("6", "DropSetOfMarginOld of 11 frames, the oldest hosts two depths and one track without depth",
                  Inventory(right), Inventory(drop), cause, "6g");
}

TEST(Stage6, MarginOldWithoutAPrior) {
  Window window = FullWindow();
  window.prior = nullptr;
  BuildGraph({}, UseAll, &window);
  const DropSet drop = Chosen().vins_window.margin_old(window), right = RightMarginOld(window);
  if (Same(drop, right)) return;
  FAIL() << Story("6", "DropSetOfMarginOld of the first full window, when there is no prior yet", Inventory(right),
                  Inventory(drop), "without a prior there is one edge less; all else is as before", "6g");
}

std::string CauseOfSecondNew(const Window& window, const DropSet& drop) {
  const auto& frames = window.frames;
  const auto has = [&](size_t k) { return Holds(drop.vertices, frames[k].pose); };
  if (drop.edges.empty()) return "the prior holds that pose, so there is something to marginalise";
  if (Count(drop, "EdgeReprojection") > 0) {
    return "observations are swallowed: what this frame saw is discarded, its neighbours see the same again";
  }
  if (Count(drop, "EdgeImu") > 0) return "the IMU is swallowed: its samples go to the newest frame, in SlideWindow";
  if (Holds(drop.vertices, frames[9].speed_bias)) return "its speed and biases go with the merged IMU, not here";
  if (has(10)) return "frames.size() − 1 is the newest frame; the second newest is frames.size() − 2";
  if (has(8)) return "frames.size() − 3 is the third newest frame; the second newest is frames.size() − 2";
  if (has(0)) return "this is MARGIN_OLD's pose; here the second newest frame's goes";
  return has(9) ? "the prior is the only edge" : "the second newest frame's pose is not among the vertices";
}

TEST(Stage6, MarginSecondNewTakesOnePoseFromThePrior) {
  const Window window = FullWindow();
  const DropSet right{{window.prior}, {window.frames[9].pose}};
  const DropSet drop = Chosen().vins_window.margin_second_new(window);
  if (Same(drop, right)) return;
  FAIL() << Story("6", "DropSetOfMarginSecondNew where the prior holds that frame's pose", Inventory(right),
                  Inventory(drop), CauseOfSecondNew(window, drop), "6h");
}

TEST(Stage6, MarginSecondNewRestsWithoutAPriorOnThatPose) {
  for (const bool with_prior : {true, false}) {
    Window window = FullWindow();
    window.prior = with_prior ? PriorOn({window.frames[1].pose, window.frames[8].pose}) : nullptr;
    BuildGraph({}, UseAll, &window);
    const DropSet drop = Chosen().vins_window.margin_second_new(window);
    if (drop.edges.empty()) continue;
    FAIL() << Story("6",
                    with_prior ? "DropSetOfMarginSecondNew where the prior holds other poses only"
                               : "DropSetOfMarginSecondNew where there is no prior",
                    "nothing to marginalise: no edge", Inventory(drop),
                    with_prior ? "ask first whether the prior holds the pose" : "ask first whether there is a prior",
                    "6h");
  }
}

}  // namespace
}  // namespace ch5::homework
