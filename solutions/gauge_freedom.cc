// Homework of chapter 5, stage 4.  Handout: ch5_homework/handout/stage_4.md, .zh.md.
#include "ch5_backend/consistency/gauge_freedom.h"

#include "ch5_backend/homework_missing.h"
#include "ch5_backend/types/vertices.h"

namespace ch5 {
namespace {

// The world turns about the columns of `axes`: e_z, or e_z, e_x, e_y.
using Axes = Eigen::Matrix<double, 3, Eigen::Dynamic>;

// The columns of U: [x y z | turns about the axes | scale].
MatXX PoseRows(const VertexPose& pose, const Axes& axes) {
  MatXX U = MatXX::Zero(6, 3 + axes.cols());
  const Vec3 p = pose.p();
  const Mat33 R = pose.R();
  // TODO:: home work 4a. The pose's rows of U: p' = Exp(ω) p + t in rows 0–2, R' = Exp(ω) R = R Exp(δθ) in rows 3–5.
  // BEGIN SOLUTION 4a GaugeNullSpace, the rows of a pose
  U.topLeftCorner<3, 3>().setIdentity();
  U.topRightCorner(3, axes.cols()) = -Hat(p) * axes;
  U.bottomRightCorner(3, axes.cols()) = R.transpose() * axes;
  // BLANK
  // U.topLeftCorner<3, 3>() = ?;
  // U.topRightCorner(3, axes.cols()) = ?;
  // U.bottomRightCorner(3, axes.cols()) = ?;
  // END SOLUTION
  return U;
}

MatXX VelocityRows(const Vec3& v, const Axes& axes) {
  MatXX U = MatXX::Zero(3, 3 + axes.cols());
  // TODO:: home work 4b. The velocity's rows of U: v' = Exp(ω) v, whatever t is.
  // BEGIN SOLUTION 4b GaugeNullSpace, the rows of a velocity
  U.rightCols(axes.cols()) = -Hat(v) * axes;
  // BLANK
  // U.rightCols(axes.cols()) = ?;
  // END SOLUTION
  return U;
}

// X' = Exp(ω) X + t.
MatXX PointRows(const Vec3& X, const Axes& axes) {
  MatXX U(3, 3 + axes.cols());
  U.leftCols<3>().setIdentity();
  for (Eigen::Index k = 0; k < axes.cols(); ++k) U.col(3 + k) = axes.col(k).cross(X);
  return U;
}

// A pose, speed and biases, or a point: what begins with a vector of W, p, v or X.
bool BeginsInWorld(const Vertex& vertex) {
  return dynamic_cast<const VertexPose*>(&vertex) || dynamic_cast<const VertexSpeedBias*>(&vertex) ||
         dynamic_cast<const VertexPointXYZ*>(&vertex);
}

// ∂x/∂s at s = 1; a landmark s times as far has 1/s of its inverse depth.
VecX ScaleColumn(const Vertex& vertex) {
  VecX column = VecX::Zero(vertex.LocalDimension());
  if (BeginsInWorld(vertex)) column.head<3>() = vertex.Parameters().head<3>();
  if (dynamic_cast<const VertexInverseDepth*>(&vertex)) column = -vertex.Parameters();
  return column;
}

}  // namespace

// U: what moves with the world.  Zhang (2018), §III
MatXX GaugeNullSpace(const Vertices& vertices, GaugeGroup group) {
  const bool monocular = group == GaugeGroup::kMonocular;
  Axes axes = Vec3::UnitZ();
  if (monocular) axes = (Mat33() << Vec3::UnitZ(), Vec3::UnitX(), Vec3::UnitY()).finished();
  MatXX U = MatXX::Zero(TotalLocalDimension(vertices), NumGaugeDirections(group));
  int row = 0;
  for (const auto& vertex : vertices) {
    auto rows = U.block(row, 0, vertex->LocalDimension(), 3 + axes.cols());
    if (const auto* pose = dynamic_cast<const VertexPose*>(vertex.get())) {
      rows = PoseRows(*pose, axes);
    } else if (const auto* speed_bias = dynamic_cast<const VertexSpeedBias*>(vertex.get())) {
      rows.topRows(3) = VelocityRows(speed_bias->v(), axes);
    } else if (const auto* point = dynamic_cast<const VertexPointXYZ*>(vertex.get())) {
      rows = PointRows(point->GetEstimate(), axes);
    }
    if (monocular) U.col(6).segment(row, vertex->LocalDimension()) = ScaleColumn(*vertex);
    row += vertex->LocalDimension();
  }
  return U;
}

// Q, eq. 14 of Zhang (2018).
MatXX GaugeProjection(const MatXX& U, const MatXX& V) {
  const Eigen::Index n = U.rows();
  const MatXX VtU_inverse = InverseOfVtU(U, V);
  MatXX Q = MatXX::Identity(n, n);
  // TODO:: home work 4c. Q = I − U (VᵀU)⁻¹ Vᵀ.
  // BEGIN SOLUTION 4c GaugeProjection, Q
  Q -= U * VtU_inverse * V.transpose();
  // BLANK
  // Q -= ?;
  // END SOLUTION
  return Q;
}

// ∂θ_C/∂θ, from eq. 12 of Zhang (2018).
MatXX GaugeMotionJacobian(const Vertices& vertices, double yaw) {
  const Mat33 R_z = ExpSO3(Vec3(0, 0, yaw)).toRotationMatrix();
  const int n = TotalLocalDimension(vertices);
  MatXX motion = MatXX::Identity(n, n);
  int row = 0;
  for (const auto& vertex : vertices) {
    if (BeginsInWorld(*vertex)) {
      // TODO:: home work 4d. How the vertex's first three rows follow: p_C = R_z p + t, v_C = R_z v, X_C = R_z X + t.
      // BEGIN SOLUTION 4d GaugeMotionJacobian, positions, velocities and points
      motion.block<3, 3>(row, row) = R_z;
      // BLANK
      // motion.block<3, 3>(row, row) = ?;
      // END SOLUTION
    }
    row += vertex->LocalDimension();
  }
  return motion;
}

// Eq. 15 of Zhang (2018). One of Q and Q_C is enough.
MatXX TransformCovariance(const MatXX& covariance, const MatXX& motion, [[maybe_unused]] const MatXX& Q,
                          [[maybe_unused]] const MatXX& Q_C) {
  MatXX transformed = MatXX::Zero(covariance.rows(), covariance.cols());
  // TODO:: home work 4e. Cov_C out of Cov. motion = ∂θ_C/∂θ leads from θ, where Q is taken, to θ_C, where Q_C is.
  // BEGIN SOLUTION 4e TransformCovariance, the covariance of the other gauge
  const MatXX T = Q_C * motion;
  transformed = T * covariance * T.transpose();
  // BLANK
  // const MatXX T = ?;
  // transformed = ?;
  // END SOLUTION
  return transformed;
}

}  // namespace ch5
