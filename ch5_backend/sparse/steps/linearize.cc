#include "ch5_backend/sparse/steps/linearize.h"

#include <algorithm>

#include "ch5_backend/sparse/kernels/jacobian.h"
#include "ch5_backend/sparse/kernels/landmark.h"

namespace ch5 {
namespace {

constexpr int kPoseEdges = 32, kPoses = 8;  // a task's
constexpr int kPrefetchDistance = 6;        // edges that are asked for ahead

// H −= C, rows×columns; of a diagonal block C holds the lower half, H is full.
CH5_INLINE void SubtractBlock(const double* C, int stride, int rows, int columns, bool diagonal, double* H) {
  for (int c = 0; c < columns; ++c, C += stride) {
    for (int r = diagonal ? c : 0; r < rows; ++r) H[c * Stride(rows) + r] -= C[r];
    for (int r = c + 1; r < rows && diagonal; ++r) H[r * Stride(rows) + c] -= C[r];
  }
}

// The same of any block, `rows` a constant; what lies above the diagonal of a diagonal one is meaningless then.
template <int Rows>
CH5_INLINE void SubtractColumns(const double* C, int stride, int columns, double* H) {
  for (int c = 0; c < columns; ++c, C += stride, H += Stride(Rows)) {
    CH5_UNROLL
    for (int k = 0; k < Rows / kLanes; ++k) AsLanes(H)[k] -= AsLanes(C)[k];
    CH5_UNROLL
    for (int r = Rows / kLanes * kLanes; r < Rows; ++r) H[r] -= C[r];
  }
}
CH5_INLINE void SubtractColumns(const double* C, int stride, int rows, int columns, double* H) {
  if (rows == 6) return SubtractColumns<6>(C, stride, columns, H);
  if (rows == 9) return SubtractColumns<9>(C, stride, columns, H);
  for (int c = 0; c < columns; ++c, C += stride, H += Stride(rows)) {
    for (int r = 0; r < rows; ++r) H[r] -= C[r];
  }
}

// H −= Cᵀ.
CH5_INLINE void SubtractRows(const double* C, int stride, int rows, int columns, double* H) {
  for (int r = 0; r < rows; ++r, C += stride) {
    for (int c = 0; c < columns; ++c) H[c * Stride(rows) + r] -= C[c];
  }
}

// The upper half of a diagonal block to the lower one.
CH5_INLINE void MirrorUpper(int dim, double* H) {
  for (int c = 0; c < dim; ++c) {
    for (int r = c + 1; r < dim; ++r) H[c * Stride(dim) + r] = H[r * Stride(dim) + c];
  }
}

// What the landmarks of one chunk write to: their own blocks of the system, and the chunk's sums for the poses.
class Chunk {
 public:
  CH5_INLINE Chunk(const Structure& structure, const LandmarkEdgeBatches& batches, int chunk, Linearized* system)
      : s_(structure),
        batches_(batches),
        system_(*system),
        sums_(system->chunk_sums[chunk]),
        H_pp_sums_(structure.SumsInPlace() ? system->H_pp.AllValues() : sums_.H_pp.data()),
        chunk_(chunk) {
    std::fill_n(H_pp_sums_, s_.SumsInPlace() ? system_.H_pp.NumValues() : sums_.H_pp.size(), 0.0);
    std::fill(sums_.b.begin(), sums_.b.end(), 0.0);
    sums_.cost = 0.0;
  }

 protected:
  CH5_INLINE double* BlockOfSums(int block, int column) {
    return H_pp_sums_ + system_.H_pp.ValueBegin(block) + sums_.shift[column];
  }
  CH5_INLINE double* RowsOfSums(int pose) { return &sums_.b[sums_.number[pose] * system_.b_stride]; }

  static constexpr int kR = WeightedEdgeBatch::kRows;

  const Structure& s_;
  const LandmarkEdgeBatches& batches_;
  Linearized& system_;
  Linearized::PoseSums& sums_;
  double* H_pp_sums_;
  int chunk_;
};

// Landmark by landmark, and edge by edge. P×L are the sizes of H_pl's blocks.
template <int P, int L, SimdLevel kSimd>
class LandmarkLinearizer : Chunk {
  static constexpr bool kPacked = P != Eigen::Dynamic && L > 1;  // where the batches are active
  static constexpr bool kWide = kSimd == SimdLevel::kAvx512;     // registers of eight numbers

