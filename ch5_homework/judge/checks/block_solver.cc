/// block_solver.cc, stage 7: S's pattern, the system, the step, and the whole minimization.

#include "ch5_backend/dense/blocks/plain_block_solver.h"
#include "ch5_homework/judge/checks/check.h"
#include "ch5_homework/judge/scenes/scene.h"

namespace ch5::homework {
namespace {

std::unique_ptr<PlainBlockSolver> Ordered(const Submission& student, Scene* scene) {
  auto solver = student.make_block_solver(&scene->GetGraph());
  solver->SetOrdering();  // calls BuildStructure
  return solver;
}

void BuildStructure(const Submission& student, const Values& given, Answer* answer) {
  const auto scene = Scene::Make(given);
  const auto blocks = Ordered(student, scene.get())->SchurPattern();
  MatXX pattern(2, blocks.size());
  Eigen::Index k = 0;
  for (const auto& [row, column] : blocks) pattern.col(k++) << row, column;
  answer->Put("pattern", pattern);
}

void BuildSystem(const Submission& student, const Values& given, Answer* answer) {
  const auto scene = Scene::Make(given);
  const auto solver = Ordered(student, scene.get());
  for (int k = 0; k < given.Int("times"); ++k) {
    solver->BuildSystem();
    answer->Put({{"b", solver->RightHandSide()}, {"H", solver->DenseHessian()}}, Numbered("", k));
  }
}

// The same solver with each λ and damping; finally the minimum from here, if requested.
void Solve(const Submission& student, const Values& given, Answer* answer) {
  const auto scene = Scene::Make(given);
  const auto solver = Ordered(student, scene.get());
  const VecX lambdas = given.Vector("lambdas"), dampings = given.Vector("dampings");
  for (Eigen::Index k = 0; k < lambdas.size(); ++k) {
    solver->SetDamping(static_cast<Damping>(static_cast<int>(dampings[k])));
    solver->BuildSystem();
    VecX delta_x;
    const bool solved = solver->Solve(lambdas[k], &delta_x);
    answer->Put({{"solved", solved},
                 {"delta_x", delta_x},
                 {"S", solver->SchurComplement()},
                 {"b_S", solver->ReducedRightHandSide()},
                 {"H", solver->DenseHessian()},
                 {"b", solver->RightHandSide()}},
                Numbered("", k));
  }
  if (!given.Has("minimize")) return;
  const Summary summary = Minimize(solver.get(), SolveOptions{});
  answer->Put(
      {{"converged", IsConverged(summary.termination)}, {"message", summary.message}, {"states", scene->States()}});
}

[[maybe_unused]] const bool added =
    (Linked()->make_block_solver = &Make<ch5::PlainBlockSolver, PlainBlockSolver>,
     AddChecks({{"BuildStructure", &BuildStructure}, {"BuildSystem", &BuildSystem}, {"Solve", &Solve}}));

}  // namespace
}  // namespace ch5::homework
