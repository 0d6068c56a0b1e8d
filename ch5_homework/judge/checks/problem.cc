/// problem.cc, stages 1.1, 1.2 and 2.

#include "ch5_homework/judge/checks/check.h"
#include "ch5_homework/judge/scenes/scene.h"

namespace ch5::homework {
namespace {

// Makes protected members reachable: `problem.*(&Access::b_)`.
struct Access : Problem {
  using Problem::b_;
  using Problem::b_pp_schur_;
  using Problem::Hessian_;
};

std::string Numbered(const char* name, Eigen::Index k) { return name + (" " + std::to_string(k)); }

// Again after a step of the states, if one is given.
void MakeHessian(const Submission& student, const Values& given, Answer* answer) {
  const auto scene = Scene::Make(given);
  const auto problem = student.make_problem(&scene->GetGraph());
  problem->MakeHessian();
  if (given.Has("step")) {
    answer->Put("H_before", problem->Hessian());
    answer->Put("b_before", problem->RightHandSide());
    problem->UpdateStates(VecX::Constant(problem->Size(), given.Number("step")));
    problem->MakeHessian();
  }
  answer->Put("H", problem->Hessian());
  answer->Put("b", problem->RightHandSide());
}

// H and b are given, so that stage 1.1 may be blank; the same ones for each λ, as the algorithm asks for it.
void SolveLinearSystem(const Submission& student, const Values& given, Answer* answer) {
  const auto scene = Scene::Make(given);
  const auto problem = student.make_problem(&scene->GetGraph());
  (*problem).*(&Access::Hessian_) = given["H"];
  (*problem).*(&Access::b_) = given.Vector("b");
  problem->SetDamping(static_cast<Damping>(given.Int("damping")));
  const VecX lambdas = given.Vector("lambdas");
  for (Eigen::Index k = 0; k < lambdas.size(); ++k) {
    VecX delta_x;
    const bool solved = problem->SolveLinearSystem(lambdas[k], &delta_x);
    answer->Put(Numbered("solved", k), solved);
    answer->Put(Numbered("delta_x", k), delta_x);
    answer->Put(Numbered("S", k), problem->SchurComplement());
    answer->Put(Numbered("b_S", k), (*problem).*(&Access::b_pp_schur_));
    answer->Put(Numbered("H", k), problem->Hessian());
    answer->Put(Numbered("b", k), problem->RightHandSide());
  }
}

void TestMarginalize(const Submission& student, const Values& given, Answer* answer) {
  const MarginalizeResult result =
      student.test_marginalize(given["H"], given.Vector("b"), given.Int("idx"), given.Int("dim"));
  answer->Put("H_moved", result.H_moved);
  answer->Put("b_moved", result.b_moved);
  answer->Put("H_prior", result.H_prior);
  answer->Put("b_prior", result.b_prior);
}

[[maybe_unused]] const bool added =
    (Linked()->make_problem = &Make<Problem, Problem>, Linked()->test_marginalize = &Problem::TestMarginalize,
     AddChecks({{"MakeHessian", &MakeHessian},
                {"SolveLinearSystem", &SolveLinearSystem},
                {"TestMarginalize", &TestMarginalize}}));

}  // namespace
}  // namespace ch5::homework