 public:
  using Chunk::Chunk;

  CH5_INLINE void Run() {
    EdgePack packs[LandmarkEdgeBatches::kMostTypes];
    for (int l = s_.chunk_begin[chunk_]; l < s_.chunk_begin[chunk_ + 1]; ++l) LinearizeLandmark(l, packs);
    for (int type = 0; type < batches_.NumTypes(); ++type) {
      sums_.cost += 0.5 * packs[type].SumOfLosses(batches_.OfType(type));
    }
  }

 private:
  // What a landmark sums before it is stored; H_ll has Stride(dim) numbers a column.
  struct LandmarkSums {
    double *H_ll, *b_l;
  };

  CH5_INLINE void LinearizeLandmark(int l, EdgePack* packs) {
    const int dim = kernels::Pick<L>(s_.landmark_dim[l]);
    const bool packed = kPacked && batches_.Active(), factored = !system_.H_pl_factors.empty();
    if (!factored && (!packed || !s_.OneEdgePerSlot())) {
      double* H_pl = system_.H_pl.data();
      std::fill(H_pl + s_.SlotBlock(s_.landmark_slots[l]), H_pl + s_.SlotBlock(s_.landmark_slots[l + 1]), 0.0);
    }
    kernels::Scratch<kernels::ScratchSize(L, L)> H_scratch;
    kernels::Scratch<kernels::ScratchSize(L, 1), 1> b_scratch;
    const LandmarkSums sums{H_scratch.Zeros(Stride(dim) * dim), b_scratch.Zeros(Stride(dim))};
    for (int e = s_.landmark_edges[l]; e < s_.landmark_edges[l + 1]; ++e) {
      if constexpr (kPacked) {
        if (packed) {
          if constexpr (P > 0) {
            if (factored) {
              AddFactoredEdge(e, packs, sums);
              continue;
            }
          }
          AddPackedEdge(e, packs, sums);
          continue;
        }
      }
      PrefetchEdge(s_.edges, e + kPrefetchDistance);
      AddAnyEdge(e, dim, sums);
    }
    for (int c = 0; c < dim; ++c) {
      std::copy_n(sums.H_ll + c * Stride(dim), dim, &system_.H_ll[s_.landmark_block[l] + c * dim]);
    }
    std::copy_n(sums.b_l, dim, system_.b.data() + s_.landmark_offset[l]);
  }

  // An edge of a batch, whose J̃ and r̃ stand in the pack of its type.
  CH5_INLINE void AddPackedEdge(int e, EdgePack* packs, const LandmarkSums& sums) {
    const EdgeRecord& record = s_.edges[e];
    const WeightedEdgeBatch& batch = batches_.Batch(e);
    EdgePack& pack = packs[batches_.Type(e)];
    const int lane = pack.LaneOf(batch, batches_.Number(e)), num_poses = record.poses_end - record.poses_begin;
    const int p = kernels::Pick<P>(s_.sizes.rows);
    const EdgePose* poses = s_.edge_poses.data() + record.poses_begin;
    const auto jacobian = [&](int position) { return pack.Jacobian(batch, lane, position); };

    const double r[kR] = {pack.Residual(lane, 0), pack.Residual(lane, 1)};
    const double* J_l = jacobian(record.landmark_position);
    const kernels::Rows<kR, L, kWide> rows_l(J_l);
    rows_l.template AddTransposeProduct<L>(J_l, sums.H_ll);
    rows_l.SubtractTransposeVector(r, sums.b_l);
    const int* block = s_.edge_blocks.data() + record.blocks_begin;
    for (int i = 0; i < num_poses; ++i) {
      const double* J_i = jacobian(poses[i].position);
      const kernels::Rows<kR, P, kWide> rows_i(J_i, p);
      double* H_il = system_.H_pl.data() + s_.SlotBlock(poses[i].slot);
      rows_i.template AddTransposeProductTight<L>(J_l, s_.OneEdgePerSlot(), H_il);
      rows_i.SubtractTransposeVector(r, RowsOfSums(poses[i].pose));
      for (int j = 0; j < i; ++j) {
        rows_i.template AddTransposeProduct<P>(jacobian(poses[j].position), BlockOfSums(*block++, poses[j].pose), p);
      }
      rows_i.template AddTransposeProduct<P, true>(J_i, BlockOfSums(*block++, poses[i].pose), p);
    }
  }

