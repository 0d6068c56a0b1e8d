#include "ch5_homework/judge/stage_4_scene.h"

#include <Eigen/Dense>
#include <cmath>

namespace ch5::homework {
namespace {

// The motion along the directions of the gauge: a shift, a turn about each axis, a scale.
Motion Along(GaugeGroup group, const VecX& delta) {
  const MatXX axes = AxesOf(group);
  const double s = delta.size() > 6 ? std::exp(delta[6]) : 1.0;
  return {s, ExpSO3(axes * delta.segment(3, axes.cols())), delta.head<3>()};
}

// What g makes of a vertex, as a step from x0.
VecX Moved(const Motion& g, Vertex* vertex, const VecX& x0) {
  const VecX before = vertex->Parameters();
  g.ActOn(vertex);
  const VecX step = vertex->Minus(x0);
  vertex->Parameters() = before;
  return step;
}

}  // namespace

void Motion::ActOn(Vertex* vertex) const {
  if (auto* pose = dynamic_cast<VertexPose*>(vertex)) {
    pose->SetPose(R * pose->q(), *this * pose->p());
  } else if (auto* point = dynamic_cast<VertexPointXYZ*>(vertex)) {
    point->SetEstimate(*this * point->GetEstimate());
  } else if (auto* inverse_depth = dynamic_cast<VertexInverseDepth*>(vertex)) {
    inverse_depth->Parameters() /= s;
  } else if (auto* speed_bias = dynamic_cast<VertexSpeedBias*>(vertex)) {
    speed_bias->Parameters().head<3>() = s * (R * speed_bias->v());
  }
}

void MoveAll(const Motion& g, const Vertices& vertices) {
  for (const auto& vertex : vertices) g.ActOn(vertex.get());
}

Names DirectionNames(GaugeGroup group) {
  Names names = {Word("x"), Word("y"), Word("z"), "scene.yaw", "scene.roll", "scene.pitch", "scene.scale"};
  names.resize(group == GaugeGroup::kVisualInertial ? 4 : 7);
  return names;
}

Text NameOf(GaugeGroup group) { return group == GaugeGroup::kVisualInertial ? "4.camera_IMU" : "4.camera_alone"; }

MatXX AxesOf(GaugeGroup group) {
  MatXX axes(3, group == GaugeGroup::kVisualInertial ? 1 : 3);
  axes.col(0) = Vec3::UnitZ();
  if (axes.cols() == 3) axes.rightCols<2>() = Mat33::Identity().leftCols<2>();
  return axes;
}

MatXX NumericNullSpace(const Vertices& vertices, GaugeGroup group) {
  const int columns = static_cast<int>(DirectionNames(group).size());
  MatXX U(TotalLocalDimension(vertices), columns);
  int row = 0;
  for (const auto& vertex : vertices) {
    const VecX x = vertex->Parameters();
    const auto moved = [&](const VecX& delta) { return Moved(Along(group, delta), vertex.get(), x); };
    U.middleRows(row, vertex->LocalDimension()) = Differences(columns, moved);
    row += vertex->LocalDimension();
  }
  return U;
}

MatXX NumericMotionJacobian(const Vertices& vertices, const Motion& g) {
  const int n = TotalLocalDimension(vertices);
  MatXX J = MatXX::Zero(n, n);
  int row = 0;
  for (const auto& vertex : vertices) {
    const int dim = vertex->LocalDimension();
    const VecX x = vertex->Parameters();
    g.ActOn(vertex.get());
    const VecX y = vertex->Parameters();
    J.block(row, row, dim, dim) = Differences(dim, [&](const VecX& delta) {
      vertex->Parameters() = x;
      vertex->Plus(delta.data());
      return Moved(g, vertex.get(), y);
    });
    vertex->Parameters() = x;
    row += dim;
  }
  return J;
}

MatXX FreeScene::Hessian() const { return StackedNormalEquations(graph, TotalLocalDimension(vertices)).H; }

MatXX FreeScene::FirstFrame(GaugeGroup group) const {
  const auto& first = dynamic_cast<const VertexPose&>(*vertices[0]);
  const auto& second = dynamic_cast<const VertexPose&>(*vertices[1]);
  MatXX V = MatXX::Zero(TotalLocalDimension(vertices), static_cast<Eigen::Index>(DirectionNames(group).size()));
  V.topLeftCorner<3, 3>().setIdentity();
  if (group == GaugeGroup::kVisualInertial) {
    V.block<3, 1>(3, 3) = first.R().transpose() * Vec3::UnitZ();  // e_zᵀ R δθ
  } else {
    V.block<3, 3>(3, 3).setIdentity();
    V.block<3, 1>(6, 6) = (second.p() - first.p()).normalized();
  }
  return V;
}

MatXX FreeCovariance(const MatXX& H, int nullity) {
  const Eigen::SelfAdjointEigenSolver<MatXX> eigen(H);
  const Eigen::Index rank = H.rows() - nullity;
  const MatXX range = eigen.eigenvectors().rightCols(rank);
  return range * eigen.eigenvalues().tail(rank).cwiseInverse().asDiagonal() * range.transpose();
}

MatXX FixedCovariance(const MatXX& H, const MatXX& V) {
  const MatXX N = Complement(V);
  return N * (N.transpose() * H * N).ldlt().solve(N.transpose());
}

MatXX Complement(const MatXX& V) {
  const MatXX basis = Eigen::HouseholderQR<MatXX>(V).householderQ();
  return basis.rightCols(V.rows() - V.cols());
}

MatXX ProjectionByItsEffect(const MatXX& U, const MatXX& V) {
  MatXX basis(U.rows(), U.rows()), image = MatXX::Zero(U.rows(), U.rows());
  basis << U, Complement(V);
  image.rightCols(U.rows() - U.cols()) = Complement(V);
  return image * basis.inverse();
}

}  // namespace ch5::homework
