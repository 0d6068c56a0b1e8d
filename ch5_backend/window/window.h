#pragma once
/// A sliding window as plain values: the states of a few images, the landmarks they see, and one prior for all that
/// has left.
///
///   frames      f₀ ──IMU── f₁ ──IMU── f₂ ── … ──IMU── f_n        pose, speed and biases each
///   landmarks      ╲____╲____╱   inverse depth in the camera of the host, the first frame that sees it
///   prior       on whatever was tied to something marginalised
///
/// From these values BuildGraph makes a graph for one solve. A policy (VINS's, OKVIS's) decides what leaves.

#include <map>
#include <memory>
#include <vector>

#include "ch5_backend/consistency/observability.h"
#include "ch5_backend/graph/graph.h"
#include "ch5_backend/marginalize/square_root.h"
#include "ch5_backend/types/edge_imu.h"
#include "ch5_backend/types/measurements.h"

namespace ch5 {

struct WindowFrame {
  int id = 0;                 ///< counts the images of a run
  double t = 0.0;             ///< when it was taken, by the IMU's clock as far as known then [s]
  double clock_offset = 0.0;  ///< the time offset that `t` contains [s]
  bool is_keyframe = true;
  std::shared_ptr<VertexPose> pose;             ///< T_W_B
  std::shared_ptr<VertexSpeedBias> speed_bias;  ///< null once it has been marginalised without its pose
  std::shared_ptr<Preintegration> imu;          ///< from the frame before; null for the first
};

struct WindowObservation {
  int frame = 0;                 ///< id
  Vec2 x = Vec2::Zero();         ///< normalised plane
  Vec2 velocity = Vec2::Zero();  ///< dx/dt, see UpdateVelocities [1/s]
};

/// Where a track was in one of the last images.
struct RecentPoint {
  int frame = 0;   ///< id
  double t = 0.0;  ///< the camera's stamp [s]
  Vec2 x = Vec2::Zero();
};

struct WindowLandmark {
  std::vector<WindowObservation> seen;                ///< in order of time; the first is the host's
  std::shared_ptr<VertexInverseDepth> inverse_depth;  ///< in the host's camera; null until triangulated
  std::vector<RecentPoint> recent;                    ///< the last three images of the track, whatever left the window
  int images = 0;                                     ///< of the track so far
  int Host() const { return seen.front().frame; }
};

struct Window {
  std::vector<WindowFrame> frames;          ///< oldest first, ids ascend
  std::map<int, WindowLandmark> landmarks;  ///< by track id, not by address: a run repeats to the bit
  std::shared_ptr<EdgePrior> prior;         ///< null until there is one
  std::shared_ptr<Edge> gauge;              ///< holds position and yaw of a frame where a policy wants it; else null
  std::shared_ptr<VertexPose> extrinsic = std::make_shared<VertexPose>();  ///< T_B_C
  std::shared_ptr<VertexScalar> time_offset =                              ///< camera's clock is late by [s]
      std::make_shared<VertexScalar>(VertexScalar::Estimate(0.0));
  /// Which edges are to leave position and yaw alone, as they were at first (consistency/observability.h).
  FirstEstimates first_estimates = FirstEstimates::kNone;
  /// The prior tells position and yaw, as the start was told them: nobody else has to hold the gauge.
  bool knows_place = false;
  Graph graph;  ///< of the last BuildGraph

  /// Position in `frames` of the frame `id`, or −1.
  int IndexOf(int id) const;
  Transform T_B_C() const { return {extrinsic->q(), extrinsic->p()}; }
  /// Where the point was at the time of the frame's pose:  x − (td − td_k) ẋ.
  Vec2 PointOf(const WindowObservation& seen) const;
  StampedState StateOf(const WindowFrame& frame) const;
};

/// What the measurements weigh.
struct WindowWeights {
  double focal_length = 460.0;  ///< turns pixels into the normalised plane [px]
  double pixel_sigma = 1.5;     ///< of an observation [px]; VINS: √information = 460/1.5
  double cauchy = 1.0;          ///< scale of the loss on observations, in sigmas; 0: no loss
  bool noisy_hosts = false;     ///< the host's point is no more exact than the others (edge_track.h); without a loss
  double gravity = 9.81;        ///< [m/s²]
  double max_imu_seconds = 10;  ///< a longer preintegration is not used (VINS)
};

/// Makes window->graph: every frame's states, the IMU between consecutive frames that have a speed-bias, the
/// observations of the landmarks that `uses` accepts, the prior and the gauge. Where neither extrinsic nor time offset
/// is estimated (both fixed), they are constants of the edges.
void BuildGraph(const WindowWeights& weights, const std::function<bool(const Window&, const WindowLandmark&)>& uses,
                Window* window);

/// Marginalize as window->first_estimates says; the result is the window's prior.
void ReplacePrior(const std::vector<std::shared_ptr<Edge>>& edges, const std::vector<std::shared_ptr<Vertex>>& drop,
                  Window* window);

/// The edges of the graph at one of these vertices, in the order of the graph.
std::vector<std::shared_ptr<Edge>> EdgesAt(const Graph& graph, const std::vector<std::shared_ptr<Vertex>>& vertices);

}  // namespace ch5
