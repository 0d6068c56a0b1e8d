#pragma once
/// The normal equations at the present states:
///
///   H = Σ J̃ᵀJ̃,   b = −Σ J̃ᵀr̃                                     r̃, J̃: graph/whitening.h;  Triggs (2000), §4.3
///
///      ┌───────┬──────┐        H_pp  sparse blocks: poses that share an edge
///      │ H_pp  │ H_pl │        H_pl  a block for each slot (landmark, pose that sees it)
///      ├───────┼──────┤        H_ll  block diagonal, so that its inverse is cheap
///      │ H_plᵀ │ H_ll │
///      └───────┴──────┘
///
/// Chunk by chunk, the edges of each landmark are linearised: its blocks of H_ll, H_pl and b_l are then complete, and its
/// part of H_pp and b_p goes to sums of the chunk's own. The edges between poses follow. Then each column of H_pp adds up
/// what belongs to it, in the order of the structure: the result is the same to the bit for any number of threads.

#include <functional>

#include "ch5_backend/math/parallel.h"
#include "ch5_backend/sparse/edge_normal_equations.h"
#include "ch5_backend/sparse/weighted_edge_batch.h"

namespace ch5 {

/// The blocks of H_pl, in double or in single precision; where each begins is said by Structure::slot_block.
struct CouplingBlocks {
  AlignedVector doubles;
  std::vector<float, Eigen::aligned_allocator<float>> floats;
  bool single_precision = false;

  /// Takes zeroed memory for `size` numbers.
  void Resize(int size);
  /// A rows×columns block.
  MatXX Block(int begin, int rows, int columns) const;

  template <typename Scalar>
  CH5_INLINE auto* Numbers() {
    if constexpr (sizeof(Scalar) == sizeof(float)) return floats.data();
    if constexpr (sizeof(Scalar) == sizeof(double)) return doubles.data();
  }
  template <typename Scalar>
  CH5_INLINE const auto* Numbers() const {
    return const_cast<CouplingBlocks*>(this)->Numbers<Scalar>();
  }
};

struct Linearized {
  SymmetricBlockMatrix H_pp;
  CouplingBlocks H_pl;
  std::vector<double> H_ll;  ///< see Structure::landmark_block
  VecX b;                    ///< all rows, poses first

  /// Memory that Linearize works in.
  struct PoseSums {
    AlignedVector H_pp, b;  ///< laid out as H_pp, and b_p with `b_stride` numbers a pose
  };
  std::vector<PoseSums> chunk_sums;
  int b_stride = 0;
  AlignedVector normal_equations;  ///< of each edge between poses, negative
  InformationFactors factors;

  /// The sizes by which its kernels are dispatched.
  BlockSizes SizesFor(const Structure& s) const { return {s.sizes.rows, s.sizes.columns, H_pl.single_precision}; }
  /// Takes all memory for this structure; H_pl's precision must have been chosen.
  void Resize(const Structure& structure);
};

/// Fills H and b.
/// @param batch  the landmarks' edges where they fit into one, its poses just loaded; otherwise it is not active
/// @param pool   of one thread if an edge has numeric Jacobians, which move the vertices
void Linearize(const Structure& structure, const WeightedEdgeBatch& batch, ThreadPool* pool, Linearized* system);

/// Directions in which a vertex is held, C δ = 0: a part of a vertex fixed, such as position and yaw of a pose, or biases.
struct HeldDirections {
  std::shared_ptr<Vertex> vertex;  ///< not a landmark
  std::function<MatXX()> rows;     ///< C at the present states, k×LocalDimension(), of rank k ≥ 1
};

/// Π = I − C⁺C of a vertex, which takes the held directions out of δ.
struct HeldPose {
  int pose;
  MatXX projection;
};

/// Π at the present states of each held vertex; one that is fixed, or without part in the structure, is held already.
/// @throws std::invalid_argument if C has another number of columns, or a landmark is to be held
std::vector<HeldPose> FindHeldPoses(const Structure& structure, const std::vector<HeldDirections>& held);

/// H ← Π H Π + (I − Π) h,  b ← Π b: what remains is a system without the held directions; h > 0 keeps it regular.
void HoldPoses(const Structure& structure, const std::vector<HeldPose>& held, Linearized* system);

}  // namespace ch5
