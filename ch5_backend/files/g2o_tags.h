#pragma once
/// The tags of g2o's text format: what stands behind each, and what it makes. One table for vertices, one for edges, and one
/// for the words of TORO and iSAM, which are put into g2o's before anything is made of them.

#include <memory>
#include <string_view>
#include <vector>

#include "ch5_backend/graph/graph.h"

namespace ch5 {

/// Those that the reader and the writer know by name.
constexpr char kEdgeSE2[] = "EDGE_SE2", kEdgeSE3[] = "EDGE_SE3:QUAT", kFix[] = "FIX";

/// What a vertex of the format is: a pose or a point, in the plane or in space.
enum class VertexKind { kSE2, kXY, kSE3, kXYZ };

/// VERTEX_… id  numbers
struct G2oVertexTag {
  const char* name;
  VertexKind kind;
  int numbers;
  /// At the numbers, or at the origin without.
  std::shared_ptr<Vertex> (*make)(const double* x);
};

/// EDGE_… ids of vertices, ids of PARAMS_…OFFSET, numbers of z, upper half of W (dim × dim)
struct G2oEdgeTag {
  const char* name;
  std::vector<VertexKind> ends;  ///< at most 3
  int offsets;                   ///< at most 2
  int numbers, dim;
  /// A prior's vertices in the graph begin with the world: a fixed vertex of this kind at the origin.
  std::vector<VertexKind> world;
  /// @param offsets  poses of sensors, as many as the tag has
  std::shared_ptr<Edge> (*make)(const std::vector<std::shared_ptr<Vertex>>& vertices, const std::vector<VecX>& offsets,
                                const double* z);
};

/// Another program's word for one of these tags: it has the same ids in front.
struct G2oWord {
  const char* name;
  const char* tag;   ///< g2o's
  int numbers;       ///< behind the ids, all together
  bool has_own_ids;  ///< its last vertex is counted apart from the poses
  /// W's numbers are roots R of W = RᵀR, or else covariances: the file tells by their size (iSAM's lists and GTSAM's).
  bool is_root_or_covariance;
  /// The numbers in g2o's order and measure.  @throws std::invalid_argument saying which of them cannot be
  std::vector<double> (*translate)(std::vector<double> numbers);
};

/// Null if there is none of this name.
const G2oVertexTag* FindVertexTag(std::string_view name);
const G2oVertexTag& TagOf(VertexKind kind);
const G2oEdgeTag* FindEdgeTag(std::string_view name);
const G2oWord* FindWord(std::string_view name);
/// The kind of PARAMS_SE2OFFSET or PARAMS_SE3OFFSET as a pose's tag; null for another name.
const G2oVertexTag* FindOffsetTag(std::string_view name);

/// W, its upper half given row by row, as a matrix; and back.
MatXX FromUpperHalf(const double* w, int dim);
std::vector<double> UpperHalf(const MatXX& W);

/// W of an iSAM list's root R, upper triangular: there the translation's residual is along pose i's axes, where ours is along
/// those of the measurement.  @param theta_z  of the measured transform, 0 for a point
MatXX FromRoot(const MatXX& R, double theta_z);

}  // namespace ch5
