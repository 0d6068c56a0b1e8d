#include "ch5_backend/lab/panels.h"

#include <Eigen/LU>

#include "ch5_backend/math/chi_squared.h"

namespace ch5::lab {

std::string Answer(const std::string& text) {
  Query query(text);
  Json json;
  constexpr void (*kPanels[])(Query*, Json*) = {SolvePanel, StepsPanel, MarginalizePanel, WindowPanel, EliminatePanel};
  kPanels[query.Word("panel", {"solve", "steps", "marginalize", "window", "eliminate"})](&query, &json);
  if (query.IsGood()) return json.Text();
  const QueryFault& fault = *query.Fault();
  Json error;
  error.Add("error", fault.Sentence()).Add("setting", fault.setting).Add("value", fault.value);
  return error.Add("kind", fault.kind).Add("limits", fault.limits).Text();
}

Json ClaimJson(int number, const Vec3& p, const Vec3& truth, const Mat22& covariance) {
  const Vec2 error = (truth - p).head<2>();
  Json claim;
  claim.Add("number", number).Add("p", p).Add("error", VecX(error));
  claim.Add("covariance", VecX(Eigen::Map<const VecX>(covariance.data(), 4)));
  return claim.Add("chi2", error.dot(covariance.inverse() * error));
}

double ClaimLimit() { return ChiSquaredLimit(2, 0.05); }

}  // namespace ch5::lab
