#pragma once
/// The course's matrix names. Dynamic: VecX, MatXX; fixed: Vec3, Mat33, Mat66 …; quaternion Qd (x, y, z, w).

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace ch5 {

using VecX = Eigen::VectorXd;
using MatXX = Eigen::MatrixXd;

using Vec2 = Eigen::Vector2d;
using Vec3 = Eigen::Vector3d;
using Vec6 = Eigen::Matrix<double, 6, 1>;
using Vec7 = Eigen::Matrix<double, 7, 1>;
using Vec9 = Eigen::Matrix<double, 9, 1>;

using Mat22 = Eigen::Matrix2d;
using Mat23 = Eigen::Matrix<double, 2, 3>;
using Mat26 = Eigen::Matrix<double, 2, 6>;
using Mat29 = Eigen::Matrix<double, 2, 9>;
using Mat33 = Eigen::Matrix3d;
using Mat66 = Eigen::Matrix<double, 6, 6>;

using Qd = Eigen::Quaterniond;

}  // namespace ch5
