/// Stage 6, TODOs 6g and 6h: what MARGIN_OLD and MARGIN_SECOND_NEW marginalize. stage_6_slide.cc goes on.

#include <gtest/gtest.h>

#include <algorithm>
#include <set>

#include "ch5_homework/judge/diagnosis.h"
#include "ch5_homework/judge/stage_6_window.h"

namespace ch5::homework {
namespace {

Text CauseOfVertices(const Window& window, const DropSet& drop) {
  const auto& frames = window.frames;
  const auto has = [&](const std::shared_ptr<Vertex>& vertex) { return Holds(drop.vertices, vertex); };
  const auto depth = [&](int track) { return has(window.landmarks.at(track).inverse_depth); };
  if (has(nullptr)) return "6.landmark_without_depth";
  if (drop.vertices.empty()) return "6.no_vertex_named";
  if (has(window.extrinsic)) return "6.extrinsic_goes";
  if (!has(frames[0].pose) && has(frames[1].pose)) return "6.second_oldest_for_oldest";
  if (!has(frames[0].pose) && has(frames.back().pose)) return "6.newest_for_oldest";
  if (!has(frames[0].pose)) return "6.oldest_frames_pose_stays";
  if (has(frames[1].speed_bias)) return "6.speed_biases_second_oldest_frame_go";
  if (has(frames[1].pose)) return "6.second_oldest_frames_pose_goes";
  if (!has(frames[0].speed_bias)) return "6.oldest_frames_speed_biases_stay";
  if (depth(kHostedByNext)) return "6.depth_another_frame_hosts_goes";
  if (depth(kHostedByOldest) != depth(kSeenTwice)) return "6.some_depths_oldest_frame_hosts_stay";
  if (!depth(kHostedByOldest)) return "6.depths_oldest_frame_hosts_stay";
  return {};
}

Text CauseOfEdges(const DropSet& drop, const DropSet& right) {
  if (drop.edges.empty()) return "6.no_edge_named";
  if (std::set<std::shared_ptr<Edge>>(drop.edges.begin(), drop.edges.end()).size() < drop.edges.size()) {
    return "6.edge_named_twice";
  }
  if (Count(drop, "EdgePrior") < Count(right, "EdgePrior")) return "6.old_prior_missing";
  if (Count(drop, "EdgeImu") < 1) return "6.IMU_missing";
  if (Count(drop, "EdgeImu") > 1) return "6.other_IMU_swallowed";
  const int seen = Count(drop, "EdgeReprojection"), wanted = Count(right, "EdgeReprojection");
  if (seen < wanted) return "6.observations_missing";
  if (seen > wanted) return "6.other_observations_swallowed";
  return "6.edge_named_twice";
}

void CheckMarginOld(const char* name, const Text& words) {
  WindowScene scene(name);
  const DropSet drop = AskForDropSet(&scene, MarginalizationFlag::kOld), right = RightMarginOld(scene.window);
  if (Same(drop, right)) return;
  const bool asks_the_prior = drop.vertices.empty() || std::count(drop.edges.begin(), drop.edges.end(), nullptr) > 0;
  Text cause = asks_the_prior && !scene.window.prior ? "6.without_prior_one_edge_less" : Text();
  if (cause.empty()) cause = CauseOfVertices(scene.window, drop);
  if (cause.empty()) cause = CauseOfEdges(drop, right);
  Fail({words, Inventory(right), Inventory(drop), cause, "6g"});
}

TEST(Stage6, MarginOldTakesTheOldestFrameAndWhatItHosts) { CheckMarginOld("full window", "6.margin_old_full_window"); }

TEST(Stage6, MarginOldWithoutAPrior) { CheckMarginOld("full window without prior", "6.margin_old_without_prior"); }

Text CauseOfSecondNew(const Window& window, const DropSet& drop) {
  const auto& frames = window.frames;
  const auto has = [&](size_t k) { return Holds(drop.vertices, frames[k].pose); };
  if (drop.edges.empty()) return "6.prior_holds_pose";
  if (Count(drop, "EdgeReprojection") > 0) return "6.observations_swallowed";
  if (Count(drop, "EdgeImu") > 0) return "6.IMU_swallowed";
  const size_t newest = frames.size() - 1;
  if (has(newest - 1) && drop.vertices.size() > 1) return "6.others_go_with_second_newest";
  if (has(newest)) return "6.newest_for_second_newest";
  if (has(newest - 2)) return "6.third_newest_for_second_newest";
  if (has(0)) return "6.MARGIN_OLDs_pose";
  if (Holds(drop.vertices, window.extrinsic)) return "6.extrinsic_goes";
  return has(newest - 1) ? "6.prior_only_edge" : "6.second_newest_pose_missing";
}

TEST(Stage6, MarginSecondNewTakesOnePoseFromThePrior) {
  for (const char* name : {"full window", "long window"}) {
    WindowScene scene(name);
    const Window& window = scene.window;
    const DropSet right{{window.prior}, {window.frames[window.frames.size() - 2].pose}};
    const DropSet drop = AskForDropSet(&scene, MarginalizationFlag::kSecondNew);
    if (Same(drop, right)) continue;
    Fail({"6.margin_second_new", Inventory(right), Inventory(drop), CauseOfSecondNew(window, drop), "6h"});
  }
}

// Who never marginalizes passes nothing: first a window in which there is something to do.
TEST(Stage6, MarginSecondNewRestsWithoutAPriorOnThatPose) {
  WindowScene full("full window");
  const DropSet something = AskForDropSet(&full, MarginalizationFlag::kSecondNew);
  if (something.edges.empty()) {
    Fail({"6.margin_second_new", Inventory({{full.window.prior}, {full.window.frames[9].pose}}), Inventory(something),
          "6.prior_holds_pose", "6h"});
  }
  for (const bool with_prior : {true, false}) {
    WindowScene scene(with_prior ? "full window, other prior" : "full window without prior");
    const DropSet drop = AskForDropSet(&scene, MarginalizationFlag::kSecondNew);
    if (drop.edges.empty()) continue;
    Fail({with_prior ? "6.margin_second_new_prior_elsewhere" : "6.margin_second_new_without_prior",
          "6.nothing_marginalize", Inventory(drop),
          with_prior ? "6.ask_first_whether_prior_holds_pose" : "6.ask_first_whether_prior", "6h"});
  }
}

}  // namespace
}  // namespace ch5::homework
