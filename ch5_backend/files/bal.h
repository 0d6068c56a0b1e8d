#pragma once
/// "Bundle Adjustment in the Large" problems (Agarwal et al., ECCV 2010) as files, values and graphs.
///
/// The file: `cameras points observations`; per observation `camera point x y` [px, y up]; 9 numbers a camera
/// (angle-axis ω, translation t, focal length f, distortion k1, k2; see EdgeBAL), 3 numbers a point.

#include <memory>
#include <string>
#include <vector>

#include "ch5_backend/files/text_reader.h"
#include "ch5_backend/graph/graph.h"
#include "ch5_backend/types/bal/bal_problem.h"
#include "ch5_backend/types/vertices.h"

namespace ch5 {

/// @throws FileError "file:line: what, got value" if the file is missing, empty, cut short, not text, or holds
///         counts that the file is too small for, an index out of range, a repeated observation, a number that is
///         not finite or beyond 1e15, or text after the last point
/// @param left_out  if not null, repeated observations are left out and counted here, unless they are many
BalProblem ReadBal(const std::string& path, std::vector<LeftOut>* left_out = nullptr);

/// The file's text; every number reads back as the same double.
std::string FormatBal(const BalProblem& problem);

/// Points gray, camera centers orange, as PLY text, which MeshLab, CloudCompare and Blender open.
std::string FormatBalPly(const BalProblem& problem);

/// c = −Rᵀt.
Vec3 CameraCenter(const Vec9& camera);

/// The center of the camera farthest from each point that sees it, where the point's ray begins; the point if none does.
std::vector<Vec3> FarthestCenters(const BalProblem& problem);

/// Columns: to the right, up, and into the picture, in the world's frame; a BAL camera looks along its −z.
Mat33 CameraAxes(const Vec9& camera);

/// How a step moves a point: by x + δ, or along the ray from the farthest camera that sees it (VertexPointOnRay). Rays take
/// fewer steps where the distance is uncertain (times, by problem: course/documents/measure_start.py).
enum class BalPoints { kXyz, kOnRay };

/// The problem as a graph: cameras are poses, points are landmarks, one EdgeBAL per observation, W = I [1/px²]. Where points are
/// so few that they have fewer unknowns than the cameras, it is the other way round: what is left to solve is smaller.
struct BalGraph {
  Graph graph;
  std::vector<std::shared_ptr<Vertex>> cameras;  ///< VertexCameraBAL, as in BalProblem::cameras
  std::vector<std::shared_ptr<Vertex>> points;   ///< VertexPointXYZ or VertexPointOnRay
  /// The vertices' world has its origin here in the problem's: amid the points if these are far from the origin, else there.
  Vec3 place = Vec3::Zero();
  /// SolveOptions::tau and rescue_steps that suit how the points move, with diagonal damping: along rays they bear bolder first
  /// steps than SolveOptions' 1e-5, and where one is too bold, the points alone often save it.
  double tau = 1e-5;
  int rescue_steps = 0;
};

/// A point at the center of a camera that sees it begins on its pixel's ray instead.
/// @param loss  of every observation, its threshold in pixels; null for plain least squares
/// @throws std::invalid_argument if an observation's index is out of range
BalGraph BuildBal(const BalProblem& problem, std::shared_ptr<const LossFunction> loss,
                  BalPoints move = BalPoints::kOnRay);

/// Copies the vertices' present values into `problem`, which must have built them.
/// @throws std::invalid_argument if it has other numbers of cameras and points
void ReadBack(const BalGraph& bal, BalProblem* problem);

/// Mean of ‖r‖ over the graph's edges [px] at the present state; 0 without edges.
double MeanReprojectionError(const Graph& graph);

}  // namespace ch5
