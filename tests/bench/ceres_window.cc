#include "ch5_backend/experiments/studies/window_graph.h"
#include "ch5_backend/marginalize/edge_prior.h"
#include "ch5_backend/types/inertial/edge_imu.h"
#include "tests/bench/ceres_solve.h"

namespace ch5::peer {
namespace {

Qd Rotation(const double* pose) { return Qd(pose[6], pose[3], pose[4], pose[5]); }

// The landmark's residual of types/visual/edge_reprojection.h, as VINS-Mono writes it: host, target, extrinsic, 1/depth.
class Reprojection : public ceres::SizedCostFunction<2, 7, 7, 7, 1> {
 public:
  Reprojection(const Vec2& host, const Vec2& target, double sqrt_information)
      : f_(host.homogeneous()), u_(target), s_(sqrt_information) {}

  bool Evaluate(double const* const* x, double* residuals, double** jacobians) const override {
    const Eigen::Map<const Vec3> p_i(x[0]), p_j(x[1]), p_e(x[2]);
    const Mat33 R_i = Rotation(x[0]).toRotationMatrix(), R_j = Rotation(x[1]).toRotationMatrix();
    const Mat33 R_e = Rotation(x[2]).toRotationMatrix();
    const double inverse_depth = x[3][0];
    const Vec3 p_Ci = f_ / inverse_depth, p_Bi = R_e * p_Ci + p_e, p_W = R_i * p_Bi + p_i;
    const Vec3 p_Bj = R_j.transpose() * (p_W - p_j), p_Cj = R_e.transpose() * (p_Bj - p_e);
    const double z_inverse = 1.0 / p_Cj.z();
    Eigen::Map<Vec2>{residuals} = s_ * (p_Cj.head<2>() * z_inverse - u_);
    if (!jacobians) return true;

    RowMajor<2, 3> dr_dp_Cj;
    dr_dp_Cj << s_ * z_inverse, 0, -s_ * p_Cj.x() * z_inverse * z_inverse,  //
        0, s_ * z_inverse, -s_ * p_Cj.y() * z_inverse * z_inverse;
    const RowMajor<2, 3> dr_dp_Bj = dr_dp_Cj * R_e.transpose(), dr_dp_W = dr_dp_Bj * R_j.transpose();
    const RowMajor<2, 3> dr_dp_Bi = dr_dp_W * R_i;
    if (jacobians[0]) Fill(dr_dp_W, dr_dp_Bi * Hat(-p_Bi), jacobians[0]);
    if (jacobians[1]) Fill(-dr_dp_W, dr_dp_Bj * Hat(p_Bj), jacobians[1]);
    if (jacobians[2]) {
      const RowMajor<2, 3> dr_dp_Ci = dr_dp_Bi * R_e;
      Fill(dr_dp_Bi - dr_dp_Bj, dr_dp_Cj * Hat(p_Cj) - dr_dp_Ci * Hat(p_Ci), jacobians[2]);
    }
    if (jacobians[3]) Eigen::Map<Vec2>{jacobians[3]} = dr_dp_Bi * (R_e * (p_Ci / -inverse_depth));
    return true;
  }

 private:
  static void Fill(const RowMajor<2, 3>& dp, const RowMajor<2, 3>& dtheta, double* out) {
    Eigen::Map<RowMajor<2, 7>>(out) << dp, dtheta, Vec2::Zero();
  }
  Vec3 f_;
  Vec2 u_;
  double s_;
};

// An edge of ours as a cost function of Ceres: its vertices are copies that take Ceres' states.
class OfEdge : public ceres::CostFunction {
 public:
  OfEdge(std::shared_ptr<Edge> edge, std::vector<std::shared_ptr<Vertex>> vertices)
      : edge_(std::move(edge)), vertices_(std::move(vertices)), root_(edge_->Information().llt().matrixU()) {
    is_white_ = root_.isIdentity(0.0);
    set_num_residuals(edge_->ResidualDimension());
    for (const auto& vertex : vertices_) mutable_parameter_block_sizes()->push_back(vertex->Dimension());
  }

