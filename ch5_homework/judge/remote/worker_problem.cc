/// Stages 1.1, 1.2 and 2.

#include "ch5_homework/judge/remote/members.h"
#include "ch5_homework/judge/remote/worker.h"

namespace ch5::homework {
namespace {

struct KeptProblem {
  std::unique_ptr<WireGraph> graph;
  std::unique_ptr<Problem> problem;
};

// The problem of the judge's handle, with the judge's numbers.
Problem* ReadProblem(Reader* in) {
  int handle;
  GraphNumbers numbers;
  Unpack(in, &handle, &numbers);
  KeptProblem& kept = Kept<KeptProblem>()[handle];
  if (kept.problem) {
    kept.graph->Refresh(numbers);
  } else {
    kept.graph = std::make_unique<WireGraph>(numbers);
    kept.problem = Chosen().make_problem(kept.graph->Get());
  }
  *in >> *kept.problem;
  return kept.problem.get();
}

void MakeHessian(Reader* in, Writer* out) {
  Problem* problem = ReadProblem(in);
  problem->MakeHessian();
  *out << *problem;
}

void SolveLinearSystem(Reader* in, Writer* out) {
  Problem* problem = ReadProblem(in);
  Damping damping;
  double lambda;
  Unpack(in, &damping, &lambda);
  problem->SetDamping(damping);
  VecX delta_x;
  const bool solved = problem->SolveLinearSystem(lambda, &delta_x);
  *out << solved << delta_x << *problem;
}

void TestMarginalize(Reader* in, Writer* out) {
  MatXX H;
  VecX b;
  int idx, dim;
  Unpack(in, &H, &b, &idx, &dim);
  const MarginalizeResult result = Chosen().test_marginalize(H, b, idx, dim);
  *out << result.H_moved << result.b_moved << result.H_prior << result.b_prior;
}

[[maybe_unused]] const bool added = Handle("MakeHessian", &MakeHessian) &&
                                    Handle("SolveLinearSystem", &SolveLinearSystem) &&
                                    Handle("TestMarginalize", &TestMarginalize);

}  // namespace
}  // namespace ch5::homework
