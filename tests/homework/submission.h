#pragma once
/// Whose homework is under test. The stage tests call the graded functions through a Submission, so that the same
/// tests judge the student's file, the reference, and a whole shelf of right and wrong fills in one executable.

#include <memory>
#include <string>

#include "ch5_backend/marginalize/marginalization_error.h"
#include "ch5_backend/solve/plain_block_solver.h"
#include "ch5_backend/solve/problem.h"
#include "ch5_backend/world/mono_ba.h"

namespace ch5::homework {

/// A MarginalizationError whose four graded functions are called one by one, on matrices that the test puts there.
class OkvisTerm {
 public:
  struct Members {
    MatXX *H, *J;
    VecX *b0, *e0;
    int* dense_size;
  };

  virtual ~OkvisTerm() = default;
  virtual Members Inside() = 0;
  virtual int InsertBlock(int dim, bool is_landmark) = 0;
  virtual void SchurComplement(const MatXX& V, const MatXX& W, const VecX& b_b, MatXX* U, VecX* b_a) = 0;
  virtual void UpdateErrorComputation() = 0;
  virtual VecX Residual(const VecX& delta_chi) = 0;
};

struct Submission {
  std::unique_ptr<Problem> (*make_problem)(Graph* graph);                        // stages 1.1 and 1.2
  MarginalizeResult (*test_marginalize)(MatXX H, VecX b, int idx, int dim);      // stage 2
  void (*add_mono_ba_edges)(const MonoBaScene& scene, double pixel_information,  // stage 3
                            double prior_weight, MonoBa* problem);
  std::unique_ptr<OkvisTerm> (*make_okvis_term)();                       // stage 5
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

/// For make_okvis_term: `M` is MarginalizationError or a class derived from it.
template <typename M>
class OkvisTermOf : public OkvisTerm, private M {
 public:
  Members Inside() override { return {&this->H_, &this->J_, &this->b0_, &this->e0_, &this->dense_size_}; }
  int InsertBlock(int dim, bool is_landmark) override { return M::InsertBlock(dim, is_landmark); }
  void SchurComplement(const MatXX& V, const MatXX& W, const VecX& b_b, MatXX* U, VecX* b_a) override {
    M::SchurComplement(V, W, b_b, U, b_a);
  }
  void UpdateErrorComputation() override { M::UpdateErrorComputation(); }
  VecX Residual(const VecX& delta_chi) override { return M::Residual(delta_chi); }
};
template <typename M>
std::unique_ptr<OkvisTerm> MakeOkvisTerm() {
  return std::make_unique<OkvisTermOf<M>>();
}

/// The one under test: the functions that are linked in, unless Choose has named another.
const Submission& Chosen();
/// @return false if no submission has this name
bool Choose(const std::string& name);
/// Before main.
bool Register(const std::string& name, const Submission& submission);

}  // namespace ch5::homework
