#include "ch5_backend/experiments/studies/matrices.h"
#include "ch5_backend/lab/panels.h"
#include "ch5_backend/lab/scene.h"
#include "ch5_backend/math/psd.h"

namespace ch5::lab {
namespace {

struct Variable {
  std::string kind;
  int number, rows;
};

/// H Δx = b, and which variable has which rows, in order.
struct System {
  MatXX H;
  VecX b;
  std::vector<Variable> variables;
};

// The chain of the slides and the handout, whose numbers can be worked out by hand.
System Chain() { return {SlidesChain(), Vec3(0.0, 5.0, 0.0), {{"scalar", 0, 1}, {"scalar", 1, 1}, {"scalar", 2, 1}}}; }

// The scene at its start, where Δx is Gauss-Newton's first step.
System Scene(const SceneSettings& settings) {
  SceneGraph graph(settings);
  Problem problem(&graph.ba.graph);
  problem.MakeHessian();
  System system{problem.Hessian(), problem.RightHandSide(), {}};
  int number = -1;
  for (const auto& pose : graph.ba.poses) {
    ++number;
    if (pose->OrderingId() >= 0) system.variables.push_back({"pose", number, pose->LocalDimension()});
  }
  number = 0;
  for (const auto& landmark : graph.ba.landmarks) {
    system.variables.push_back({"landmark", number++, landmark->LocalDimension()});
  }
  return system;
}

// Takes the variable at `position` out, by the function that students write. Returns its first row.
int Marginalize(size_t position, System* system) {
  int row = 0;
  for (size_t i = 0; i < position; ++i) row += system->variables[i].rows;
  const MarginalizeResult result =
      Problem::TestMarginalize(system->H, system->b, row, system->variables[position].rows);
  system->H = result.H_prior;
  system->b = result.b_prior;
  system->variables.erase(system->variables.begin() + static_cast<std::ptrdiff_t>(position));
  return row;
}

// The entries of H that remain, without the rows and columns [row, row + rows).
MatXX Without(const MatXX& H, int row, int rows) {
  const int rest = static_cast<int>(H.rows()) - row - rows;
  MatXX left(H.rows() - rows, H.cols() - rows);
  left << H.topLeftCorner(row, row), H.topRightCorner(row, rest), H.bottomLeftCorner(rest, row),
      H.bottomRightCorner(rest, rest);
  return left;
}

int NonZeros(const MatXX& H) { return static_cast<int>((H.array() != 0.0).count()); }

Json Shape(const System& system) {
  std::vector<Json> variables;
  int row = 0;
  for (const Variable& one : system.variables) {
    variables.push_back(VariableJson(one.kind, one.number, row, one.rows));
    row += one.rows;
  }
  Json json;
  json.Add("variables", variables).Add("size", static_cast<int>(system.H.rows()));
  json.Add("non_zeros", NonZeros(system.H));
  return json.Add("H", system.H).Add("b", system.b).Add("null", NullDimension(system.H));
}

}  // namespace

// `drop` lists positions among the variables that are left at that moment.
void MarginalizePanel(Query* query, Json* json) {
  const bool is_chain = query->Word("system", {"scene", "chain"}) == 1;
  const SceneSettings settings = ReadScene(query);
  const std::vector<int> drop = query->Numbers("drop", 0, 999);
  if (!query->IsGood()) return;

  System system = is_chain ? Chain() : Scene(settings);
  json->Add("before", Shape(system));
  const VecX full = PseudoInversePsd(system.H) * system.b;
  json->Add("delta_x_before", full);
  std::vector<int> non_zeros = {NonZeros(system.H)};
  MatXX fill = MatXX::Zero(system.H.rows(), system.H.cols());
  std::vector<Json> dropped;
  Json last;
  for (const int position : drop) {
    if (position >= static_cast<int>(system.variables.size()) || system.variables.size() == 1) break;
    const Variable variable = system.variables[static_cast<size_t>(position)];
    const MatXX old = system.H;
    last = Json().Add("H", system.H).Add("b", system.b);
    const int row = Marginalize(static_cast<size_t>(position), &system);
    last.Add("row", row);
    fill = ((Without(old, row, variable.rows).array() == 0.0) && (system.H.array() != 0.0)).cast<double>();
    dropped.push_back(Json().Add("kind", variable.kind).Add("number", variable.number));
    non_zeros.push_back(NonZeros(system.H));
  }
  json->Add("after", Shape(system)).Add("dropped", dropped).Add("non_zeros", non_zeros);
  if (!dropped.empty()) json->Add("last", last);
  json->Add("fill", fill).Add("filled", static_cast<int>(fill.sum()));
  json->Add("delta_x_after", VecX(PseudoInversePsd(system.H) * system.b)).Add("spectrum", Eigenvalues(system.H));
}

}  // namespace ch5::lab
