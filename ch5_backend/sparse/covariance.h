#pragma once
/// True marginal covariances: blocks of H⁻¹ at the present states, of poses and landmarks alike.
///
/// With S the Schur complement of the landmarks,  Σ_pp = S⁻¹  (not H_pp⁻¹, which is the covariance of the poses if the
/// landmarks were known). A landmark follows the poses that see it,  x_l = H_ll⁻¹ b_l − Σ_p K_plᵀ x_p  with
/// K_pl = H_pl H_ll⁻¹, so that
///
///   Σ_pl = −Σ_q Σ_pq K_ql          Σ_lm = δ_lm H_ll⁻¹ + Σ_p Σ_q K_plᵀ Σ_pq K_qm
///
/// Σ_pq comes from the selected inverse (selected_inverse.h) where S has the block (p, q), as for any two poses that
/// see one landmark, and else from a solve with S. Source: Triggs et al., "Bundle adjustment: a modern synthesis", §9.

#include <map>
#include <memory>
#include <stdexcept>
#include <unordered_map>
#include <utility>

#include "ch5_backend/graph/ordering.h"

namespace ch5 {

class SelectedInverse;
class SparseSolver;

/// There is no such covariance; the message says whose.
class CovarianceError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// A row and a column of the covariance.
using VertexPair = std::pair<std::shared_ptr<Vertex>, std::shared_ptr<Vertex>>;

/// How S is factorized: in the fronts of a sparse plan, or in one dense front.
enum class CovarianceFactor { kSparse, kDense };

/// Of the graph as it is when this is made: what is removed later keeps its covariance here, what is added later has none.
class Covariance {
 public:
  /// Linearizes the selected part of the graph at the present states, and factorizes; g2o's computeMarginals.
  /// @param held  directions in which vertices are held, as SparseOptimizer::Hold was given them: their variance is zero
  /// @throws CovarianceError if H is singular: a gauge is free, or a landmark is seen too little; or not finite, with the edge
  explicit Covariance(Graph* graph, const Selection& selection = {},
                      CovarianceFactor factor = CovarianceFactor::kSparse, int threads = 1,
                      const std::vector<HeldDirections>& held = {});
  ~Covariance();

  /// E[δa δbᵀ], LocalDimension() of a × LocalDimension() of b.
  /// @throws CovarianceError if a vertex is fixed, or takes no part
  MatXX Block(const Vertex& a, const Vertex& b);
  std::vector<MatXX> Blocks(const std::vector<VertexPair>& pairs);

 private:
  class Factorization;
  /// How a vertex follows a pose:  ∂x/∂x_pose, transposed.
  struct Influence {
    int pose;
    MatXX coefficient;
  };

  [[noreturn]] void ThrowSingular() const;
  std::vector<Influence> InfluencesOn(const Vertex& vertex, int* landmark) const;
  MatXX PoseBlock(int i, int j);
  void Project(int pose, Eigen::Ref<MatXX> rows) const;

  std::unique_ptr<SparseSolver> solver_;
  Factorization* factorization_;                                            // belongs to the solver
  std::unordered_map<const Vertex*, int> pose_numbers_, landmark_numbers_;  // in the solver's structure
  std::vector<std::shared_ptr<Vertex>> vertices_;  // else a new one at the address of a freed one has its numbers
  std::unordered_map<int, MatXX> projections_;     // Π of held poses, see HoldPoses
  std::unique_ptr<SelectedInverse> inverse_;
  std::map<int, MatXX> columns_;  // of S⁻¹, where the selected inverse did not do
};

}  // namespace ch5