  bool Evaluate(double const* const* x, double* residuals, double** jacobians) const override {
    for (size_t i = 0; i < vertices_.size(); ++i) std::copy_n(x[i], vertices_[i]->Dimension(), Data(i));
    edge_->ComputeResidual();
    Eigen::Map<VecX> r(residuals, num_residuals());
    is_white_ ? r = edge_->Residual() : r.noalias() = root_ * edge_->Residual();
    if (!jacobians) return true;
    edge_->ComputeJacobians();
    for (size_t i = 0; i < vertices_.size(); ++i) {
      if (!jacobians[i]) continue;
      const int local = vertices_[i]->LocalDimension(), size = vertices_[i]->Dimension();
      Eigen::Map<Eigen::Matrix<double, -1, -1, Eigen::RowMajor>> J(jacobians[i], num_residuals(), size);
      if (is_white_) {
        J.leftCols(local) = edge_->Jacobian(i);
      } else {
        J.leftCols(local).noalias() = root_ * edge_->Jacobian(i);
      }
      J.rightCols(size - local).setZero();
    }
    return true;
  }

 private:
  double* Data(size_t i) const { return vertices_[i]->Parameters().data(); }
  std::shared_ptr<Edge> edge_;
  std::vector<std::shared_ptr<Vertex>> vertices_;
  MatXX root_;
  bool is_white_;
};

// Ceres' states are those of a window graph of its own; the cost functions of IMU and prior stand on another one.
class Race {
 public:
  Race(const WindowDump& dump, const PeerOptions& options)
      : dump_(dump), options_(options), states_(BuildWindowGraph(dump)), copies_(BuildWindowGraph(dump)) {}

  PeerResult Solve() {
    AddAll();
    return SolveWithCeres(options_, ordering_, &problem_);
  }

  PeerResult Covariances() {
    AddAll();
    std::vector<const double*> poses;
    for (const auto& pose : states_.poses) {
      if (!pose->IsFixed()) poses.push_back(Data(pose));
    }
    return CovariancesWithCeres(options_, poses, &problem_);
  }

 private:
  static double* Data(const std::shared_ptr<Vertex>& vertex) { return vertex->Parameters().data(); }

  void AddAll() {
    AddStates();
    AddLandmarks();
    for (const auto& edge : copies_.graph.Edges()) {
      const bool is_imu = dynamic_cast<EdgeImu*>(edge.get());
      if (is_imu || dynamic_cast<EdgePrior*>(edge.get())) AddEdge(edge);
    }
  }

  void AddStates() {
    const auto add = [&](const std::shared_ptr<Vertex>& vertex, ceres::Manifold* manifold, int group) {
      problem_.AddParameterBlock(Data(vertex), vertex->Dimension(), manifold);
      if (vertex->IsFixed()) problem_.SetParameterBlockConstant(Data(vertex));
      ordering_->AddElementToGroup(Data(vertex), group);
    };
    for (const auto& pose : states_.poses) add(pose, new PoseManifold, 1);
    for (const auto& speed_bias : states_.speed_biases) add(speed_bias, nullptr, 1);
    add(states_.extrinsic, new PoseManifold, 1);
    for (const auto& landmark : states_.landmarks) add(landmark, nullptr, 0);
  }

  void AddLandmarks() {
    ceres::LossFunction* loss = nullptr;
    if (dump_.loss == WindowDump::Loss::kHuber) loss = new ceres::HuberLoss(dump_.loss_parameter);
    if (dump_.loss == WindowDump::Loss::kCauchy) loss = new ceres::CauchyLoss(dump_.loss_parameter);
    for (size_t l = 0; l < dump_.landmarks.size(); ++l) {
      const WindowDump::Landmark& landmark = dump_.landmarks[l];
      for (const WindowDump::Observation& seen : landmark.observations) {
        problem_.AddResidualBlock(new Reprojection(landmark.x_host, seen.x, dump_.sqrt_information), loss,
                                  Data(states_.poses[static_cast<size_t>(landmark.host)]),
                                  Data(states_.poses[static_cast<size_t>(seen.frame)]), Data(states_.extrinsic),
                                  Data(states_.landmarks[l]));
      }
    }
  }

  void AddEdge(const std::shared_ptr<Edge>& edge) {
    std::vector<double*> states;
    for (const auto& vertex : edge->Vertices()) states.push_back(Data(states_.graph.Vertices()[vertex->Id()]));
    problem_.AddResidualBlock(new OfEdge(edge, edge->Vertices()), nullptr, states);
  }

  const WindowDump& dump_;
  PeerOptions options_;
  WindowGraph states_, copies_;
  ceres::Problem problem_;
  std::shared_ptr<ceres::ParameterBlockOrdering> ordering_ = std::make_shared<ceres::ParameterBlockOrdering>();
};

}  // namespace

PeerResult SolveWindowWithCeres(const WindowDump& dump, const PeerOptions& options) {
  return Race(dump, options).Solve();
}

PeerResult WindowCovariancesWithCeres(const WindowDump& dump, const PeerOptions& options) {
  return Race(dump, options).Covariances();
}

}  // namespace ch5::peer
