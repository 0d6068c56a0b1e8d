// Covariances in a free and in a fixed gauge, and from one into the other.  Zhang (2018), §VI
#include "ch5_backend/experiments/studies/gauge/gauge_solve.h"
#include "ch5_backend/experiments/studies/gauge/gauge_studies.h"

namespace ch5 {
namespace {

// Σ of `from` in the gauge of `to`.
MatXX Transformed(const GaugeSolution& from, const GaugeSolution& to, bool to_fixed) {
  const auto projection = [to_fixed](const GaugeSolution& at) {
    const MatXX U = GaugeNullSpace(at.vertices, GaugeGroup::kVisualInertial);
    return GaugeProjection(U, to_fixed ? HeldColumns(at.vertices, HoldGauge(at.problem.first)) : U);
  };
  const double yaw = LogSO3(to.problem.first->q() * from.problem.first->q().conjugate()).z();
  return TransformCovariance(from.covariance, GaugeMotionJacobian(from.vertices, yaw), projection(from),
                             projection(to));
}

struct FourCovariances {
  explicit FourCovariances(const VisualInertialScene& scene)
      : fixed(SolveForCovariance(scene, GaugeHandling::kFixation)),
        free(SolveForCovariance(scene, GaugeHandling::kFree)),
        free_to_fixed(Transformed(free, fixed, true)),
        fixed_to_free(Transformed(fixed, free, false)) {}

  std::vector<std::pair<const char*, const MatXX*>> Named() const {
    return {{"fixed", &fixed.covariance},
            {"free", &free.covariance},
            {"free to fixed", &free_to_fixed},
            {"fixed to free", &fixed_to_free}};
  }

  GaugeSolution fixed, free;
  MatXX free_to_fixed, fixed_to_free;
};

double Distance(const MatXX& A, const MatXX& B) { return (A - B).norm() / B.norm(); }

}  // namespace

CsvTable GaugeCovarianceTable(int trial, const std::filesystem::path&) {
  CsvTable table("path,points,trial,free_untransformed,free_to_fixed,fixed_untransformed,fixed_to_free");
  for (const GaugeConfiguration& configuration : GaugeConfigurations(trial)) {
    const FourCovariances all(SimulateVisualInertial(configuration.options));
    const MatXX &fixed = all.fixed.covariance, &free = all.free.covariance;
    table.Row(configuration.path, configuration.points, trial, Distance(free, fixed),
              Distance(all.free_to_fixed, fixed), Distance(fixed, free), Distance(all.fixed_to_free, free));
  }
  return table;
}

CsvTable GaugeDeviationsTable(int trial, const std::filesystem::path&) {
  CsvTable table("gauge,keyframe,time_s,position_m,rotation_deg,velocity_m_s");
  const VisualInertialScene scene = SimulateVisualInertial(GaugeConfigurations(trial).front().options);
  const FourCovariances all(scene);
  for (const auto& [name, covariance] : all.Named()) {
    for (size_t i = 0; i < scene.truth.size(); ++i) {
      const auto deviation = [&, C = covariance](int row) {
        return std::sqrt(C->diagonal().segment<3>(15 * static_cast<int>(i) + row).sum());
      };
      table.Row(name, i, scene.truth[i].t, deviation(0), deviation(3) * 180.0 / M_PI, deviation(6));
    }
  }
  return table;
}

CsvTable GaugeMatricesTable(int trial, const std::filesystem::path&) {
  CsvTable table("gauge,row,column,value");
  const VisualInertialScene scene = SimulateVisualInertial(GaugeConfigurations(trial).front().options);
  const FourCovariances all(scene);
  std::vector<int> rows;  // p, δθ, v of each keyframe
  for (int i = 0; i < static_cast<int>(scene.truth.size()); ++i) {
    for (int k = 0; k < 9; ++k) rows.push_back(15 * i + k);
  }
  for (const auto& [name, covariance] : all.Named()) {
    const MatXX part = (*covariance)(rows, rows);
    for (int row = 0; row < part.rows(); ++row) {
      for (int column = 0; column <= row; ++column) table.Row(name, row, column, part(row, column));
    }
  }
  return table;
}

}  // namespace ch5
