#pragma once
// A window dump that needs no data, and whose cost at its estimates is known in closed form.
#include <cmath>
#include <sstream>
#include <string>

#include "ch5_backend/types/recording.h"

namespace ch5::test {

struct MadeUpWindow {
  std::string text;      ///< VIOWIN 1
  double cost = 0.0;     ///< ½ Σ ρ at the estimates, which are the truth
  double squares = 0.0;  ///< Σ of the observations' squared offsets, on the normalized plane
  int observations = 0;
};

/// Eleven frames along p = ½ a t² that do not turn, so that the midpoint rule integrates the IMU exactly: its residuals are 0
/// at the truth. Forty landmarks, each observation off by a known offset; a prior on frame 0 whose r is 0.1 in each row.
inline MadeUpWindow MakeWindow() {
  constexpr int kFrames = 11, kSamples = 21, kLandmarks = 40;
  constexpr double kStep = 0.1, kInformation = 306.0, kOffset = 1.0 / kInformation;
  const Vec3 a(0.8, 0.3, 0.2);
  const Transform T_B_C{Qd(-0.5, 0.5, -0.5, 0.5), Vec3(0.05, 0.02, -0.01)};
  const auto position = [&](int frame) -> Vec3 { return 0.5 * std::pow(kStep * frame, 2) * a; };
  MadeUpWindow window;
  std::ostringstream out;
  out.precision(17);
  const Eigen::IOFormat row(Eigen::FullPrecision, Eigen::DontAlignCols, " ", " ");
  out << "VIOWIN 1\nG 0 0 9.81\nNOISE 0.08 0.004 4e-05 2e-06\nSQRTINFO " << kInformation << "\nLOSS cauchy 1\nEXT "
      << T_B_C.p.transpose().format(row) << ' ' << T_B_C.q.coeffs().transpose().format(row) << " 1\nFRAMES " << kFrames
      << '\n';
  for (int i = 0; i < kFrames; ++i) {
    std::ostringstream state;
    state << position(i).transpose().format(row) << " 0 0 0 1 " << (kStep * i * a).transpose().format(row)
          << " 0 0 0 0 0 0\n";
    out << "F " << i << ' ' << kStep * i << ' ' << state.str() << "T " << i << ' ' << state.str();
  }
  out << "IMUS " << kFrames - 1 << '\n';
  for (int i = 0; i + 1 < kFrames; ++i) {
    out << "I " << i << ' ' << i + 1 << ' ' << kSamples << " 0 0 0 0 0 0\n";
    for (int k = 0; k < kSamples; ++k) {
      out << (k == 0 ? 0.0 : kStep / (kSamples - 1)) << ' ' << (a + Vec3(0, 0, 9.81)).transpose().format(row)
          << " 0 0 0\n";
    }
  }
  out << "LANDMARKS " << kLandmarks << '\n';
  for (int k = 0; k < kLandmarks; ++k) {
    const Vec3 p_W(4.0 + 0.1 * k, 2.0 * std::sin(1.7 * k), 2.0 * std::cos(2.3 * k));
    const auto seen_from = [&](int frame) -> Vec3 { return T_B_C.q.conjugate() * (p_W - position(frame) - T_B_C.p); };
    const int host = k % 3;
    const Vec3 p_C = seen_from(host);
    out << "L " << k << ' ' << host << ' ' << kFrames - 1 - host << ' ' << 1.0 / p_C.z() << ' ' << 1.0 / p_C.z() << ' '
        << p_C.hnormalized().transpose().format(row) << '\n';
    for (int i = host + 1; i < kFrames; ++i) {
      const Vec2 offset = kOffset * Vec2(std::sin(k + 3.0 * i), std::cos(2.0 * k + i));
      out << i << ' ' << (seen_from(i).hnormalized() + offset).transpose().format(row) << '\n';
      window.squares += offset.squaredNorm();
      window.cost += 0.5 * std::log1p(kInformation * kInformation * offset.squaredNorm());  // Cauchy's ρ
      ++window.observations;
    }
  }
  out << "PRIOR 15 2\nB P 0 7 0 0 0 0 0 0 1\nB S 0 9 0 0 0 0 0 0 0 0 0\nR";
  for (int i = 0; i < 15; ++i) out << " 0.1";
  window.cost += 0.5 * 15 * 0.1 * 0.1;
  out << "\nJ " << (100.0 * Eigen::Matrix<double, 15, 15>::Identity()).format(row) << "\nFIXED 0\nEND\n";
  window.text = out.str();
  return window;
}

}  // namespace ch5::test
