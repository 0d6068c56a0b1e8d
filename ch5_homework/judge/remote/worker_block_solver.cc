/// Stage 7.

#include "ch5_homework/judge/remote/members.h"
#include "ch5_homework/judge/remote/worker.h"

namespace ch5::homework {
namespace {

struct KeptSolver {
  std::unique_ptr<WireGraph> graph;
  std::unique_ptr<PlainBlockSolver> solver;
};

Blocks BlocksOf(const SparseBlocks& blocks) { return {blocks.All().begin(), blocks.All().end()}; }

SolverNumbers NumbersOf(const PlainBlockSolver& solver) {
  return {BlocksOf(solver.*(&SolverMembers::H_pp_)),
          BlocksOf(solver.*(&SolverMembers::H_pl_)),
          BlocksOf(solver.*(&SolverMembers::H_ll_)),
          BlocksOf(solver.*(&SolverMembers::S_)),
          solver.*(&SolverMembers::b_),
          solver.*(&SolverMembers::b_schur_)};
}

// The solver of the judge's handle, its graph with the judge's numbers.
PlainBlockSolver* ReadSolver(Reader* in) {
  int handle;
  GraphNumbers numbers;
  Unpack(in, &handle, &numbers);
  KeptSolver& kept = Kept<KeptSolver>()[handle];
  if (kept.solver) {
    kept.graph->Refresh(numbers);
  } else {
    kept.graph = std::make_unique<WireGraph>(numbers);
    kept.solver = Chosen().make_block_solver(kept.graph->Get());
  }
  return kept.solver.get();
}

void BuildStructure(Reader* in, Writer* out) {
  PlainBlockSolver* solver = ReadSolver(in);
  solver->SetOrdering();  // calls it
  *out << NumbersOf(*solver);
}

void BuildSystem(Reader* in, Writer* out) {
  PlainBlockSolver* solver = ReadSolver(in);
  solver->BuildSystem();
  *out << NumbersOf(*solver);
}

void Solve(Reader* in, Writer* out) {
  PlainBlockSolver* solver = ReadSolver(in);
  Damping damping;
  double lambda;
  Unpack(in, &damping, &lambda);
  solver->SetDamping(damping);
  VecX delta_x;
  const bool solved = solver->Solve(lambda, &delta_x);
  *out << solved << delta_x << NumbersOf(*solver);
}

[[maybe_unused]] const bool added =
    Handle("BuildStructure", &BuildStructure) && Handle("BuildSystem", &BuildSystem) && Handle("Solve", &Solve);

}  // namespace
}  // namespace ch5::homework
