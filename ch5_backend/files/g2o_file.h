#pragma once
/// Pose graphs in g2o's text format, one record a line: slam2d's and slam3d's poses, landmarks, priors and offsets.
///
///   VERTEX_SE2 id  x y θ                       EDGE_SE2 i j  x y θ  and 6 numbers of W
///   VERTEX_SE3:QUAT id  x y z qx qy qz qw      EDGE_SE3:QUAT i j  x y z qx qy qz qw  and 21 numbers of W
///   VERTEX_XY, VERTEX_TRACKXYZ id  point       EDGE_SE2_XY i l  z, W     EDGE_SE3_TRACKXYZ i l offset  z, W
///   PARAMS_SE3OFFSET id  pose of a sensor      EDGE_PRIOR_SE2 i  z, W    EDGE_SE3_PRIOR i offset  z, W
///   FIX id …                                   # a comment
///
/// The other tags are in g2o_tags.cc. W is symmetric; its upper half is given row by row, translation before rotation. The
/// residuals that it weighs are in types/pose_graph. Records of TORO (VERTEX2, EDGE2, VERTEX3, EDGE3) and iSAM (ODOMETRY,
/// LANDMARK) are read, and written as g2o's. A file of edges alone has the vertices that these name.

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "ch5_backend/graph/graph.h"

namespace ch5 {

/// A file as read: the graph, and the order of its lines, so that it can be written again.
struct G2oFile {
  /// What a line holds.
  enum class Kind { kVertex, kEdge, kOther };
  /// A line of the file.
  struct Line {
    Kind kind;
    int index;         ///< id of the vertex or edge in the graph
    int number;        ///< in the file, from 1
    std::string text;  ///< kOther: the line itself, such as FIX; kEdge: its record, but of the two types that have none
  };

  /// What the six or three last numbers of iSAM's lists are.
  enum class Lists { kRoots, kCovariances };

  Graph graph;
  std::vector<std::shared_ptr<Vertex>> world;  ///< where priors begin: fixed, at the origin; in the graph, in no line
  std::vector<int64_t> ids;  ///< the file's names of the vertices, ascending, by id in the graph; GTSAM's take 63 bits
  std::vector<Line> lines;
  std::vector<Line> unknown;  ///< those of `lines` that were left out: not known
  bool has_poses = true;      ///< false if the file holds edges only: all poses are then at the origin, in order of id
  int projected = 0;          ///< edges whose W was replaced, see G2oOptions
  int repeated = 0;           ///< edges that occur twice, with the same numbers: they count twice
  int first_repeated = 0;     ///< the line of the first of them
  int repeated_vertices = 0;  ///< lines of a vertex that occur again, with the same numbers: they count once
  int first_repeated_vertex = 0;
  std::string unended;         ///< of TextReader::UnendedLine
  std::optional<Lists> lists;  ///< if there are any
};

struct G2oOptions {
  /// A W that is not positive semi-definite is replaced by the nearest one that is (ProjectToPsd), and not refused.
  bool project_information = false;
  /// Lines whose tag is not known are left out, and not refused.
  bool leave_out = false;
};

/// Reads a pose graph. Quaternions within 1e-3 of unit length are normalized.
/// @throws FileError naming file, line and value: a number that is missing, superfluous, not finite or not a number;
///         an id that is unknown, or repeated with other numbers; a tag that is not known; an edge from a vertex to itself or to one
///         of another type; W not positive semi-definite; a quaternion far from unit length, or all with the scalar first; angles in degrees;
///         a line that does not begin with a tag; nothing to make a pose of
G2oFile ReadG2o(const std::string& path, const G2oOptions& options = {});

/// The file with the present states, its lines in the order in which they were read; poses that it did not have go first.
/// What has been removed from the graph since is left out, what has been added comes last, with the least ids that are free:
/// so a graph of one's own is written too, moved into a G2oFile.
/// @throws std::invalid_argument naming a vertex or edge of a type that the format does not have
std::string FormatG2o(const G2oFile& file);

}  // namespace ch5