  // The same for an edge whose block of H_pl is stored by its factors: b takes J̃ as it is, H as it is stored.
  CH5_INLINE void AddFactoredEdge(int e, EdgePack* packs, const LandmarkSums& sums) {
    using Factors = kernels::SlotFactors<P, L>;
    const EdgeRecord& record = s_.edges[e];
    if (record.poses_begin == record.poses_end) return AddPackedEdge(e, packs, sums);  // its pose is fixed
    const EdgePose& pose = s_.edge_poses[record.poses_begin];
    const WeightedEdgeBatch& batch = batches_.Batch(e);
    EdgePack& pack = packs[batches_.Type(e)];
    const int lane = pack.LaneOf(batch, batches_.Number(e));
    const double r[kR] = {pack.Residual(lane, 0), pack.Residual(lane, 1)};
    double *J_l = pack.Jacobian(batch, lane, record.landmark_position),
           *J_p = pack.Jacobian(batch, lane, pose.position);
    kernels::Rows<kR, L, kWide>(J_l).SubtractTransposeVector(r, sums.b_l);
    kernels::Rows<kR, P, kWide>(J_p).SubtractTransposeVector(r, RowsOfSums(pose.pose));
    Factors::Store(J_p, J_l, &system_.H_pl_factors[static_cast<size_t>(pose.slot) * Factors::kSize]);
    kernels::Rows<kR, L, kWide>(J_l).template AddTransposeProduct<L>(J_l, sums.H_ll);
    double* H_pp = BlockOfSums(s_.edge_blocks[record.blocks_begin], pose.pose);
    kernels::Rows<kR, P, kWide>(J_p).template AddTransposeProduct<P, true>(J_p, H_pp);
  }

  // Any other edge: its normal equations, block by block.
  CH5_INLINE void AddAnyEdge(int e, int dim, const LandmarkSums& sums) {
    const EdgeRecord& record = s_.edges[e];
    const int stride = record.width + 1, row_l = record.width - dim;
    const double* C = NegativeNormalEquations(e);
    sums_.cost += record.edge->Cost();
    for (int c = 0; c < dim; ++c) {
      const double* column = C + (row_l + c) * stride;
      for (int r = c; r < dim; ++r) sums.H_ll[c * Stride(dim) + r] -= column[row_l + r];
      for (int r = c + 1; r < dim; ++r) sums.H_ll[r * Stride(dim) + c] -= column[row_l + r];
      sums.b_l[c] += column[record.width];
    }
    const int* block = s_.edge_blocks.data() + record.blocks_begin;
    for (int i = record.poses_begin; i < record.poses_end; ++i) {
      const EdgePose& a = s_.edge_poses[i];
      const int dim_a = s_.pose_dim[a.pose];
      double* H_al = system_.H_pl.data() + s_.SlotBlock(a.slot);
      double* b_a = RowsOfSums(a.pose);
      for (int c = 0; c < dim_a; ++c) {
        const double* column = C + (a.column + c) * stride;
        for (int m = 0; m < dim; ++m) H_al[m * dim_a + c] -= column[row_l + m];
        b_a[c] += column[record.width];
      }
      for (int j = record.poses_begin; j <= i; ++j) {
        const EdgePose& b = s_.edge_poses[j];
        SubtractBlock(C + b.column * stride + a.column, stride, dim_a, s_.pose_dim[b.pose], i == j,
                      BlockOfSums(*block++, b.pose));
      }
    }
  }

