#pragma once
/// The student's solver of stage 7.

#include <memory>

#include "ch5_homework/judge/oracle.h"
#include "ch5_homework/judge/submission.h"

namespace ch5::homework {

// The student's solver; this is where BuildStructure runs.
inline std::unique_ptr<PlainBlockSolver> MakeSolver(Graph* graph) {
  auto solver = Chosen().make_block_solver(graph);
  solver->SetOrdering();
  return solver;
}

}  // namespace ch5::homework
