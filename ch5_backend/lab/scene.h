#pragma once
/// The course's scene as the lab's sliders set it, and the solver that they choose.

#include <memory>
#include <vector>

#include "ch5_backend/dense/problem.h"
#include "ch5_backend/lab/json.h"
#include "ch5_backend/lab/query.h"
#include "ch5_backend/simulate/mono_ba.h"

namespace ch5::lab {

enum class Solver { kDense, kBlocks, kSparse };

/// What was dragged, as pairs of a number and a shift in the plane of the picture, which is x, y of the world [m].
struct Drags {
  std::vector<Query::Item> cameras, landmarks;              ///< the scene itself; what is observed moves along
  std::vector<Query::Item> camera_starts, landmark_starts;  ///< only where the solver begins
};

struct SceneSettings {
  MonoBaOptions scene;
  bool turns_in_place = false;  ///< all cameras are at the origin: no parallax
  Drags drags;
  std::vector<Query::Item> without;  ///< landmark and frame of the observations that are left out
  Gauge gauge = Gauge::kPriorTwoFrames;
  double weight = 1.0;             ///< of the prior
  double pixel_information = 1.0;  ///< W = pixel_information·I₂
  bool is_calibrated = false;      ///< … which is that of the noise
  int outliers = 0;                ///< so many points have a wrong observation in the last frame
  int loss = 0;                    ///< none, Huber, Cauchy or Tukey …
  double delta = 1.0;              ///< … with this threshold [σ of an observation]
  Damping damping = Damping::kIdentity;
  SolveOptions options;
  Solver solver = Solver::kDense;
};

/// Names, limits and defaults of the settings; the defaults are the course's own (studies/prior_study.h).
SceneSettings ReadScene(Query* query);

/// A scene and its graph at the start. The graph must stay where it is.
struct SceneGraph {
  explicit SceneGraph(const SceneSettings& settings);
  MonoBaScene scene;
  MonoBa ba;
};

/// A landmark's observation in a frame after the first.
struct Observation {
  int landmark = 0, frame = 0;
  std::shared_ptr<Edge> edge;
};

/// Those in the graph, in its order.
std::vector<Observation> ObservationsOf(const SceneGraph& graph);

std::unique_ptr<NormalEquations> MakeSystem(const SceneSettings& settings, Graph* graph);

/// Each variable's kind ("pose", "landmark", …), number, first row in H and number of rows; fixed ones have none.
std::vector<Json> VariablesOf(const SceneGraph& graph);

/// Points and camera poses: at the truth, or at the present states.
Json Truth(const SceneGraph& graph);
Json Estimate(const SceneGraph& graph);

}  // namespace ch5::lab
