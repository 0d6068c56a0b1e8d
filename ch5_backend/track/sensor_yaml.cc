#include "ch5_backend/track/sensor_yaml.h"

#include <sstream>

#include <Eigen/LU>

#include "ch5_backend/math/transform.h"
#include "ch5_backend/types/recording.h"

namespace ch5 {

std::string SensorYaml::Name(const std::string& euroc, const std::string& kalibr) const {
  return Has(euroc) || !Has(kalibr) ? euroc : kalibr;
}

Transform SensorYaml::T_B_S() const {
  if (Has("T_imu_cam")) return RigidTransform("T_imu_cam");
  const bool is_kalibrs = !Has("T_BS.data") && !Has("T_BS") && Has("distortion_coeffs");
  if (is_kalibrs || Has("T_cam_imu")) return Inverse(RigidTransform("T_cam_imu"));
  return RigidTransform(Has("T_BS.data") || !Has("T_BS") ? "T_BS.data" : "T_BS");
}

Transform SensorYaml::RigidTransform(const std::string& key) const {
  const std::vector<double> numbers = Numbers(key, 16);
  const Eigen::Matrix4d T = Eigen::Map<const Eigen::Matrix4d>(numbers.data()).transpose();
  const Mat33 R = T.topLeftCorner<3, 3>();
  constexpr double kTolerance = 1e-3;
  if ((T.row(3) - Eigen::RowVector4d(0, 0, 0, 1)).cwiseAbs().maxCoeff() > kTolerance) {
    std::string row;
    for (int i = 12; i < 16; ++i) row += " " + std::to_string(numbers[static_cast<size_t>(i)]);
    Fail(key, "the last row must be 0 0 0 1, got" + row + "; the numbers stand row by row");
  }
  const double error = (R.transpose() * R - Mat33::Identity()).cwiseAbs().maxCoeff();
  if (error > kTolerance || R.determinant() < 0.0) {
    Fail(key, "the upper left 3 × 3 part must be a rotation, but RᵀR differs from I by " + std::to_string(error) +
                  " and det R is " + std::to_string(R.determinant()));
  }
  const Vec3 p = T.topRightCorner<3, 1>();
  if (p.cwiseAbs().maxCoeff() > kLongestLever) {
    std::ostringstream point;
    point << p.x() << ", " << p.y() << ", " << p.z();
    Fail(key, "the last column must be in meters, got " + point.str());
  }
  return {Qd(R).normalized(), p};
}

}  // namespace ch5
