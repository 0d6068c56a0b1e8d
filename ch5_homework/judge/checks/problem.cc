/// problem.cc, stages 1.1, 1.2 and 2.

#include "ch5_backend/dense/problem.h"
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

// Again after a step of the states, if one is given.
void MakeHessian(const Submission& student, const Values& given, Answer* answer) {
  const auto scene = Scene::Make(given);
  const auto problem = student.make_problem(&scene->GetGraph());
  problem->MakeHessian();
  if (given.Has("step")) {
    answer->Put({{"H_before", problem->Hessian()}, {"b_before", problem->RightHandSide()}});
    problem->UpdateStates(VecX::Constant(problem->Size(), given.Number("step")));
    problem->MakeHessian();
  }
  answer->Put({{"H", problem->Hessian()}, {"b", problem->RightHandSide()}});
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
    answer->Put({{"solved", solved},
                 {"delta_x", delta_x},
                 {"S", problem->SchurComplement()},
                 {"b_S", (*problem).*(&Access::b_pp_schur_)},
                 {"H", problem->Hessian()},
                 {"b", problem->RightHandSide()}},
                Numbered("", k));
  }
}

void TestMarginalize(const Submission& student, const Values& given, Answer* answer) {
  const MarginalizeResult result =
      student.test_marginalize(given["H"], given.Vector("b"), given.Int("idx"), given.Int("dim"));
  answer->Put({{"H_moved", result.H_moved},
               {"b_moved", result.b_moved},
               {"H_prior", result.H_prior},
               {"b_prior", result.b_prior}});
}

[[maybe_unused]] const bool added =
    (Linked()->make_problem = &Make<ch5::Problem, Problem>, Linked()->test_marginalize = &Problem::TestMarginalize,
     AddChecks({{"MakeHessian", &MakeHessian},
                {"SolveLinearSystem", &SolveLinearSystem},
                {"TestMarginalize", &TestMarginalize}}));

}  // namespace
}  // namespace ch5::homework
