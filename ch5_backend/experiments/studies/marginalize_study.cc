#include <cmath>
#include <string>

#include "ch5_backend/dense/problem.h"
#include "ch5_backend/experiments/studies/chapter_studies.h"
#include "ch5_backend/experiments/studies/matrices.h"
#include "ch5_backend/simulate/mono_ba.h"

namespace ch5 {
namespace {

constexpr int kFrames = 5, kPoints = 12, kPoseRows = 6 * kFrames;

// All entries: the zeros of a small matrix are part of its picture.
void AppendAll(const MatXX& M, const std::string& stage, CsvTable* table) {
  for (int row = 0; row < M.rows(); ++row) {
    for (int column = 0; column < M.cols(); ++column) table->Row(stage, row, column, M(row, column));
  }
}

MatXX SceneHessian() {
  const MonoBaOptions options{kFrames, kPoints};
  MonoBa ba = BuildMonoBa(SimulateMonoBa(options), Gauge::kFree, 1.0 / std::pow(options.pixel_sigma, 2), 0.0);
  Problem problem(&ba.graph);
  problem.Solve();
  problem.MakeHessian();
  return problem.Hessian();
}

MatXX Marginalize(const MatXX& H, int idx, int dim) {
  return Problem::TestMarginalize(H, VecX::Zero(H.rows()), idx, dim).H_prior;
}

void AppendStage(const MatXX& H, const std::string& stage, CsvTable* entries, CsvTable* fill) {
  AppendNonZeros(H, entries, stage);
  const auto non_zeros = (H.array() != 0.0).count();
  fill->Row(stage, H.rows(), non_zeros, static_cast<double>(non_zeros) / static_cast<double>(H.size()),
            NullDimension(H));
}

}  // namespace

void RunMarginalizeStudy(const std::filesystem::path& csv) {
  CsvTable chain("stage,row,column,value");
  const MarginalizeResult result = Problem::TestMarginalize(SlidesChain(), VecX::Zero(3), /*idx=*/1, /*dim=*/1);
  AppendAll(SlidesChain(), "before", &chain);
  AppendAll(result.H_moved, "moved", &chain);
  AppendAll(result.H_prior, "after", &chain);

  CsvTable entries("stage,row,column,value");
  CsvTable fill("stage,size,non_zeros,density,null_dimension");
  const MatXX H = SceneHessian();
  const MatXX without_landmarks = Marginalize(H, kPoseRows, kPoints);
  AppendStage(H, "before", &entries, &fill);
  AppendStage(without_landmarks, "without landmarks", &entries, &fill);
  AppendStage(Marginalize(without_landmarks, 0, 6), "without landmarks and frame 0", &entries, &fill);
  AppendStage(Marginalize(H, 0, 6), "without frame 0", &entries, &fill);

  chain.Write(csv / "marginalize_chain.csv");
  entries.Write(csv / "marginalize_scene.csv");
  fill.Write(csv / "marginalize_fill.csv");
}

}  // namespace ch5
