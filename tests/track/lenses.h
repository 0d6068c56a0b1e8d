#pragma once
/// Two cameras to render with: distortions of the size that EuRoC's and TUM-VI's cameras have.

#include "tests/track/textured_room.h"

namespace ch5 {

inline RenderOptions EurocLens() {
  RenderOptions options;
  options.lens.k << -0.28, 0.07, 0.0002, -0.0001;
  return options;
}

inline RenderOptions StereoLenses() {
  RenderOptions options = EurocLens();
  options.calibration.camera1 = ForwardStereo().camera1;
  // Toed in and rolled a little, as no real pair is parallel.
  options.calibration.camera1->T_B_C.q = options.calibration.T_B_C.q * ExpSO3({0.01, -0.02, 0.015});
  return options;
}

inline RenderOptions WideLens() {
  RenderOptions options;
  options.lens.model = Lens::Model::kEquidistant;
  options.lens.k << 0.0035, 0.0007, -0.002, 0.0002;
  Calibration& c = options.calibration;
  c.fx = c.fy = 190.0;
  c.cx = c.cy = 255.5;
  c.width = c.height = 512;
  return options;
}

inline RenderOptions DoubleSphereLens() {
  RenderOptions options = WideLens();
  options.lens.model = Lens::Model::kDoubleSphere;
  options.lens.k << -0.25, 0.57, 0, 0;
  return options;
}

inline RenderOptions FieldOfViewLens() {
  RenderOptions options = WideLens();
  options.lens.model = Lens::Model::kFieldOfView;
  options.lens.k << 0.92, 0, 0, 0;
  return options;
}

}  // namespace ch5
