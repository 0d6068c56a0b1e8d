
#include "ch5_backend/lab/panels.h"
#include "ch5_backend/lab/scene.h"

namespace ch5::lab {
namespace {

/// What the loop has asked of the system between two trials, in the order of the loop.
struct Trial {
  int iteration = 0;
  double cost = 0.0;       // before the step
  double lambda = 0.0;     // of the last solve
  bool is_solved = false;  // else H + λD was not positive definite
  MatXX S;                 // damped
  VecX delta_x;
  double predicted = 0.0;  // decrease
  double new_cost = 0.0;
  bool is_accepted = false;
  Json linearized_at, moved_to, observation;
  MatXX H;
  VecX b;
};

// What an observation adds to H and b, in numbers: r and its Jacobians by the inverse depth and by the camera that sees it.
Json Linearized(const Observation& one) {
  Json json;
  json.Add("landmark", one.landmark).Add("frame", one.frame).Add("r", VecX(one.edge->Residual()));
  json.Add("W", one.edge->Information()(0, 0)).Add("J_landmark", MatXX(one.edge->Jacobian(0)));
  return json.Add("J_pose", MatXX(one.edge->Jacobian(2)));
}

/// Stands between the algorithm and the dense solver, and writes down what passes: the loop is Minimize's own.
class LoggedSystem : public NormalEquations {
 public:
  explicit LoggedSystem(const SceneSettings& settings, SceneGraph* graph) : graph_(*graph), problem_(&graph->ba.graph) {
    SetDamping(settings.damping);
    problem_.SetDamping(settings.damping);
  }

  const std::vector<Trial>& Trials() const { return trials_; }
  const Problem& System() const { return problem_; }

  void SetOrdering() override { problem_.SetOrdering(); }
  int Size() const override { return problem_.Size(); }
  double Cost() override {
    const double cost = problem_.Cost();
    if (is_moved_) trials_.back().new_cost = cost;
    now_.cost = trials_.empty() ? cost : now_.cost;
    return cost;
  }
  void MakeHessian() override {
    Settle();
    problem_.MakeHessian();
    now_.H = problem_.Hessian();
    now_.b = problem_.RightHandSide();
    now_.linearized_at = Estimate(graph_);
    const std::vector<Observation> observations = ObservationsOf(graph_);
    if (!observations.empty()) {
      observations.back().edge->Linearize();  // the solver has kept its Jacobians to itself
      now_.observation = Linearized(observations.back());
    }
    ++now_.iteration;
  }
  bool SolveLinearSystem(double lambda, VecX* delta_x) override {
    now_.lambda = lambda;
    now_.is_solved = problem_.SolveLinearSystem(lambda, delta_x);
    now_.S = problem_.SchurComplement();
    if (!now_.is_solved) trials_.push_back(now_);
    return now_.is_solved;
  }
  double ModelCostChange(const VecX& delta_x) const override { return predicted_ = problem_.ModelCostChange(delta_x); }
  void UpdateStates(const VecX& delta_x) override {
    problem_.UpdateStates(delta_x);
    trials_.push_back(now_);
    trials_.back().delta_x = delta_x;
    trials_.back().predicted = predicted_;
    trials_.back().moved_to = Estimate(graph_);
    trials_.back().is_accepted = is_moved_ = true;
  }
  void RollbackStates() override {
    problem_.RollbackStates();
    trials_.back().is_accepted = is_moved_ = false;
  }
  const VecX& RightHandSide() const override { return problem_.RightHandSide(); }
  VecX HessianDiagonal() const override { return problem_.HessianDiagonal(); }
  VecX MultiplyHessian(const VecX& v) const override { return problem_.MultiplyHessian(v); }
  double StateNorm() const override { return problem_.StateNorm(); }

 private:
  // A step that has not been taken back by the next linearization was accepted.
  void Settle() {
    if (is_moved_) now_.cost = trials_.back().new_cost;
    is_moved_ = false;
  }

  SceneGraph& graph_;
  Problem problem_;
  Trial now_;  // of the present linearization
  mutable double predicted_ = 0.0;
  bool is_moved_ = false;
  std::vector<Trial> trials_;
};

// Where the model predicts less than a millionth of the cost, the rounding of the cost decides about the gain ratio: it
// is not given then.
Json Row(const Trial& trial) {
  Json row;
  row.Add("iteration", trial.iteration).Add("cost", trial.cost).Add("lambda", trial.lambda);
  row.Add("solved", trial.is_solved)
      .Add("accepted", trial.is_accepted)
      .Add("gradient", trial.b.lpNorm<Eigen::Infinity>());
  if (!trial.is_solved) return row;
  const double decrease = trial.cost - trial.new_cost;
  row.Add("predicted", trial.predicted).Add("decrease", decrease).Add("step", trial.delta_x.norm());
  if (trial.predicted > 1e-6 * trial.cost) row.Add("gain", decrease / trial.predicted);
  return row;
}

// What a trial adds to the diagonal of H.
VecX Damping(const LoggedSystem& system, const Trial& trial) {
  return trial.H.diagonal().unaryExpr([&](double H_ii) { return trial.lambda * system.DampingEntry(H_ii); });
}

}  // namespace

void StepsPanel(Query* query, Json* json) {
  const SceneSettings settings = ReadScene(query);
  const int wanted = query->Whole("trial", 0, 0, 999);
  query->Word("stop", {"linearize", "build", "damp", "eliminate", "solve", "step", "judge"});  // which the page shows
  if (!query->IsGood()) return;

  SceneGraph graph(settings);
  json->Add("truth", Truth(graph)).Add("start", Estimate(graph));
  LoggedSystem system(settings, &graph);
  const Summary summary = Minimize(&system, settings.options);
  std::vector<Json> rows;
  for (const Trial& trial : system.Trials()) rows.push_back(Row(trial));
  json->Add("variables", VariablesOf(graph)).Add("pose_rows", system.System().GetOrdering().dim_poses);
  json->Add("trials", rows).Add("termination", ToString(summary.termination)).Add("final_cost", summary.final_cost);
  if (rows.empty()) return;
  const int last = static_cast<int>(rows.size()) - 1;
  const Trial& trial = system.Trials()[static_cast<size_t>(std::min(wanted, last))];
  json->Add("trial", std::min(wanted, last)).Add("H", trial.H).Add("b", trial.b).Add("S", trial.S);
  json->Add("damping", Damping(system, trial)).Add("linearized_at", trial.linearized_at);
  json->Add("observation", trial.observation);
  if (trial.is_solved) json->Add("delta_x", trial.delta_x).Add("moved_to", trial.moved_to);
}

}  // namespace ch5::lab
