#pragma once
/// Why an estimator does not start: measurements in other units or columns than stated, as far as they show it.

#include <string>

#include "ch5_backend/types/measurements.h"

namespace ch5 {

/// Adds up what the IMU and the images have in common with gravity, with their noise and with one another.
class SensorCheck {
 public:
  void AddImu(const ImuMeasurement& measurement);
  void AddFrame(const Image& image);
  void Reset() { *this = SensorCheck(); }

  /// What is suspicious, in one sentence with the numbers; empty if nothing is. In a second of motion the mean specific
  /// force is near gravity, and a sensor's noise is what remains of three neighboring measurements.
  /// @param gravity [m/s²], noise  as given to the estimator
  std::string Suspicion(double gravity, const ImuNoise& noise) const;

 private:
  std::string SuspectForce(double gravity) const;
  std::string SuspectNoise(const ImuNoise& noise) const;

  int measurements_ = 0;
  double seconds_ = 0.0;
  double fastest_ = 0.0;             // ‖ω‖
  double force_ = 0.0, rate_ = 0.0;  // Σ ‖a‖, Σ ‖ω‖
  double force_scatter_ = 0.0;       // Σ ‖a₋₂ − 2 a₋₁ + a‖²
  ImuMeasurement last_, before_last_;
  Image last_image_;
  int images_ = 0;
  int tracked_ = 0;  // points seen in the image before, too
};

}  // namespace ch5