  const double* NegativeNormalEquations(int e) {
    if (!s_.edges[e].is_numeric) s_.edges[e].edge->Linearize();
    thread_local AlignedVector memory;
    const auto most = static_cast<size_t>((s_.max_width + 1) * (s_.max_width + 1));
    if (memory.size() < most) memory.resize(most);
    MultiplyOut(s_, e, memory.data());
    return memory.data();
  }
};

// Landmarks that are numbers (L = 1), run by run (Chunks::runs): a block of H_pp is changed once for many edges.
template <int P, SimdLevel kSimd>
class RunLinearizer : Chunk {
  using Vector = FittingLanes<kSimd>;
  static constexpr int kXi = kernels::kXi, kTile = kSimd == SimdLevel::kAvx512 ? 3 : 1;
  static_assert(kXi == RelativeJacobian::kDim);
  static constexpr int kPacks = 8, kPackSize = kR * (1 + 1 + kXi) * kPack;  // r, J_l and J_ξ

 public:
  using Chunk::Chunk;

  CH5_INLINE void Run() {
    const int first = s_.chunk_begin[chunk_], last = s_.chunk_begin[chunk_ + 1];
    double *H_pl = system_.H_pl.data(), *H_ll = system_.H_ll.data(), *b = system_.b.data();
    std::fill(H_pl + s_.SlotBlock(s_.landmark_slots[first]), H_pl + s_.SlotBlock(s_.landmark_slots[last]), 0.0);
    for (int l = first; l < last; ++l) H_ll[s_.landmark_block[l]] = b[s_.landmark_offset[l]] = 0.0;
    for (int k = s_.chunk_runs[chunk_]; k < s_.chunk_runs[chunk_ + 1]; ++k) LinearizeRun(s_.runs[k]);
  }

 private:
  // J_i = J_ξ A_i, and edges of a run share the A_i. So only J_ξᵀJ_ξ and J_ξᵀr are sums over edges:
  //   H_ij = A_iᵀ (Σ J_ξᵀJ_ξ) A_j,   b_i = −A_iᵀ Σ J_ξᵀr.
  CH5_INLINE void LinearizeRun(const EdgeRun& run) {
    const EdgeRecord& record = s_.edges[s_.batch_edges[run.begin]];
    const WeightedEdgeBatch& batch = batches_.Batch(run.begin);
    const int number = batches_.Number(run.begin) - run.begin;  // those of a run follow one another in their batch
    RelativeJacobian A[WeightedEdgeBatch::kMostVertices];
    for (int begin = run.begin, end; begin < run.end; begin = end) {  // once, unless their cameras differ
      end = begin + batch.RelativeJacobians(number + begin, run.end - begin, A);
      alignas(64) double JtJ[kXi * kPack] = {}, Jt_r[kPack] = {};
      for (int e = begin; e < end; e += kPacks * kPack) {
        AddEdges(batch, number, e, std::min(e + kPacks * kPack, end), A, JtJ, Jt_r);
      }
      MirrorUpper(kXi, JtJ);
      AddToPoses(record, A, JtJ, Jt_r);
    }
  }

  // Edges [begin, end), at most kPacks packs: to their landmarks, to H_pl, and the sums over J_ξ.
  CH5_INLINE void AddEdges(const WeightedEdgeBatch& batch, int number, int begin, int end, const RelativeJacobian* A,
                           double* JtJ, double* Jt_r) {
    alignas(64) double r[kPackSize * kPacks], s[kPack * kPacks];  // packs, and s of each of their edges
    double *J_l = r + kR * kPack, *J_xi = J_l + kR * kPack;
    int packs = 0;
    for (int e = begin; e < end; e += kPack, ++packs) {
      const int count = std::min(kPack, end - e), pack = packs * kPackSize;
      batch.Linearize(number + e, count, r + pack, J_l + pack);
      batch.Whiten(number + e, count, r + pack, J_l + pack, s + packs * kPack);
      AddToLandmarks(e, count, r + pack, J_l + pack);
      AddToSlots(e, count, A, J_l + pack, J_xi + pack);
    }
    sums_.cost += 0.5 * batch.SumLosses(number + begin, s, end - begin);
    kernels::AddPackProducts<Vector, kR, kXi, 1, 1>(J_xi, r, packs, kPackSize, Jt_r);
    kernels::AddPackProducts<Vector, kR, kXi, kXi, kTile, true>(J_xi, J_xi, packs, kPackSize, JtJ);
  }

