/// Stages 1.1, 1.2 and 2 in the worker.

#include "ch5_homework/judge/remote/members.h"
#include "ch5_homework/judge/remote/remote.h"

namespace ch5::homework {
namespace {

/// A Problem whose two graded functions run in the worker, on a copy of the graph.
class RemoteProblem : public Problem {
 public:
  explicit RemoteProblem(Graph* graph) : Problem(graph), handle_(NewHandle()) {}

  void MakeHessian() override { Ask("MakeHessian", Pack(handle_, Numbers(), *this), static_cast<Problem*>(this)); }
  bool SolveLinearSystem(double lambda, VecX* delta_x) override {
    bool solved;
    Ask("SolveLinearSystem", Pack(handle_, Numbers(), *this, GetDamping(), lambda), &solved, delta_x,
        static_cast<Problem*>(this));
    return solved;
  }

 private:
  GraphNumbers Numbers() const { return NumbersOf(graph_->Vertices(), graph_->Edges()); }

  int handle_;
};

MarginalizeResult RemoteTestMarginalize(MatXX H_marg, VecX b_marg, int idx, int dim) {
  MarginalizeResult result;
  Ask("TestMarginalize", Pack(H_marg, b_marg, idx, dim), &result.H_moved, &result.b_moved, &result.H_prior,
      &result.b_prior);
  return result;
}

[[maybe_unused]] const bool added = [] {
  Linked()->make_problem = &Make<RemoteProblem>;
  Linked()->test_marginalize = &RemoteTestMarginalize;
  return true;
}();

}  // namespace
}  // namespace ch5::homework
