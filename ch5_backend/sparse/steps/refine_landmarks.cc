#include "ch5_backend/sparse/steps/refine_landmarks.h"

#include <algorithm>
#include <numeric>

#include "ch5_backend/sparse/kernels/landmark.h"

namespace ch5 {
namespace {

constexpr int kRows = WeightedEdgeBatch::kRows;

// Calls pack(begin, count) for the edges of a chunk's landmarks, in the order of the batches: those of a pack are of one
// type, and of one run where there are runs.
template <typename Pack>
CH5_INLINE void ForEachPack(const Structure& s, const LandmarkEdgeBatches& batches, int chunk, const Pack& pack) {
  if (s.BatchGoesByRuns()) {
    for (int run = s.chunk_runs[chunk]; run < s.chunk_runs[chunk + 1]; ++run) {
      const auto [begin, end] = s.runs[run];
      for (int k = begin; k < end; k += kPack) pack(k, std::min(kPack, end - k));
    }
    return;
  }
  const int end = s.landmark_edges[s.chunk_begin[chunk + 1]];
  for (int k = s.landmark_edges[s.chunk_begin[chunk]], count; k < end; k += count) {
    for (count = 1; count < std::min(kPack, end - k) && batches.Type(k + count) == batches.Type(k);) ++count;
    pack(k, count);
  }
}

// Landmarks of L rows, whatever the size P of the poses.
template <int P, int L>
struct RefineChunk {
  using Signature = double(const Structure&, const LandmarkEdgeBatches&, int chunk, int steps, LandmarkRefinement*);
  using Landmark = LandmarkRefinement::Landmark;

  template <SimdLevel>
  static CH5_INLINE double Run(const Structure& s, const LandmarkEdgeBatches& batches, int chunk, int steps,
                               LandmarkRefinement* x) {
    const int first = s.chunk_begin[chunk], last = s.chunk_begin[chunk + 1];
    std::fill(&x->landmarks[first], &x->landmarks[first] + (last - first), Landmark{});
    for (int step = 0; step <= steps; ++step) {
      for (int l = first; l < last; ++l) Clear(&x->landmarks[l]);
      ForEachPack(s, batches, chunk, [&](int begin, int count) {
        alignas(64) double r[kRows * kPack], J[kRows * WeightedEdgeBatch::kMostColumns * kPack], squares[kPack];
        const WeightedEdgeBatch& batch = batches.Batch(begin);
        const int number = batches.Number(begin);
        step < steps ? batch.Linearize(number, count, r, J) : batch.ComputeResiduals(number, count, r);
        batch.Square(number, count, r, squares);
        if (step > 0) AddChanges(s, begin, count, squares, x);
        if (step < steps) AddEdges(s, batches, begin, count, r, J, squares, x);
      });
      bool any_moves = false;
      for (int l = first; l < last; ++l) {
        if (step > 0) Judge(s.landmarks[l], &x->landmarks[l]);
        if (step < steps) Move(s.landmarks[l], &x->landmarks[l]);
        any_moves = any_moves || !x->landmarks[l].is_done;
      }
      if (!any_moves) break;
    }
    double decrease = 0.0;
    for (int l = first; l < last; ++l) decrease += x->landmarks[l].decrease;
    return decrease;
  }

  static CH5_INLINE void Clear(Landmark* landmark) {
    std::fill_n(landmark->H, L * L, 0.0);
    std::fill_n(landmark->b, L, 0.0);
    landmark->change = 0.0;
  }

  // ½ ρ'(s)(s' − s)
  static CH5_INLINE void AddChanges(const Structure& s, int begin, int count, const double* squares,
                                    LandmarkRefinement* x) {
    for (int k = 0; k < count; ++k) {
      const int e = begin + k;
      x->landmarks[s.edges[s.BatchEdge(e)].landmark].change += 0.5 * x->slopes[e] * (squares[k] - x->squares[e]);
    }
  }

