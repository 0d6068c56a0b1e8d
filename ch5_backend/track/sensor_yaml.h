#pragma once
/// What a YAML file says of a sensor: a `sensor.yaml` of EuRoC's layout, or one of Kalibr's, which has a section for each sensor
/// and some keys of other names. Unknown keys are ignored: publishers add their own.

#include "ch5_backend/files/yaml_file.h"
#include "ch5_backend/math/so3.h"

namespace ch5 {

class SensorYaml : public YamlFile {
 public:
  using YamlFile::YamlFile;

  /// EuRoC's name of a key, unless only Kalibr's is there.
  std::string Name(const std::string& euroc, const std::string& kalibr) const;
  /// T_BS, which maps sensor coordinates into the body's, as 16 numbers row by row; or Kalibr's T_cam_imu, its inverse, or
  /// OpenVINS's T_imu_cam.
  /// @throws FileError unless RᵀR = I and det R = 1 within 1e-3, and the last row is 0 0 0 1
  Transform T_B_S() const;

 private:
  Transform RigidTransform(const std::string& key) const;
};

}  // namespace ch5
