#include "ch5_backend/marginalize/marginalize.h"

#include <Eigen/Cholesky>
#include <Eigen/QR>
#include <algorithm>
#include <map>
#include <utility>

#include "ch5_backend/marginalize/drop_ordering.h"
#include "ch5_backend/math/dense_kernels.h"
#include "ch5_backend/math/parallel.h"
#include "ch5_backend/sparse/steps/eliminate.h"

namespace ch5 {
namespace {

using Vertices = std::vector<std::shared_ptr<Vertex>>;

// K, lower triangular, with KᵀK = N Nᵀ:  Nᵀ P = Q R for the permutation P that turns the order round, K = P R P.
MatXX RootOfPseudoInverse(const MatXX& A) {
  const MatXX N = PseudoInverseSquareRoot(A);
  const Eigen::HouseholderQR<MatXX> qr(N.transpose().rowwise().reverse());
  const MatXX R = qr.matrixQR().triangularView<Eigen::Upper>();
  return R.reverse();
}

// Memory of the solver's steps, which a thread keeps from one window to the next.
struct Workspace {
  ThreadPool pool{1};
  LandmarkEdgeBatches batches;
  Linearized system;
  Eliminated eliminated;
};

// 1. The landmarks, by the solver's steps at λ = 0: what remains is in eliminated.S and b_S.
void EliminateLandmarks(const Structure& s, Workspace* w) {
  w->batches.Assign(s);
  w->batches.LoadPoses();
  w->system.Resize(s);
  w->eliminated.Resize(s);
  w->eliminated.S.SetPattern(s.pose_dim, SchurPattern(s));
  SchurGroups groups = PrepareSchurGroups(s, w->eliminated.S, 1);
  const DampingRule undamped{0.0, Damping::kIdentity};
  Linearize(s, w->batches, &w->pool, &w->system);
  InvertLandmarks(s, w->system, undamped, &w->pool, &w->eliminated, RootOfPseudoInverse);
  FormSchurComplement(s, w->system, undamped, &groups, &w->pool, &w->eliminated);
}

// NaN reaches the diagonal or b; without this check the pseudo-inverse would treat it as an unobserved direction.
void CheckFinite(const std::vector<std::shared_ptr<Edge>>& edges, const Eliminated& eliminated) {
  if (eliminated.b_S.allFinite() && eliminated.S.Diagonal().allFinite()) return;
  const std::string what = WhatIsNotFinite(edges);
  throw GraphError("marginalizing: " + (what.empty() ? "the normal equations are not finite" : what));
}

// N with N Nᵀ = H_dd⁻¹. Most windows know their oldest frame well: then Cholesky serves, in a third of the time.
ArrayMatrix RootOfInverse(const Eigen::Ref<const MatXX>& H_dd) {
  constexpr double kSmallestPivot = 1e-2;  // of a matrix with ones on its diagonal: no eigenvalue is near the cutoff
  ArrayVector p_inverse(H_dd.rows());
  p_inverse = H_dd.diagonal().unaryExpr([](double H_ii) { return 1.0 / ScalingOf(H_ii); });
  ArrayMatrix scaled(H_dd.rows(), H_dd.rows()), N(H_dd.rows(), H_dd.rows());
  scaled = p_inverse.asDiagonal() * H_dd * p_inverse.asDiagonal();
  Eigen::Ref<MatXX> in_place(scaled);
  const Eigen::LLT<Eigen::Ref<MatXX>> factor(in_place);
  if (factor.info() != Eigen::Success || !(factor.matrixLLT().diagonal().array() > kSmallestPivot).all()) {
    N = PseudoInverseSquareRoot(H_dd);
    return N;
  }
  N = p_inverse.asDiagonal();
  factor.matrixL().solveInPlace(N);
  N.transposeInPlace();
  return N;
}

// A MarginalSystem whose memory comes and goes.
struct Marginal {
  Vertices kept;
  ArrayMatrix H;
  ArrayVector b;
  VecX scale;
};

// 2. The dropped vertices that are left, the last of H:  M = H_kd N,  N Nᵀ = H_dd⁺.
Marginal EliminateDense(Vertices kept, int n, const Eliminated& eliminated) {
  const SymmetricBlockMatrix& S = eliminated.S;
  const VecX& b = eliminated.b_S;
  const int m = S.Size() - n;
  ArrayMatrix H_all(S.Size(), S.Size());
  H_all.setZero();
  S.CopyLower(H_all.data());
  const ArrayMatrix N = RootOfInverse(H_all.bottomRightCorner(m, m));
  ArrayVector memory(n * m + kernels::kOverread);
  memory.setZero();
  Eigen::Map<MatXX> M(memory.data(), n, m);
  M.noalias() = H_all.bottomLeftCorner(m, n).transpose().lazyProduct(N);
  ArrayMatrix H(n, n);
  ArrayVector Ntb(m), MNtb(n), b_kept(n);
  H = H_all.topLeftCorner(n, n);
  if (n > 0) kernels::SubtractProductAAt(n, m, M.data(), n, H.data(), n);
  H.triangularView<Eigen::StrictlyUpper>() = H.transpose();
  Ntb.noalias() = N.transpose() * b.tail(m);
  MNtb.noalias() = M * Ntb;
  b_kept = b.head(n) - MNtb;
  return {std::move(kept), std::move(H), std::move(b_kept), eliminated.damped_diagonal.head(n)};
}

Marginal Eliminate(const std::vector<std::shared_ptr<Edge>>& edges, const Vertices& drop) {
  CheckMarginalization(edges, drop);
  DropOrdering order = MakeDropOrdering(edges, drop);
  Structure structure = BuildStructure(std::move(order.ordering));
  thread_local Workspace workspace;
  EliminateLandmarks(structure, &workspace);
  CheckFinite(edges, workspace.eliminated);
  Vertices& kept = structure.ordering.poses;  // and then the dropped ones
  kept.resize(static_cast<size_t>(order.num_kept));
  return EliminateDense(std::move(kept), order.kept_size, workspace.eliminated);
}

}  // namespace

MarginalSystem EliminateVertices(const std::vector<std::shared_ptr<Edge>>& edges, const Vertices& drop) {
  Marginal marginal = Eliminate(edges, drop);
  return {std::move(marginal.kept), marginal.H, marginal.b, std::move(marginal.scale)};
}

// H_rr − H_rm H_mm⁻¹ H_mr, then its root.  Leutenegger (2015), §4.3
Prior Marginalize(const std::vector<std::shared_ptr<Edge>>& edges, const std::vector<std::shared_ptr<Vertex>>& drop,
                  const std::optional<EigenvalueCutoff>& cutoff) {
  Marginal system = Eliminate(edges, drop);
  SquareRootForm form = cutoff ? FactorNormalEquations(system.H, system.b, *cutoff)
                               : FactorNormalEquations(system.H, system.b, system.scale);
  Prior prior;
  prior.x0.reserve(system.kept.size());
  for (const auto& vertex : system.kept) prior.x0.emplace_back(vertex->Parameters());
  prior.vertices = std::move(system.kept);
  prior.J = std::move(form.J);
  prior.r0 = std::move(form.r0);
  return prior;
}

std::shared_ptr<EdgePrior> MarginalizeInto(Graph* graph, const std::vector<std::shared_ptr<Vertex>>& drop) {
  if (!graph) throw GraphError("MarginalizeInto: the graph is null");
  for (const auto& vertex : drop) {
    if (!vertex) throw GraphError("MarginalizeInto: a vertex to drop is null");
    if (!graph->Contains(*vertex)) throw GraphError("MarginalizeInto: " + vertex->TypeInfo() + " is not in this graph");
  }
  std::map<int, std::shared_ptr<Edge>> by_id;
  for (const auto& vertex : drop) {
    for (const auto& edge : graph->EdgesOf(*vertex)) {
      if (edge->Level() == 0) by_id.emplace(edge->Id(), edge);
    }
  }
  std::vector<std::shared_ptr<Edge>> edges;
  for (const auto& [id, edge] : by_id) edges.push_back(edge);
  std::shared_ptr<EdgePrior> prior;
  if (!edges.empty()) prior = std::make_shared<EdgePrior>(Marginalize(edges, FixedOrAtEdges(drop, edges)));
  graph->RemoveVertices(drop);
  if (!prior || prior->Vertices().empty()) return nullptr;
  graph->AddEdge(prior);
  return prior;
}

}  // namespace ch5