  CH5_INLINE void AddToLandmarks(int e, int count, const double* r, const double* J_l) {
    const auto *J = AsWide(J_l), *r_lanes = AsWide(r);
    const WideLanes JtJ = J[0] * J[0] + J[1] * J[1], Jt_r = J[0] * r_lanes[0] + J[1] * r_lanes[1];
    for (int k = 0; k < count; ++k) {
      const int l = s_.edges[s_.batch_edges[e + k]].landmark;
      system_.H_ll[s_.landmark_block[l]] += JtJ[k];
      system_.b[s_.landmark_offset[l]] -= Jt_r[k];
    }
  }

  // J_iᵀJ_l = A_iᵀ (J_ξᵀJ_l) of each edge and pose.
  CH5_INLINE void AddToSlots(int e, int count, const RelativeJacobian* A, const double* J_l, const double* J_xi) {
    const EdgeRecord& record = s_.edges[s_.batch_edges[e]];
    const int num_poses = record.poses_end - record.poses_begin;
    Vector products[kernels::kParts<Vector>][kXi];
    kernels::LanesTransposeProduct<kR>(J_xi, J_l, products);
    for (int i = 0; i < num_poses; ++i) {
      alignas(64) double of_edge[kPack * Stride(P)];
      kernels::LanesTransposeProduct(A[s_.edge_poses[record.poses_begin + i].position].row[0], products, of_edge);
      for (int k = 0; k < count; ++k) {
        const EdgePose& pose = s_.edge_poses[s_.edges[s_.batch_edges[e + k]].poses_begin + i];
        kernels::AddTight<P>(of_edge + k * Stride(P), system_.H_pl.data() + s_.SlotBlock(pose.slot));
      }
    }
  }

  CH5_INLINE void AddToPoses(const EdgeRecord& record, const RelativeJacobian* A, const double* JtJ,
                             const double* Jt_r) {
    const EdgePose* poses = s_.edge_poses.data() + record.poses_begin;
    const int* block = s_.edge_blocks.data() + record.blocks_begin;
    alignas(64) double JtJ_A[WeightedEdgeBatch::kMostVertices][kXi * kPack];
    for (int i = 0; i < record.poses_end - record.poses_begin; ++i) {
      const double* A_i = A[poses[i].position].row[0];
      alignas(64) double At_Jt_r[kPack] = {};
      kernels::AddTransposeProduct<Vector, 1>(A_i, Jt_r, At_Jt_r);
      double* b_i = RowsOfSums(poses[i].pose);
      for (int c = 0; c < P; ++c) b_i[c] -= At_Jt_r[c];
      kernels::Product<Vector>(JtJ, A_i, JtJ_A[i]);
      for (int j = 0; j <= i; ++j) {
        kernels::AddTransposeProduct<Vector, kXi>(A_i, JtJ_A[j], BlockOfSums(*block++, poses[j].pose));
      }
    }
  }
};

template <int P, int L>
struct LinearizeChunk {
  using Signature = void(const Structure&, const LandmarkEdgeBatches&, int chunk, Linearized*);
  template <SimdLevel kSimd>
  static CH5_INLINE void Run(const Structure& s, const LandmarkEdgeBatches& batches, int chunk, Linearized* system) {
    if constexpr (P != Eigen::Dynamic && L == 1) {
      if (batches.Active()) return RunLinearizer<P, kSimd>(s, batches, chunk, system).Run();
    }
    LandmarkLinearizer<P, L, kSimd>(s, batches, chunk, system).Run();
  }
};

// H_ij for all i ≥ j, and b_j: the chunks' sums.
struct SumColumn {
  using Signature = void(const Structure&, int j, Linearized*);
  template <SimdLevel>
  static CH5_INLINE void Run(const Structure& s, int j, Linearized* system) {
    SymmetricBlockMatrix& H_pp = system->H_pp;
    const int dim = s.pose_dim[j];
    double* b_j = system->b.data() + s.pose_offset[j];
    const ptrdiff_t begin = H_pp.ValueBegin(H_pp.ColumnBegin(j));
    double *column = H_pp.AllValues() + begin, *end = H_pp.ColumnEnd(j);
    if (!s.SumsInPlace()) std::fill(column, end, 0.0);
    std::fill_n(b_j, dim, 0.0);
    for (const Linearized::PoseSums& sums : system->chunk_sums) {
      if (sums.number[j] < 0) continue;
      const double* b = sums.b.data() + sums.number[j] * system->b_stride;
      for (int r = 0; r < dim; ++r) b_j[r] += b[r];
      if (s.SumsInPlace()) continue;
      const double* H = sums.H_pp.data() + begin + sums.shift[j];
      for (ptrdiff_t k = 0; k < end - column; ++k) column[k] += H[k];
    }
    MirrorUpper(dim, column);  // of the diagonal block only that half has been summed
  }
};

// What the edges [first, last) between poses, of one batch, add to the columns of poses [begin, end) and their rows of b.
struct AddPoseEdges {
  using Signature = void(const Structure&, int first, int last, int begin, int end, Linearized*);
  template <SimdLevel>
  static CH5_INLINE void Run(const Structure& s, int first, int last, int begin, int end, Linearized* system) {
    for (int e = first; e < last; ++e) {
      const EdgeRecord& record = s.edges[e];
      const double* C = system->normal_equations.data() + record.normal_equations;
      const int* block = s.edge_blocks.data() + record.blocks_begin;
      for (int i = record.poses_begin; i < record.poses_end; ++i) {
        for (int j = record.poses_begin; j <= i; ++j, ++block) {
          const EdgePose &pose_i = s.edge_poses[i], &pose_j = s.edge_poses[j];
          if (pose_j.pose < begin || pose_j.pose >= end) continue;
          AddBlock(s, record.width, pose_i, pose_j, C, system->H_pp.Values(*block), system->b.data());
        }
      }
    }
  }

