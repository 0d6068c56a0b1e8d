#include <Eigen/Cholesky>
#include <map>

#include "ch5_backend/experiments/studies/homework/graded_priors.h"
#include "ch5_backend/marginalize/edge_prior.h"
#include "ch5_backend/marginalize/square_root.h"
#include "tests/bench/measure.h"

namespace ch5::bench {
namespace {

// Where each free vertex of the edges has its columns in H: dropped landmarks, other dropped vertices, the rest.
struct Columns {
  std::map<const Vertex*, int> first;
  int landmarks = 0, dropped = 0, all = 0;
};

Columns ColumnsOf(const DropSet& oldest) {
  Columns columns;
  const auto add = [&](const auto& vertices, bool landmarks) {
    for (const auto& vertex : vertices) {
      if (vertex->IsFixed() || (vertex->LocalDimension() == 1) != landmarks) continue;
      if (columns.first.emplace(vertex.get(), columns.all).second) columns.all += vertex->LocalDimension();
    }
  };
  add(oldest.vertices, true);
  columns.landmarks = columns.all;
  add(oldest.vertices, false);
  columns.dropped = columns.all;
  for (const auto& edge : oldest.edges) add(edge->Vertices(), false);
  return columns;
}

// What a user would write with Eigen: H and b dense, the landmarks by their own inverses, the rest of what leaves by
// LDLT, and JᵀJ = H from another LDLT.
SquareRootForm PlainLdlt(const DropSet& oldest) {
  const Columns columns = ColumnsOf(oldest);
  MatXX H = MatXX::Zero(columns.all, columns.all);
  VecX b = VecX::Zero(columns.all);
  MatXX W_J, W_rho;
  for (const auto& edge : oldest.edges) {
    edge->Linearize();
    double drho = 1.0;
    edge->RobustInfo(&drho, &W_rho);
    const VecX W_r = drho * edge->Information() * edge->Residual();
    const auto& vertices = edge->Vertices();
    for (size_t i = 0; i < vertices.size(); ++i) {
      if (vertices[i]->IsFixed()) continue;
      const int at_i = columns.first.at(vertices[i].get()), size_i = vertices[i]->LocalDimension();
      W_J.noalias() = W_rho * edge->Jacobian(i);
      b.segment(at_i, size_i).noalias() -= edge->Jacobian(i).transpose() * W_r;
      for (size_t j = 0; j < vertices.size(); ++j) {
        if (vertices[j]->IsFixed()) continue;
        const int at_j = columns.first.at(vertices[j].get()), size_j = vertices[j]->LocalDimension();
        H.block(at_j, at_i, size_j, size_i).noalias() += edge->Jacobian(j).transpose() * W_J;
      }
    }
  }
  const int l = columns.landmarks, d = columns.dropped - l, k = columns.all - columns.dropped;
  const VecX inverse = H.diagonal().head(l).cwiseMax(1e-300).cwiseInverse();
  const MatXX A = H.bottomLeftCorner(d + k, l) * inverse.asDiagonal();
  MatXX H_p = H.bottomRightCorner(d + k, d + k);
  H_p.noalias() -= A * H.bottomLeftCorner(d + k, l).transpose();
  VecX b_p = b.tail(d + k) - A * b.head(l);
  const Eigen::LDLT<MatXX> dropped(H_p.topLeftCorner(d, d));
  MatXX H_k = H_p.bottomRightCorner(k, k);
  H_k.noalias() -= H_p.bottomLeftCorner(k, d) * dropped.solve(H_p.topRightCorner(d, k));
  const VecX b_k = b_p.tail(k) - H_p.bottomLeftCorner(k, d) * dropped.solve(b_p.head(d));
  const Eigen::LDLT<MatXX> kept(H_k);  // H = Pᵀ L D Lᵀ P
  const VecX root = kept.vectorD().cwiseMax(0.0).cwiseSqrt();
  SquareRootForm form;
  form.J = root.asDiagonal() * MatXX(kept.matrixU()) * kept.transpositionsP();
  form.r0 = kept.transpositionsP() * -b_k;
  kept.matrixL().solveInPlace(form.r0);
  form.r0 = (root.array() > 0.0).select(form.r0.cwiseQuotient(root), 0.0);
  return form;
}

// By that, or in VINS-Mono's own way, with two eigendecompositions of dense matrices; Ceres has none.
peer::PeerResult MarginalizeOldest(const Problem& problem) {
  const WindowGraph window = BuildWindowGraph(problem.window);
  const DropSet oldest = OldestFrameOf(problem.window, window);
  if (problem.plain_ldlt) return Timed(problem.options.wall, [&] { return PlainLdlt(oldest).J.squaredNorm(); });
  return Timed(problem.options.wall,
               [&] { return PriorByMarginalizationInfo(oldest.edges, oldest.vertices)->GetPrior().J.squaredNorm(); });
}

}  // namespace

peer::PeerResult Solve(const Problem& problem) {
  if (problem.task == Problem::Task::kMarginalize) return MarginalizeOldest(problem);
  if (problem.task == Problem::Task::kCovariance) {
    return problem.kind == Problem::Kind::kWindow
               ? peer::WindowCovariancesWithCeres(problem.window, problem.options)
               : peer::PoseGraphCovariancesWithCeres(problem.pose_graph, problem.options);
  }
  switch (problem.kind) {
    case Problem::Kind::kWindow: return peer::SolveWindowWithCeres(problem.window, problem.options);
    case Problem::Kind::kPoseGraph: return peer::SolvePoseGraphWithCeres(problem.pose_graph, problem.options);
    case Problem::Kind::kBal: break;
  }
  return peer::SolveBalWithCeres(problem.bal, problem.options);
}

}  // namespace ch5::bench
