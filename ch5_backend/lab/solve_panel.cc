#include <Eigen/Cholesky>
#include <cmath>

#include "ch5_backend/evaluate/reconstruction.h"
#include "ch5_backend/experiments/studies/matrices.h"
#include "ch5_backend/lab/panels.h"
#include "ch5_backend/lab/scene.h"

namespace ch5::lab {
namespace {

std::vector<Json> Trace(const Summary& summary) {
  std::vector<Json> rows;
  for (const IterationInfo& info : summary.trace) {
    Json row;
    row.Add("cost", info.cost).Add("lambda", info.lambda).Add("trials", info.trials);
    rows.push_back(row.Add("step", info.step_norm).Add("gradient", info.gradient_max));
  }
  return rows;
}

// ½ Σ ρ(rᵀWr) of the observations and of the priors, apart.
void AddCosts(const Graph& graph, Json* json) {
  double observations = 0.0, priors = 0.0;
  for (const auto& edge : graph.Edges()) {
    edge->ComputeResidual();
    (edge->TypeInfo() == "EdgeSE3Prior" ? priors : observations) += edge->Cost();
  }
  json->Add("observation_cost", observations).Add("prior_cost", priors);
}

// √(rᵀWr) of each observation [√W times the plane's unit], frames × landmarks; NaN where there is none.
MatXX Residuals(const SceneGraph& graph) {
  const auto rows = static_cast<Eigen::Index>(graph.ba.poses.size());
  MatXX norms = MatXX::Constant(rows, static_cast<Eigen::Index>(graph.ba.landmarks.size()), std::nan(""));
  for (const Observation& one : ObservationsOf(graph)) norms(one.frame, one.landmark) = std::sqrt(one.edge->Chi2());
  return norms;
}

// NullDimension scales H to a unit diagonal, rounding errors too: rows that have nothing else on it count here by themselves.
int DirectionsWithoutInformation(const MatXX& H, double pixel_information) {
  std::vector<int> seen;
  for (int i = 0; i < H.rows(); ++i) {
    if (H(i, i) > 1e-20 * pixel_information) seen.push_back(i);
  }
  const int unseen = static_cast<int>(H.rows()) - static_cast<int>(seen.size());
  return unseen + (seen.empty() ? 0 : NullDimension(H(seen, seen)));
}

// What the solver claims of x and y of each free camera: a block of H⁻¹, which is a covariance if W is the noise's
// information and H is regular. H is scaled to a unit diagonal before.
void AddClaims(const SceneGraph& graph, const MatXX& H, Json* json) {
  const VecX scale = H.diagonal().cwiseSqrt().cwiseInverse();
  const Eigen::LDLT<MatXX> ldlt(scale.asDiagonal() * H * scale.asDiagonal());
  std::vector<Json> claims;
  for (size_t i = 0; i < graph.ba.poses.size(); ++i) {
    const int row = graph.ba.poses[i]->OrderingId();
    if (row < 0) continue;
    MatXX columns = MatXX::Zero(H.rows(), 2);
    columns.middleRows<2>(row).diagonal() = scale.segment<2>(row);
    const Mat22 covariance = (scale.asDiagonal() * ldlt.solve(columns)).middleRows<2>(row);
    claims.push_back(ClaimJson(static_cast<int>(i), graph.ba.poses[i]->p(), graph.scene.frames[i].p, covariance));
  }
  json->Add("claims", claims).Add("claim_limit", ClaimLimit());
}

// H, S and their spectra at the present states. A singular H still has its pattern, and S up to the pivot that fails.
void AddMatrices(const SceneSettings& settings, SceneGraph* graph, Json* json) {
  Problem problem(&graph->ba.graph);
  problem.SetDamping(settings.damping);
  problem.MakeHessian();
  VecX unused;
  problem.SolveLinearSystem(0.0, &unused);
  const MatXX& H = problem.Hessian();
  const MatXX& S = problem.SchurComplement();
  json->Add("variables", VariablesOf(*graph)).Add("pose_rows", problem.GetOrdering().dim_poses);
  json->Add("H", H).Add("S", S);
  const int null_H = DirectionsWithoutInformation(H, settings.pixel_information);
  json->Add("spectrum_H", Eigenvalues(H)).Add("null_H", null_H);
  if (settings.is_calibrated && null_H == 0) AddClaims(*graph, H, json);
  if (S.size() > 0) json->Add("spectrum_S", Eigenvalues(S)).Add("null_S", NullDimension(S));
}

// The distance from the truth: as it is, and after alignment by a similarity of three cameras or more.
void AddErrors(const SceneGraph& graph, Json* json) {
  const Reconstruction truth = TruthOf(graph.scene), estimate = EstimateOf(graph.scene, graph.ba);
  for (const Transform& T : estimate.frames) {
    if (!T.p.allFinite()) return;  // Gauss-Newton accepts every finite cost
  }
  const Rmse as_it_stands = Compare(estimate, truth);
  json->Add("rmse_position", as_it_stands.position).Add("rmse_point", as_it_stands.point);
  const std::optional<Rmse> aligned = CompareAligned(estimate, truth);
  if (aligned) json->Add("rmse_position_aligned", aligned->position).Add("rmse_point_aligned", aligned->point);
}

}  // namespace

void SolvePanel(Query* query, Json* json) {
  const SceneSettings settings = ReadScene(query);
  if (!query->IsGood()) return;

  SceneGraph graph(settings);
  json->Add("truth", Truth(graph)).Add("start", Estimate(graph));
  const Summary summary = Minimize(MakeSystem(settings, &graph.ba.graph).get(), settings.options);
  json->Add("trace", Trace(summary)).Add("iterations", summary.iterations).Add("final_cost", summary.final_cost);
  json->Add("converged", IsConverged(summary.termination)).Add("termination", ToString(summary.termination));
  json->Add("estimate", Estimate(graph));
  AddCosts(graph.ba.graph, json);
  json->Add("residuals", Residuals(graph));
  AddErrors(graph, json);
  AddMatrices(settings, &graph, json);
}

}  // namespace ch5::lab
