#pragma once
/// A sliding window as plain values: the states of a few images, the landmarks they see, and one prior for all that
/// has been marginalized.
///
///   frames      f₀ ──IMU── f₁ ──IMU── f₂ ── … ──IMU── f_n        pose, speed and biases each
///   landmarks      ╲____╲____╱   inverse depth in camera 0 of the host, the first frame that sees it
///   prior       on the vertices that shared an edge with something marginalized
///
/// BuildGraph makes the graph of one solve from these values. A policy (VINS's, OKVIS's) decides what leaves.

#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <vector>

#include "ch5_backend/consistency/observability.h"
#include "ch5_backend/graph/graph.h"
#include "ch5_backend/marginalize/square_root.h"
#include "ch5_backend/math/array_memory.h"
#include "ch5_backend/types/inertial/edge_imu.h"
#include "ch5_backend/types/recording.h"

namespace ch5 {

/// An image with its states.
struct Frame {
  int id = 0;                 ///< counts the images of a run
  double t = 0.0;             ///< time of the image by the IMU's clock, as estimated when it was added [s]
  double clock_offset = 0.0;  ///< the time offset contained in `t` [s]
  bool is_keyframe = true;
  std::shared_ptr<VertexPose> pose;             ///< T_W_B
  std::shared_ptr<VertexSpeedBias> speed_bias;  ///< null once marginalized without its pose
  std::shared_ptr<Preintegration> imu;          ///< from the frame before; null for the first
  std::shared_ptr<EdgeImu> imu_edge;            ///< that BuildGraph has made of it, and uses again while it is the same
  bool prior_has_imu = false;                   ///< `imu` is in the prior, so it is no edge any more
  bool is_at_rest = false;                      ///< its speed is zero to kRestSpeedSigma
};
constexpr double kRestSpeedSigma = 0.03;  ///< a hovering vehicle sways [m/s]
using WindowFrame = Frame;                // its name in homework that was written before

/// What camera 1 sees of a landmark.
struct SecondView {
  Vec2 x = Vec2::Zero();            ///< normalized plane
  Vec2 velocity = Vec2::Zero();     ///< [1/s]
  std::shared_ptr<Edge> edge = {};  ///< as WindowObservation::edge
};

/// Where a frame of the window sees a landmark.
struct WindowObservation {
  int frame = 0;                          ///< id
  Vec2 x = Vec2::Zero();                  ///< normalized plane
  Vec2 velocity = Vec2::Zero();           ///< dx/dt, see AppendToTrack [1/s]
  std::optional<SecondView> second = {};  ///< the same of camera 1, if there is one and it sees the landmark too
  std::shared_ptr<Edge> edge = {};        ///< that BuildGraph has made of it, and uses again while it is the same
};

/// A track in one of the last images.
struct RecentPoint {
  int frame = 0;   ///< id
  double t = 0.0;  ///< the camera's time stamp [s]
  Vec2 x = Vec2::Zero();
};

/// A track in one camera.
struct RecentTrack {
  Array<RecentPoint> points;  ///< in the last three images, also those no longer in the window
  int images = 0;             ///< number of images of the track so far
};

/// A track that a frame of the window hosts.
struct WindowLandmark {
  std::vector<WindowObservation> seen;                ///< in order of time; the first is the host's
  std::shared_ptr<VertexInverseDepth> inverse_depth;  ///< in the host's camera; null until triangulated
  RecentTrack recent, recent1;                        ///< in camera 0, and in camera 1
  int Host() const { return seen.front().frame; }
  /// Where the frame with this id sees it, or null.
  const WindowObservation* In(int frame) const;
};

/// What makes a prior of the edges that leave and the vertices to drop; each of these is at one of the edges.
using Marginalizer = std::function<std::shared_ptr<EdgePrior>(const std::vector<std::shared_ptr<Edge>>& edges,
                                                              const std::vector<std::shared_ptr<Vertex>>& drop)>;

/// What the edges of observations have in common.
struct ObservationModel {
  bool calibrating = false;  ///< extrinsic or time offset are estimated; else these are constants of camera 0's edges
  Transform T_B_C;           ///< the constant
  double information = 0.0, information1 = 0.0;  ///< w of each camera, W = w I on the normalized plane
  double cauchy = 0.0;                           ///< WindowWeights::cauchy
  std::shared_ptr<const LossFunction> loss;      ///< made of it

