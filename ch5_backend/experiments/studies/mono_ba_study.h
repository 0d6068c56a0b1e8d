#pragma once
/// Bundle adjustment of the course's scene and of a larger one: how it converges, what it finds, what H looks like.

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "ch5_backend/dense/problem.h"
#include "ch5_backend/evaluate/reconstruction.h"

namespace ch5 {

struct MonoBaCase {
  std::string name;
  MonoBaOptions scene;
  Gauge gauge;
  double prior_weight;
  double pixel_information;  ///< W = pixel_information·I₂
  Damping damping;
};

/// "course": 3 frames × 20 points as the course sets it: poses start at the truth, two are fixed, W = I.
/// "large": 10 × 300, poses start 20 cm and 3° (one σ, each axis) beside the truth, W = 1/σ², minimal gauge.
std::vector<MonoBaCase> MonoBaCases();

/// The scene with a free gauge at the given states.
MonoBa FreeMonoBa(const MonoBaScene& scene, double pixel_information, const MonoBa& states);

/// H of a graph with a free gauge, and its Schur complement on the poses.
struct HessianPair {
  MatXX H;  ///< n×n, n = 6·frames + points
  MatXX S;  ///< (6·frames)²:  H_pp − H_pl H_ll⁻¹ H_lp
};
HessianPair FreeHessian(MonoBa* free);

/// Writes mono_ba_….csv (summary, trace, frames, points, iterations), hessian.csv, spectrum.csv, and hessian_….csv
/// (vertices, edges, blocks).
/// @param progress  called with the fraction done;  @throws WriteError
void RunMonoBaStudy(const std::filesystem::path& csv, const std::function<void(double)>& progress);

}  // namespace ch5
