#include "ch5_backend/lab/panels.h"

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

}  // namespace ch5::lab
