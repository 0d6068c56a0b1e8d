#include <Eigen/Cholesky>
#include <memory>

#include "ch5_backend/experiments/studies/pose_graph_study.h"
#include "ch5_backend/types/pose_graph/edge_between.h"
#include "tests/bench/ceres_solve.h"

namespace ch5::peer {
namespace {

using PosePointer = std::shared_ptr<VertexPose>;
using PlanarPointer = std::shared_ptr<VertexSE2>;

// The same measurement between other poses.
EdgeSE3Between Copy(const EdgeSE3Between& edge, const PosePointer& i, const PosePointer& j) {
  return {i, j, edge.q_z(), edge.p_z()};
}
EdgeSE2Between Copy(const EdgeSE2Between& edge, const PlanarPointer& i, const PlanarPointer& j) {
  return {i, j, edge.p_z(), edge.ThetaZ()};
}

// The residual of EdgeSE3Between or EdgeSE2Between, whitened by a factor of W that is worked out once.
template <typename EdgeBetween, typename Pose>
class Between : public ceres::SizedCostFunction<EdgeBetween::kResidualDimension, Pose::kDimension, Pose::kDimension> {
  static constexpr int R = EdgeBetween::kResidualDimension, D = Pose::kDimension;  // NOLINT: Ceres' letters
  using Square = Eigen::Matrix<double, R, R>;

 public:
  explicit Between(const EdgeBetween& edge)
      : root_(Square(edge.W()).llt().matrixU()),
        i_(std::make_shared<Pose>()),
        j_(std::make_shared<Pose>()),
        edge_(Copy(edge, i_, j_)) {}

  bool Evaluate(double const* const* x, double* residuals, double** jacobians) const override {
    i_->SetEstimate(Eigen::Map<const typename Pose::Estimate>(x[0]));
    j_->SetEstimate(Eigen::Map<const typename Pose::Estimate>(x[1]));
    edge_.ComputeResidual();
    Eigen::Map<Eigen::Matrix<double, R, 1>>{residuals}.noalias() = root_ * edge_.GetResidual();
    if (!jacobians) return true;
    edge_.ComputeJacobians();
    if (jacobians[0]) Fill(std::as_const(edge_).template J<0>(), jacobians[0]);
    if (jacobians[1]) Fill(std::as_const(edge_).template J<1>(), jacobians[1]);
    return true;
  }

 private:
  // By the increment, in the first R columns.
  void Fill(const Square& J, double* out) const {
    Eigen::Map<RowMajor<R, D>> target(out);
    target.template leftCols<R>().noalias() = root_ * J;
    target.template rightCols<D - R>().setZero();
  }

  Square root_;
  std::shared_ptr<Pose> i_, j_;
  mutable EdgeBetween edge_;  // each block of a problem is evaluated by one thread at a time
};

ceres::CostFunction* MakeBetween(const Edge& edge) {
  if (const auto* planar = dynamic_cast<const EdgeSE2Between*>(&edge)) {
    return new Between<EdgeSE2Between, VertexSE2>(*planar);
  }
  return new Between<EdgeSE3Between, VertexPose>(dynamic_cast<const EdgeSE3Between&>(edge));
}

// A pose graph with Ceres' states.
struct PoseGraph {
  explicit PoseGraph(const std::string& path) : file(ReadG2o(path)) {
    FixFreeParts(file.graph);
    for (const auto& vertex : file.graph.Vertices()) states.push_back(vertex->Parameters());
    for (const auto& edge : file.graph.Edges()) {
      const int i = edge->Vertices()[0]->Id(), j = edge->Vertices()[1]->Id();
      for (const int k : {i, j}) AddPose(*file.graph.Vertices()[static_cast<size_t>(k)]);
      problem.AddResidualBlock(MakeBetween(*edge), nullptr, Data(i), Data(j));
    }
    for (const auto& vertex : file.graph.Vertices()) {
      if (vertex->IsFixed()) problem.SetParameterBlockConstant(Data(vertex->Id()));
    }
  }
  double* Data(int vertex) { return states[static_cast<size_t>(vertex)].data(); }
  void AddPose(const Vertex& vertex) {
    problem.AddParameterBlock(Data(vertex.Id()), vertex.Dimension());
    if (vertex.Dimension() == 7) problem.SetManifold(Data(vertex.Id()), &manifold);  // poses in the plane add
  }
  static ceres::Problem::Options KeepManifold() {
    ceres::Problem::Options options;
    options.manifold_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
    return options;
  }

  G2oFile file;
  std::vector<VecX> states;
  PoseManifold manifold;
  ceres::Problem problem{KeepManifold()};
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
