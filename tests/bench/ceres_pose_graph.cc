#include <Eigen/Cholesky>
#include <memory>

#include "ch5_backend/experiments/studies/pose_graph_study.h"
#include "ch5_backend/types/pose_graph/edge_between.h"
#include "tests/bench/ceres_solve.h"

namespace ch5::peer {
namespace {

// The residual of EdgeSE3Between, whitened by a factor of W that is worked out once.
class Between : public ceres::SizedCostFunction<6, 7, 7> {
 public:
  explicit Between(const EdgeSE3Between& edge)
      : root_(Mat66(edge.W()).llt().matrixU()),
        i_(std::make_shared<VertexPose>()),
        j_(std::make_shared<VertexPose>()),
        edge_(i_, j_, edge.q_z(), edge.p_z()) {}

  bool Evaluate(double const* const* x, double* residuals, double** jacobians) const override {
    i_->SetEstimate(Eigen::Map<const Vec7>(x[0]));
    j_->SetEstimate(Eigen::Map<const Vec7>(x[1]));
    edge_.ComputeResidual();
    Eigen::Map<Vec6>{residuals}.noalias() = root_ * edge_.GetResidual();
    if (!jacobians) return true;
    edge_.ComputeJacobians();
    if (jacobians[0]) Fill(std::as_const(edge_).J<0>(), jacobians[0]);
    if (jacobians[1]) Fill(std::as_const(edge_).J<1>(), jacobians[1]);
    return true;
  }

 private:
  void Fill(const Mat66& J, double* out) const {
    Eigen::Map<RowMajor<6, 7>> target(out);
    target.leftCols<6>().noalias() = root_ * J;
    target.col(6).setZero();
  }

  Mat66 root_;
  std::shared_ptr<VertexPose> i_, j_;
  mutable EdgeSE3Between edge_;  // each block of a problem is evaluated by one thread at a time
};

// A pose graph with Ceres' states.
struct PoseGraph {
  explicit PoseGraph(const std::string& path) : file(ReadG2o(path)) {
    FixFreeParts(file.graph);
    for (const auto& vertex : file.graph.Vertices()) states.push_back(vertex->Parameters());
    auto* manifold = new PoseManifold;
    for (const auto& edge : file.graph.Edges()) {
      const int i = edge->Vertices()[0]->Id(), j = edge->Vertices()[1]->Id();
      for (const int k : {i, j}) problem.AddParameterBlock(Data(k), 7, manifold);
      problem.AddResidualBlock(new Between(dynamic_cast<const EdgeSE3Between&>(*edge)), nullptr, Data(i), Data(j));
    }
    for (const auto& vertex : file.graph.Vertices()) {
      if (vertex->IsFixed()) problem.SetParameterBlockConstant(Data(vertex->Id()));
    }
  }
  double* Data(int vertex) { return states[static_cast<size_t>(vertex)].data(); }

  G2oFile file;
  std::vector<Vec7> states;
  ceres::Problem problem;
};

}  // namespace

PeerResult SolvePoseGraphWithCeres(const std::string& path, const PeerOptions& options) {
  PoseGraph graph(path);
  PeerOptions sparse = options;
  sparse.linear_solver = LinearSolver::kSparseNormal;
  return SolveWithCeres(sparse, nullptr, &graph.problem);
}

PeerResult PoseGraphCovariancesWithCeres(const std::string& path, const PeerOptions& options) {
  PoseGraph graph(path);
  std::vector<const double*> poses;
  for (const auto& vertex : graph.file.graph.Vertices()) {
    if (!vertex->IsFixed()) poses.push_back(graph.Data(vertex->Id()));
  }
  return CovariancesWithCeres(options, poses, &graph.problem);
}

}  // namespace ch5::peer