  static CH5_INLINE void AddEdges(const Structure& s, const LandmarkEdgeBatches& batches, int begin, int count,
                                  const double* r, const double* J, const double* squares, LandmarkRefinement* x) {
    const WeightedEdgeBatch& batch = batches.Batch(begin);
    alignas(64) double slopes[kPack], weights[kPack];
    batch.Weigh(batches.Number(begin), count, squares, slopes, weights);
    std::copy_n(squares, count, &x->squares[begin]);
    std::copy_n(slopes, count, &x->slopes[begin]);
    const int position = s.BatchGoesByRuns() ? 0 : s.edges[s.BatchEdge(begin)].landmark_position;
    const auto *J_l = AsWide(J + batch.JacobianBegin(position) * kPack), *r_lanes = AsWide(r);
    const WideLanes w = *AsWide(weights);
    WideLanes H[L * L], b[L];
    for (int c = 0; c < L; ++c) {
      const WideLanes J_0 = w * J_l[c * kRows], J_1 = w * J_l[c * kRows + 1];
      b[c] = J_0 * r_lanes[0] + J_1 * r_lanes[1];
      for (int i = c; i < L; ++i) H[c * L + i] = J_0 * J_l[i * kRows] + J_1 * J_l[i * kRows + 1];
    }
    for (int k = 0; k < count; ++k) {
      Landmark& landmark = x->landmarks[s.edges[s.BatchEdge(begin + k)].landmark];
      for (int c = 0; c < L; ++c) {
        landmark.b[c] -= b[c][k];
        for (int i = c; i < L; ++i) landmark.H[c * L + i] += H[c * L + i][k];
      }
    }
  }

  // Takes the last step back unless it has lowered the landmark's cost; then it is the last one.
  static CH5_INLINE void Judge(Vertex* vertex, Landmark* landmark) {
    if (landmark->is_done) return;
    if (landmark->change < 0.0) {
      landmark->decrease -= landmark->change;
    } else {
      std::copy_n(landmark->before, vertex->Dimension(), vertex->Parameters().data());
      landmark->is_done = true;
    }
  }

  static CH5_INLINE void Move(Vertex* vertex, Landmark* landmark) {
    if (landmark->is_done) return;
    double inverse[L * L], delta[L] = {};
    landmark->is_done = !kernels::InvertSymmetric<L>(landmark->H, L, inverse);
    if (landmark->is_done) return;
    kernels::AddSymmetric<L>(inverse, landmark->b, L, delta);
    std::copy_n(vertex->Parameters().data(), vertex->Dimension(), landmark->before);
    vertex->Plus(delta);
  }
};

// Sizes that no batch has.
template <>
struct RefineChunk<Eigen::Dynamic, Eigen::Dynamic> {
  using Signature = RefineChunk<6, 1>::Signature;
  template <SimdLevel>
  static double Run(const Structure&, const LandmarkEdgeBatches&, int, int, LandmarkRefinement*) {
    return 0.0;
  }
};

}  // namespace

double RefineLandmarks(const Structure& s, const LandmarkEdgeBatches& batches, int steps, ThreadPool* pool,
                       LandmarkRefinement* x) {
  const auto is_large = [](const Vertex* landmark) {
    return landmark->Dimension() > LandmarkRefinement::Landmark::kMostParameters;
  };
  if (std::any_of(s.landmarks.begin(), s.landmarks.end(), is_large)) return 0.0;
  x->landmarks.resize(s.landmarks.size());
  for (Array<double>* of_edges : {&x->squares, &x->slopes}) of_edges->resize(static_cast<size_t>(s.num_landmark_edges));
  x->decreases.resize(static_cast<size_t>(s.NumChunks()));
  const auto refine = Dispatch<RefineChunk>(s.sizes.OfLandmarks());
  pool->Run(s.NumChunks(), [&](int chunk) { x->decreases[chunk] = refine(s, batches, chunk, steps, x); });
  return std::accumulate(x->decreases.begin(), x->decreases.end(), 0.0);
}

}  // namespace ch5
