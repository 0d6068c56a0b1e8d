#include "ch5_backend/lab/panels.h"

namespace ch5::lab {

std::string Answer(const std::string& text) {
  Query query(text);
  Json json;
  constexpr void (*kPanels[])(Query*, Json*) = {SolvePanel, StepsPanel, MarginalizePanel, WindowPanel};
  kPanels[query.Word("panel", {"solve", "steps", "marginalize", "window"})](&query, &json);
  return query.IsGood() ? json.Text() : Json().Add("error", query.Fault()).Text();
}

}  // namespace ch5::lab
