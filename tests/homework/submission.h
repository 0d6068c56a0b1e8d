#pragma once
/// Whose homework is under test. The stage tests call the graded functions through a Submission, so that the same
/// tests judge the student's file, the reference, and a whole shelf of right and wrong fills in one executable.

#include <memory>
#include <string>

#include "ch5_backend/solve/plain_block_solver.h"
#include "ch5_backend/solve/problem.h"
#include "ch5_backend/world/mono_ba.h"

namespace ch5::homework {

struct Submission {
  std::unique_ptr<Problem> (*make_problem)(Graph* graph);                        // stages 1.1 and 1.2
  MarginalizeResult (*test_marginalize)(MatXX H, VecX b, int idx, int dim);      // stage 2
  void (*add_mono_ba_edges)(const MonoBaScene& scene, double pixel_information,  // stage 3
                            double prior_weight, MonoBa* problem);
  std::unique_ptr<PlainBlockSolver> (*make_block_solver)(Graph* graph);  // stage 7
};

/// For make_problem and make_block_solver: `P` is what they return, or a class derived from it.
template <typename P>
std::unique_ptr<Problem> Make(Graph* graph) {
  return std::make_unique<P>(graph);
}
template <typename P>
std::unique_ptr<PlainBlockSolver> MakeBlockSolver(Graph* graph) {
  return std::make_unique<P>(graph);
}

/// The one under test: the functions that are linked in, unless Choose has named another.
const Submission& Chosen();
/// @return false if no submission has this name
bool Choose(const std::string& name);
/// Before main.
bool Register(const std::string& name, const Submission& submission);

}  // namespace ch5::homework