  /// Whether edges that were made for the one are right for the other, too.
  bool Fits(const ObservationModel& other) const;
};

struct Window {
  Calibration calibration;    ///< as it was given; what is estimated of it is in extrinsic and time_offset
  std::vector<Frame> frames;  ///< oldest first, ids ascend
  std::map<int, WindowLandmark> landmarks;  ///< by track id, not by address: a run repeats to the bit
  std::shared_ptr<EdgePrior> prior;         ///< null until there is one
  std::shared_ptr<Edge> gauge_prior;        ///< holds position and yaw of a frame if the policy wants it; else null
  std::shared_ptr<VertexPose> extrinsic = std::make_shared<VertexPose>();  ///< T_B_C
  std::shared_ptr<VertexPose> extrinsic1;                                  ///< that of camera 1; null with one camera
  std::shared_ptr<VertexScalar> time_offset =                              ///< delay of the camera's clock [s]
      std::make_shared<VertexScalar>(VertexScalar::Estimate(0.0));
  ObservabilityConstraints observability_constraints = ObservabilityConstraints::kNone;
  Marginalizer marginalizer;                     ///< null: Marginalize; not used with observability constraints
  bool prior_fixes_gauge = false;                ///< the prior contains position and yaw: no gauge prior is needed
  int segment = 0;                               ///< counts the estimator's starts: W is another one after a restart
  Graph graph;                                   ///< of the last BuildGraph …
  ObservationModel model;                        ///< … what its observations' edges were made for …
  std::vector<std::shared_ptr<Edge>> own_edges;  ///< … and its edges of one's own

  /// Position in `frames` of the frame `id`, or −1.
  int IndexOf(int id) const;
  Transform T_B_C() const { return {extrinsic->q(), extrinsic->p()}; }
  /// Of camera 1, which must be there.
  Transform T_B_C1() const { return {extrinsic1->q(), extrinsic1->p()}; }
  /// Whether camera 1 determines depths: it exists, and its pose on the body is known, not estimated.
  bool HasStereoDepth() const { return extrinsic1 && extrinsic1->IsFixed(); }
  /// The extrinsics: poses that are not expressed in W.
  std::vector<const Vertex*> LocalPoses() const;
  /// A point of a frame's image at the time of the frame's pose:  x − (td − td_k) ẋ.
  Vec2 PointAt(int frame, const Vec2& x, const Vec2& velocity) const;
  Vec2 PointOf(const WindowObservation& seen) const { return PointAt(seen.frame, seen.x, seen.velocity); }
  StampedState StateOf(const Frame& frame) const;
  /// Sets pose, speed and biases of a frame; its time stays.
  static void SetState(const StampedState& state, const Frame& frame);
};

/// The twist of a rotation about z (gravity): the nearest rotation about that axis. Unlike a difference of yaw angles it is
/// defined at every attitude, also at a pitch of ±90°.
inline Qd TwistAboutGravity(const Qd& Q) { return Qd(Q.w(), 0.0, 0.0, Q.z()).normalized(); }

/// The weights of the measurements.
struct WindowWeights {
  double pixel_sigma = 1.5;     ///< of an observation [px]; VINS: √information = 460/1.5
  double cauchy = 1.0;          ///< scale of Cauchy's loss on observations [σ]; 0: no loss
  bool noisy_hosts = false;     ///< the host's observation has noise too (types/visual/edge_track.h); without a loss
  double max_imu_seconds = 10;  ///< a longer preintegration is not used (VINS)

  /// @throws OptionError
  void Validate() const;
};

/// Adds edges of one's own, and vertices that they need, to the graph of a window (EstimatorOptions::own_edges).
using OwnEdges = std::function<void(const Window&, Graph*)>;

/// Makes window->graph: every frame's states, the speed of those at rest, one's own edges, the IMU between consecutive
/// frames that have a speed-bias, unless the prior has it, the observations of the landmarks that `uses` accepts, the prior
/// and the gauge prior. Where extrinsic and time offset are both fixed, they are constants of camera 0's edges.
void BuildGraph(const WindowWeights& weights, const std::function<bool(const Window&, const WindowLandmark&)>& uses,
                Window* window, const OwnEdges& own_edges = nullptr);

/// Marginalizes the vertices `drop`, with window->observability_constraints; the result replaces the window's prior.
void ReplacePrior(const std::vector<std::shared_ptr<Edge>>& edges, const std::vector<std::shared_ptr<Vertex>>& drop,
                  Window* window);

}  // namespace ch5