  // C holds J̃_iᵀJ̃_j below its diagonal, or J̃_jᵀJ̃_i where the edge has pose i before pose j; its last row is r̃ᵀJ̃.
  static CH5_INLINE void AddBlock(const Structure& s, int width, const EdgePose& i, const EdgePose& j, const double* C,
                                  double* H_ij, double* b) {
    const int rows = s.pose_dim[i.pose], columns = s.pose_dim[j.pose], stride = width + 1;
    if (i.column < j.column) return SubtractRows(C + i.column * stride + j.column, stride, rows, columns, H_ij);
    C += j.column * stride;
    SubtractColumns(C + i.column, stride, rows, columns, H_ij);
    if (i.pose != j.pose) return;
    double* b_j = b + s.pose_offset[j.pose];
    for (int c = 0; c < columns; ++c) b_j[c] += C[c * stride + width];
  }
};

// Edges [first, last) between poses, a batch. @return their cost
double LinearizePoseEdges(const Structure& s, int first, int last, ThreadPool* pool, Linearized* system) {
  const double cost = ParallelSum(pool, last - first, kPoseEdges, &system->other_costs, [&](int begin, int end) {
    double sum = 0.0;
    for (int e = first + begin; e < first + end; ++e) {
      PrefetchEdge(s.edges, e + kPrefetchDistance);
      LinearizeAndMultiplyOut(s, e, &system->normal_equations[s.edges[e].normal_equations]);
      sum += s.edges[e].edge->Cost();
    }
    return sum;
  });
  const auto add = Dispatch<AddPoseEdges>();
  ParallelFor(pool, s.NumPoses(), NumChunks(s.NumPoses(), pool->Threads()),
              [&](int begin, int end) { add(s, first, last, begin, end, system); });
  return cost;
}

}  // namespace

void Linearized::Resize(const Structure& s, bool factored) {
  H_pp.SetPattern(s.pose_dim, s.H_pp_pattern);
  normal_equations.resize(static_cast<size_t>(s.num_normal_equation_values));  // Linearize writes what is read
  H_pl_factors = Array<float>(factored ? s.slot_pose.size() * 2 * (s.sizes.rows + s.sizes.columns) : 0);
  // The last block is read in whole registers too.
  const size_t num_H_pl = factored ? 0 : static_cast<size_t>(s.num_H_pl_values + kLanes);
  H_pl.resize(num_H_pl);  // Linearize writes these too
  std::fill(H_pl.end() - std::min<ptrdiff_t>(kLanes, H_pl.size()), H_pl.end(), 0.0);
  SetZeros(static_cast<size_t>(s.num_H_ll_values), &H_ll);
  b.setZero(s.Size());
  b_stride = s.pose_dim.empty() ? 0 : Stride(*std::max_element(s.pose_dim.begin(), s.pose_dim.end()));
  ResizeChunkSums(s);
}

void Linearized::ResizeChunkSums(const Structure& s) {
  chunk_sums.resize(static_cast<size_t>(s.NumChunks()));
  for (int chunk = 0; chunk < s.NumChunks(); ++chunk) {
    PoseSums& sums = chunk_sums[chunk];
    sums.number = NumberPosesOfLandmarks(s, s.chunk_begin[chunk], s.chunk_begin[chunk + 1]);
    sums.shift.assign(s.poses.size(), 0);
    ptrdiff_t num_values = 0;
    int num_poses = 0;
    for (int j = 0; j < s.NumPoses(); ++j) {
      if (sums.number[j] < 0) continue;
      const ptrdiff_t begin = H_pp.ValueBegin(H_pp.ColumnBegin(j));
      sums.shift[j] = s.SumsInPlace() ? 0 : num_values - begin;
      num_values += H_pp.ColumnEnd(j) - H_pp.AllValues() - begin;
      ++num_poses;
    }
    sums.H_pp.resize(s.SumsInPlace() ? 0 : static_cast<size_t>(num_values));  // Linearize clears it
    SetZeros(static_cast<size_t>(num_poses * b_stride), &sums.b);
  }
}

MatXX Linearized::Coupling(const Structure& s, int slot) const {
  const int p = s.pose_dim[s.slot_pose[slot]], l = s.landmark_dim[s.slot_landmark[slot]];
  if (H_pl_factors.empty()) return Eigen::Map<const MatXX>(&H_pl[s.SlotBlock(slot)], p, l);
  using Rows = Eigen::Matrix<float, 2, Eigen::Dynamic, Eigen::RowMajor>;
  const MatXX J =
      Eigen::Map<const Rows>(&H_pl_factors[static_cast<size_t>(slot) * 2 * (p + l)], 2, p + l).cast<double>();
  return J.leftCols(p).transpose() * J.rightCols(l);
}

double Linearize(const Structure& s, const LandmarkEdgeBatches& batches, ThreadPool* pool, Linearized* system) {
  const auto linearize_chunk = DispatchByRegisters<LinearizeChunk>(s.sizes);
  pool->Run(s.NumChunks(), [&](int chunk) { linearize_chunk(s, batches, chunk, system); });

  double cost = 0.0;
  for (const Linearized::PoseSums& sums : system->chunk_sums) cost += sums.cost;
  const auto sum_column = Dispatch<SumColumn>();
  ParallelFor(pool, s.NumPoses(), kPoses, [&](int begin, int end) {
    for (int j = begin; j < end; ++j) sum_column(s, j, system);
  });

  for (size_t k = 0; k + 1 < s.pose_batches.size(); ++k) {
    cost += LinearizePoseEdges(s, s.pose_batches[k], s.pose_batches[k + 1], pool, system);
  }
  if (s.num_active_edges > s.num_landmark_edges) {  // of whose diagonal blocks only the lower half is meant
    ParallelFor(pool, s.NumPoses(), kPoses, [&](int begin, int end) {
      for (int j = begin; j < end; ++j) MirrorLower(s.pose_dim[j], system->H_pp.Values(system->H_pp.ColumnBegin(j)));
    });
  }
  for (size_t e = static_cast<size_t>(s.num_active_edges); e < s.edges.size(); ++e) {
    s.edges[e].edge->ComputeResidual();
    cost += s.edges[e].edge->Cost();
  }
  return cost;
}

}  // namespace ch5
